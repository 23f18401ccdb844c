"""What is recorded of a run, and the numbers that are drawn from it."""

from __future__ import annotations

from dataclasses import dataclass

from warp_mps.scene.motions import Vector
from warp_mps.shapes import Shape


@dataclass(frozen=True, kw_only=True)
class Probe:
    """A quantity recorded through the run: at a point, averaged over a region, of a body or wall, or of a support.

    Exactly one of `point`, `region`, `body` and `support` is given; `PROBE_QUANTITIES` lists what each can record
    (a region records the mean of what a point does, and a wall has the `WALL_QUANTITIES`). In a scene of fluids points
    and regions stay where they are while the fluid goes through them, and have the `FLUID_QUANTITIES`, as a fluid has;
    `warp_mps.observers.fluid_sampling` defines these. A rotation is that of a
    rotation vector: its angle lies between -pi and pi, with the springs model in 2-D between -4 pi and 4 pi.
    `warp_mps.elastic.output.stresses` defines stress and strain; `strain_energy` is per reference volume.

    A section is the cut around a region's particles: `section_force` is the force that the rest of their bodies exerts
    on them through it, the sum of the elastic and viscous forces on them, and `section_moment` its moment about the
    point `about`, which moves with the body. Contact, loads, weight and supports have no part in them.

    A `contact_force` on a wall is that of the bodies or the fluid that touch it, and `contact_moment` its moment about
    the point `about`, which moves with the wall. `lowest` and `highest` are the bounds of the space that a body's
    particles, half a spacing wide to each side, take up along every axis, and `extent` their difference.

    Attributes:
        name: Name, the column of probes.csv.
        quantity: What is recorded.
        point: Point of the undeformed scene, inside a body [m]; in a scene of fluids any point.
        region: Shape over whose particles the mean is taken.
        body: Name of a body, a wall or a fluid.
        support: Name of a support.
        about: Point of the undeformed scene about which a moment is taken [m], of a `section_moment` inside a body.
        moves_with: In a scene of fluids, name of the wall that the point is fixed to; None leaves it where it is.
        path: Where it was described, for error messages.
    """

    name: str
    quantity: str = "displacement"
    point: Vector | None = None
    region: Shape | None = None
    body: str | None = None
    support: str | None = None
    about: Vector | None = None
    moves_with: str | None = None
    path: str = ""

    @property
    def where(self) -> str:
        """The kind of place it records at, a key of `PROBE_QUANTITIES`."""
        return next((kind for kind in ("body", "support", "region") if getattr(self, kind) is not None), "point")


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """A number drawn from a probe's history after the run, beside the value it should have.

    Attributes:
        name: Name of the result, e.g. ``first mode``.
        measure: How it is drawn, one of `MEASURES` (`warp_mps.results.measures` defines each).
        probe: Name of the probe.
        component: Component of the probe, counted from 0; `warp_mps.scene.components` gives their order.
        unit: Unit of the value, for display; ``Hz`` makes a ``frequency`` cycles a second, else it is in rad/s.
        reference: The value to expect, if one is known.
        source: Where the reference comes from.
        start: Beginning of the history that is used [s].
        end: End of the history that is used [s]; None is the end of the run.
        frequency: Frequency of the harmonic measures [Hz].
        at: The time of ``value_at`` [s], the value of ``time_at`` in the unit of its probe.
    """

    name: str
    measure: str
    probe: str
    component: int = 0
    unit: str = ""
    reference: float | None = None
    source: str = ""
    start: float = 0.0
    end: float | None = None
    frequency: float = 0.0
    at: float | None = None
    path: str = ""

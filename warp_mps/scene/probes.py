"""Probes, and the measurements that are drawn from their histories."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_mps.scene.choices import MeasureName, QuantityName
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.motions import Vector
from warp_mps.scene.record import Record
from warp_mps.shapes import Shape


@described
@dataclass(frozen=True, kw_only=True)
class Probe(Record):
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
    """

    name: str = field(metadata=attribute(text="label"))
    """Name, the column of probes.csv."""
    quantity: QuantityName = field(default="displacement", metadata=attribute("mps:quantity"))
    """Recorded quantity, one of those that its place has."""
    point: Vector | None = field(default=None, metadata=attribute(unit="m"))
    """Point of the undeformed scene, inside a body; in a scene of fluids any point."""
    region: Shape | None = None
    """Shape over whose particles the mean is taken."""
    body: str | None = None
    """Name of a body, a wall or a fluid."""
    support: str | None = None
    """Name of a support."""
    about: Vector | None = field(default=None, metadata=attribute("mps:about", unit="m", nature="point"))
    """Point of the undeformed scene about which a moment is taken: of a `section_moment` inside a body, of a
    `contact_moment` anywhere."""
    moves_with: str | None = field(default=None, metadata=attribute("mps:movesWith", refers_to="wall"))
    """In a scene of fluids, the wall that the point is fixed to; it stays where it is if not given."""
    path: str = ""
    """Where it was described, for error messages."""

    @property
    def where(self) -> str:
        """The kind of place it records at, a key of `PROBE_QUANTITIES`."""
        return next((kind for kind in ("body", "support", "region") if getattr(self, kind) is not None), "point")


@described
@dataclass(frozen=True, kw_only=True)
class Measurement(Record):
    """A number drawn from a probe's history after the run, beside the value it should have."""

    name: str = field(metadata=attribute(text="label"))
    """Name of the result, such as ``first mode``."""
    measure: MeasureName = field(metadata=attribute("mps:measure"))
    """How the number is drawn from the history of the probe (`warp_mps.results.measures` defines each)."""
    probe: str = field(metadata=attribute("mps:probe", refers_to="probe"))
    """The probe."""
    component: int = 0
    """Component of the probe, counted from 0; `warp_mps.scene.components` gives their order."""
    unit: str = field(default="", metadata=attribute("mps:unit"))
    """SI unit of the value, for display; `Hz` makes a `frequency` cycles a second, else it is in rad/s."""
    reference: float | None = field(default=None, metadata=attribute("mps:reference"))
    """Expected value, if one is known, in the unit of the measurement, which is an SI unit."""
    source: str = field(default="", metadata=attribute("mps:source"))
    """Source of the reference."""
    start: float = field(default=0.0, metadata=attribute("mps:start", unit="s"))
    """Beginning of the history that is used."""
    end: float | None = field(default=None, metadata=attribute("mps:end", unit="s", finite=False))
    """End of the history that is used; the end of the run if not given."""
    frequency: float = field(default=0.0, metadata=attribute("mps:frequency", unit="Hz"))
    """Frequency of the harmonic measures."""
    at: float | None = field(default=None, metadata=attribute("mps:at"))
    """Time of `value_at`, in s; value of `time_at`, in the SI unit of its probe."""
    path: str = ""
    """Where it was described, for error messages."""

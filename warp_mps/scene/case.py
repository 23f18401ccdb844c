"""The scene: a whole case."""

from __future__ import annotations

from dataclasses import dataclass

from warp_mps.scene.actions import Load, Support
from warp_mps.scene.bodies import Body, Fluid, Wall
from warp_mps.scene.body_force import BodyForce
from warp_mps.scene.materials import Material
from warp_mps.scene.motions import Vector
from warp_mps.scene.numerics import Contact, Elasticity, Flow, StageFrame
from warp_mps.scene.probes import Measurement, Probe


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A case: everything that a run needs to know, in SI units.

    Attributes:
        name: Name of the case.
        description: What it is, in a line or more.
        bodies: Elastic bodies; none in a scene of fluids.
        duration: Simulated time [s].
        dimension: 2 or 3.
        plane: ``strain`` or ``stress``, in 2-D.
        gravity: Acceleration of gravity [m/s^2], shape [dimension].
        fluids: Bodies of liquid.
        walls: Rigid bodies, at rest or moved.
        supports: Held regions.
        loads: Forces.
        body_forces: Forces per mass that depend on place and time; they cannot be saved in a stage.
        probes: Recorded quantities.
        measurements: Numbers drawn from the probes, with their references.
        elasticity: The elastic model.
        contact: Contact between bodies.
        flow: How fluids are computed.
        damping: Mass-proportional damping: force -damping * m * v, and likewise a torque where particles rotate [1/s].
        outputs: What frames of bodies hold beside positions, velocities and pressure, names of `OUTPUTS`.
        frame_rate: Saved frames per simulated second [1/s].
        sample_rate: Rows of probes.csv per simulated second, a multiple of `frame_rate` [1/s]; None is `frame_rate`.
        time_step: Time step [s]; None derives it from `courant`. Frames and rows then come every so many whole steps,
            as near to their rates as that allows.
        analysis: ``dynamic``, or ``static``: equilibrium under loads, weight and moving supports, which grow together
            with the load factor. The load factor stands for the time, from 0 to `duration`; 1 is all of them.
        load_steps: Increments in which a static load grows to all of it; each makes a frame and a row.
        integrator: ``explicit``, or ``implicit``: steps of any length by the theta rule, of `time_step` or those of the
            water about the bodies. ``auto`` is explicit for bodies alone; in water see
            `warp_mps.coupling.integrator_choice`.
        theta: Theta of that rule: 0.5 keeps the energy, 1 damps most (`warp_mps.elastic.implicit.theta_rule`). Explicit
            steps in water are damped as much (`warp_mps.coupling.integrator_choice`).
        courant: Time step in units of l0 / c_p, c_p the speed of pressure waves [-], and at most 0.9
            of what is stable for small deformations.
        stage: How the scene lies in its stage; None is the x-y plane, or x, y, z in 3-D, of a stage in SI units.
        path: Where it was described, for error messages.

    Raises:
        InputError: Something in it is not allowed; see `warp_mps.scene.validation.scene`.
    """

    bodies: tuple[Body, ...] = ()
    duration: float
    name: str = "case"
    description: str = ""
    dimension: int = 2
    plane: str = "strain"
    gravity: Vector = ()
    fluids: tuple[Fluid, ...] = ()
    walls: tuple[Wall, ...] = ()
    supports: tuple[Support, ...] = ()
    loads: tuple[Load, ...] = ()
    body_forces: tuple[BodyForce, ...] = ()
    probes: tuple[Probe, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    elasticity: Elasticity = Elasticity()
    contact: Contact = Contact()
    flow: Flow = Flow()
    damping: float = 0.0
    outputs: tuple[str, ...] = ()
    frame_rate: float = 100.0
    sample_rate: float | None = None
    time_step: float | None = None
    analysis: str = "dynamic"
    load_steps: int = 10
    integrator: str = "auto"
    theta: float = 0.55
    courant: float = 0.25
    stage: StageFrame | None = None
    path: str = "scene"

    def __post_init__(self) -> None:
        from warp_mps.scene.validation.scene import check_scene

        check_scene(self)

    @property
    def implicit(self) -> bool:
        """Whether equations are solved for the displacements of its elastic bodies."""
        return self.analysis == "static" or self.integrator == "implicit"

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of its bodies, one body after the other; `Particles.materials` counts in it."""
        return tuple(material for body in self.bodies for material in body.materials)

    @property
    def frame(self) -> StageFrame:
        """How the scene lies in its stage."""
        return self.stage or StageFrame(axes="xyz"[: self.dimension])

    @property
    def filled(self) -> tuple[Body | Wall | Fluid, ...]:
        """What is filled with particles: bodies, then walls, then fluids."""
        return (*self.bodies, *self.walls, *self.fluids)

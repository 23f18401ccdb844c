"""The scene: a whole case."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_mps.scene.actions import Load, Support
from warp_mps.scene.bodies import Body, Fluid, Wall
from warp_mps.scene.body_force import BodyForce
from warp_mps.scene.choices import AnalysisName, IntegratorName, OutputName, PlaneModelName
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.materials import Material
from warp_mps.scene.motions import Vector
from warp_mps.scene.numerics import Contact, Elasticity, Flow, StageFrame
from warp_mps.scene.probes import Measurement, Probe
from warp_mps.scene.record import Record


@described
@dataclass(frozen=True, kw_only=True)
class Scene(Record):
    """A case: everything that a run needs to know, in SI units.

    Raises:
        InputError: Something in it is not allowed; see `warp_mps.scene.validation.scene`.
    """

    bodies: tuple[Body, ...] = ()
    """Elastic bodies; may be empty in a scene of fluids."""
    duration: float = field(metadata=attribute("mps:duration", unit="s", above=0.0))
    """Simulated time."""
    name: str = "case"
    """Name of the case."""
    description: str = ""
    """Description of the case, a line or more."""
    dimension: int = field(default=2, metadata=attribute("mps:dimension", allowed=(2, 3), stage_default=3))
    """Number of dimensions."""
    plane: PlaneModelName = field(default="strain", metadata=attribute("mps:planeModel"))
    """Plane strain or plane stress, in 2-D."""
    gravity: Vector = field(default=(), metadata=attribute(unit="m/s^2"))
    """Acceleration of gravity, shape [dimension]; no gravity if empty."""
    fluids: tuple[Fluid, ...] = ()
    """Bodies of liquid."""
    walls: tuple[Wall, ...] = ()
    """Rigid bodies, at rest or moved as prescribed."""
    supports: tuple[Support, ...] = ()
    """Held regions."""
    loads: tuple[Load, ...] = ()
    """Forces."""
    body_forces: tuple[BodyForce, ...] = ()
    """Forces per mass that depend on place and time; they cannot be saved in a stage."""
    probes: tuple[Probe, ...] = ()
    """Recorded quantities."""
    measurements: tuple[Measurement, ...] = ()
    """Numbers drawn from the probes, with their references."""
    elasticity: Elasticity = Elasticity()
    """The elastic model."""
    contact: Contact = Contact()
    """Contact between bodies."""
    flow: Flow = Flow()
    """How fluids are computed."""
    damping: float = field(default=0.0, metadata=attribute("mps:damping", unit="1/s", minimum=0.0))
    """Mass-proportional damping of bodies: a force -damping * m * v, and likewise a torque where particles rotate."""
    outputs: tuple[OutputName, ...] = field(default=(), metadata=attribute("mps:outputs"))
    """What frames of bodies hold beside positions, velocities and pressure."""
    frame_rate: float = field(default=100.0, metadata=attribute("mps:frameRate", unit="1/s", above=0.0))
    """Saved frames per simulated second."""
    sample_rate: float | None = field(default=None, metadata=attribute("mps:sampleRate", unit="1/s", above=0.0))
    """Rows of probes.csv per simulated second, a whole multiple of `frame_rate`, and equal to it if not given. Steps
    end at rows: a higher rate may make steps shorter, and so change the result within the error of the time
    integration; `warp-mps check` tells what limits the step."""
    time_step: float | None = field(default=None, metadata=attribute("mps:timeStep", unit="s", above=0.0))
    """Time step of bodies; derived from `courant` if not given. Frames and rows are then written every whole number of
    steps, as near to their rates as that allows. Fluids: an upper limit beside that of `flow.courant`."""
    analysis: AnalysisName = field(default="dynamic", metadata=attribute("mps:analysis"))
    """Motion in time, or static equilibrium under loads, weight and moving supports, which grow together with the load
    factor. The load factor takes the place of the time, from 0 to `duration`; at 1 the loads are complete."""
    load_steps: int = field(default=10, metadata=attribute("mps:loadSteps", minimum=1))
    """Static analysis: increments to the complete load; each writes a frame and a row."""
    integrator: IntegratorName = field(default="auto", metadata=attribute("mps:integrator"))
    """Time integration of elastic bodies: explicit, or implicit by the theta rule with steps of any length, `time_step`
    or those of the fluid about them. `auto` is explicit for bodies alone, and in fluids where there is contact, a
    viscosity, or the springs model (`warp_mps.coupling.integrator_choice`)."""
    theta: float = field(default=0.55, metadata=attribute("mps:theta", minimum=0.5, maximum=1.0))
    """Theta of the theta rule: 0.5 conserves energy, 1 damps most; explicit steps in fluids are damped as much."""
    courant: float = field(default=0.25, metadata=attribute("mps:courant", above=0.0))
    """CFL number of bodies: time step in units of spacing / speed of pressure waves, and at most 0.9 of what is stable
    for small deformations."""
    stage: StageFrame | None = None
    """How the scene lies in its stage; None is the x-y plane, or x, y, z in 3-D, of a stage in SI units."""
    path: str = "scene"
    """Where it was described, for error messages."""
    remarks: tuple[str, ...] = field(default=(), repr=False, compare=False)
    """What was doubtful where it was described, a line each: a check and a run show it."""

    def __post_init__(self) -> None:
        from warp_mps.scene.validation.scene import check_scene

        super().__post_init__()
        check_scene(self)

    @property
    def gravity_vector(self) -> np.ndarray:
        """Acceleration of gravity [m/s^2], zeros without gravity, shape [dimension]."""
        return np.asarray(self.gravity if len(self.gravity) else np.zeros(self.dimension), float)

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
        return self.stage or StageFrame(axes="xy" if self.dimension == 2 else "xyz")

    @property
    def filled(self) -> tuple[Body | Wall | Fluid, ...]:
        """The items that are filled with particles: bodies, then walls, then fluids."""
        return (*self.bodies, *self.walls, *self.fluids)

"""What a person describes: bodies, walls, materials, supports, loads, probes and the answers to expect.

A :class:`Scene` is plain data in SI units. It knows neither Warp nor USD: `warp_mps.usd` reads one from a stage and
saves it as one, `warp_mps.particles` fills it with particles. A 2-D scene lies in the x-y plane of its own
coordinates; quantities are then per metre of depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from warp_mps.shapes import Shape

Vector = Sequence[float]

ELASTIC_MODELS = ("hamiltonian", "springs")
LAWS = ("st_venant_kirchhoff", "neo_hookean")
NORMALIZATIONS = ("lattice", "particle")
PLANE_MODELS = ("strain", "stress")
ANALYSES = ("dynamic", "static")
INTEGRATORS = ("explicit", "implicit")
CONTACTS = ("none", "bodies", "all")
INTERPOLATIONS = ("linear", "cubic")
WALL_SLIPS = ("free", "no")
_SHAPE = ("amplitude", "axis", "origin", "length")
# what each kind of velocity field needs
VELOCITY_FIELD_PARTS = {
    "sine": _SHAPE,
    "free_free_beam": _SHAPE,
    "clamped_free_beam": _SHAPE,
    "twist": ("rate", "axis", "origin", "length"),
    "stagnation": ("rate", "axis", "origin"),
    "taylor_green": _SHAPE,
    "standing_wave": (*_SHAPE, "depth"),
}
VELOCITY_FIELDS = tuple(VELOCITY_FIELD_PARTS)
# those that have modes
MODAL_FIELDS = VELOCITY_FIELDS[:4]
FLUID_SCHEMES = ("conservative", "corrected", "koshizuka_oka")
NEGATIVE_PRESSURES = ("clipped", "allowed")
OUTPUTS = ("stress", "strain", "von_mises", "strain_energy")
_FIELDS = ("position", "displacement", "velocity", "rotation", "pressure", *OUTPUTS)
_WHOLE = ("position", "displacement", "velocity", "extent", "lowest", "highest")
_MASSIVE = ("momentum", "angular_momentum", "kinetic_energy")
PROBE_QUANTITIES = {
    "point": _FIELDS,
    "region": (*_FIELDS, "section_force", "section_moment"),
    "body": (*_WHOLE, *_MASSIVE, "contact_force"),
    "support": ("reaction",),
}
# what a probe can record of a wall, which has no mass, and in a scene of fluids
WALL_QUANTITIES = (*_WHOLE, "contact_force", "contact_moment")
FLUID_QUANTITIES = {
    "point": ("pressure", "velocity", "elevation"),
    "region": ("pressure", "velocity"),
    "body": ("position", "velocity", "extent", "lowest", "highest", *_MASSIVE, "volume"),
    "support": (),
}
# those that are taken about a point
ABOUT_QUANTITIES = ("section_moment", "contact_moment")
# unit of each quantity in 2-D, per metre of depth where it is extensive, and in 3-D
PROBE_UNITS = {
    "position": ("m", "m"),
    "displacement": ("m", "m"),
    "velocity": ("m/s", "m/s"),
    "rotation": ("rad", "rad"),
    "pressure": ("Pa", "Pa"),
    "elevation": ("m", "m"),
    "extent": ("m", "m"),
    "lowest": ("m", "m"),
    "highest": ("m", "m"),
    "momentum": ("kg/s", "kg m/s"),
    "angular_momentum": ("kg m/s", "kg m^2/s"),
    "kinetic_energy": ("J/m", "J"),
    "volume": ("m^2", "m^3"),
    "contact_force": ("N/m", "N"),
    "contact_moment": ("N", "N m"),
    "reaction": ("N/m", "N"),
    "stress": ("Pa", "Pa"),
    "strain": ("-", "-"),
    "von_mises": ("Pa", "Pa"),
    "strain_energy": ("J/m^3", "J/m^3"),
    "section_force": ("N/m", "N"),
    "section_moment": ("N", "N m"),
}
MEASURES = (
    "frequency",
    "period",
    "amplitude",
    "offset",
    "mean",
    "minimum",
    "maximum",
    "midrange",
    "half_range",
    "final",
    "restitution",
    "contact_time",
    "harmonic_amplitude",
    "harmonic_phase",
    "value_at",
    "time_at",
)
# measures that need `Measurement.at`
AT_MEASURES = ("value_at", "time_at")


# units of what is not in the unit of its probe
MEASURE_UNITS = {
    "frequency": ("rad/s", "Hz"),
    "period": ("s",),
    "contact_time": ("s",),
    "time_at": ("s",),
    "restitution": ("-",),
    "harmonic_phase": ("deg",),
}


@dataclass(frozen=True)
class Material:
    """An elastic, isotropic material.

    Attributes:
        density: Mass density rho [kg/m^3].
        youngs_modulus: Young's modulus E [Pa].
        poissons_ratio: Poisson's ratio nu [-]: -1 < nu < 0.5, and -1 < nu < 1 in plane stress.
        law: How stress grows with large strain, one of `LAWS` (`warp_mps.elastic.laws` gives the formulas).
        retardation_time: Kelvin-Voigt damping: a viscous stress of this time tau times the rate of the elastic one [s].
            A mode of angular frequency omega has the damping ratio tau omega / 2. For the hamiltonian model.
        path: Where it was described, for error messages.
    """

    density: float
    youngs_modulus: float
    poissons_ratio: float
    law: str = "st_venant_kirchhoff"
    retardation_time: float = field(default=0.0, kw_only=True)
    path: str = field(default="material", kw_only=True)


@dataclass(frozen=True, kw_only=True)
class VelocityField:
    """An initial velocity that varies in space, in beams as v(x) = amplitude * shape(mode, s / length).

    s = (x - origin) . axis runs from 0 to `length`. The shapes are ``sine`` (sin(mode pi s / length)) and the
    bending modes of a uniform beam, ``free_free_beam`` and ``clamped_free_beam``, scaled to 1 at s = length
    (Rao, Mechanical Vibrations, section 8.5). ``twist``, in 3-D, is the torsion mode of a rod that is clamped at s = 0
    and free at s = length (section 8.4): v(x) = rate * sin((2 mode - 1) pi s / (2 length)) * axis x (x - origin).
    Particles' own rotation, which the springs model has, starts at rest.

    The others are of liquids, without divergence. With q = (x - origin) . e, e the direction of the amplitude, which is
    at right angles to the axis, and k = 2 pi / length:

    - ``stagnation``: rate * (x - origin) along the axis, -rate/(d - 1) * (x - origin) across it.
    - ``taylor_green``: amplitude * sin(k s) cos(k q) - axis * abs(amplitude) * cos(k s) sin(k q), vortices.
    - ``standing_wave``: linear waves as they pass through the level, on water from q = 0, the bottom, to q = depth
      (Lamb, Hydrodynamics, section 228):
      (amplitude * cos(k s) sinh(k q) - axis * abs(amplitude) * sin(k s) cosh(k q)) / sinh(k depth).

    Attributes:
        kind: One of `VELOCITY_FIELDS`; `VELOCITY_FIELD_PARTS` says what each needs.
        amplitude: Velocity where the shape is 1 [m/s]; of a standing wave that of its crests.
        rate: Angular velocity where the shape is 1, of ``twist`` [rad/s]; rate of stretching, of ``stagnation`` [1/s].
        axis: Direction along which the shape varies; its length does not matter.
        origin: Point where s = 0 [m]; the axis of a twist goes through it.
        length: Length of the body along the axis; wave length of what repeats itself [m].
        depth: Depth of the water of a standing wave [m].
        mode: Number of the mode, from 1, of a body.
    """

    kind: str
    amplitude: Vector | None = None
    rate: float | None = None
    axis: Vector
    origin: Vector
    length: float | None = None
    depth: float | None = None
    mode: int = 1


@dataclass(frozen=True, kw_only=True)
class HarmonicMotion:
    """A prescribed displacement amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    Attributes:
        amplitude: Amplitude of each component [m].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
    """

    amplitude: Vector
    frequency: float
    phase: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TableMotion:
    """A prescribed displacement, between the rows of a table, and constant outside it.

    Attributes:
        times: Times, increasing [s], shape [n].
        displacements: Displacements [m], shape [n, dimension].
        interpolation: ``linear``, or ``cubic``: the spline that is at rest at both ends, whose velocity and
            acceleration are continuous between them.
    """

    times: np.ndarray
    displacements: np.ndarray
    interpolation: str = "linear"


@dataclass(frozen=True, kw_only=True)
class HarmonicRotation:
    """A prescribed turn by an angle amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    Attributes:
        amplitude: Amplitude [rad].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
        pivot: Point of the undisplaced scene that it turns about [m]; a motion carries it along.
        axis: Direction that it turns about, of any length, shape [3]; in 2-D it is the normal, whatever is given.
    """

    amplitude: float
    frequency: float
    phase: float = 0.0
    pivot: Vector
    axis: Vector = ()


@dataclass(frozen=True, kw_only=True)
class TableRotation:
    """A prescribed turn by the angles of a table, and constant outside it.

    Attributes:
        times: Times, increasing [s], shape [n].
        angles: Angles [rad], shape [n].
        pivot: Point of the undisplaced scene that it turns about [m]; a motion carries it along.
        axis: Direction that it turns about, of any length, shape [3]; in 2-D it is the normal, whatever is given.
        interpolation: ``linear`` or ``cubic``, as of a `TableMotion`.
    """

    times: np.ndarray
    angles: np.ndarray
    pivot: Vector
    axis: Vector = ()
    interpolation: str = "linear"


@dataclass(frozen=True, kw_only=True)
class Support:
    """A region whose particles are held, along some axes or along all, at rest or on a prescribed motion.

    Attributes:
        name: Name, unique in the scene.
        region: Particles whose initial position lies in this shape are held.
        axes: Held axes (0 is x), all when empty; a roller holds one.
        bodies: Names of the bodies it acts on, all when empty.
        motion: Prescribed displacement of the held axes; None holds them at rest.
        hold_rotation: Whether the particles' rotation is held too; None holds it when every axis is held (a clamp).
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    axes: tuple[int, ...] = ()
    bodies: tuple[str, ...] = ()
    motion: HarmonicMotion | TableMotion | None = None
    hold_rotation: bool | None = None
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Load:
    """A force on the particles of a region: its value times sin(2 pi f t + phase), constant when f = 0.

    Attributes:
        name: Name, unique in the scene.
        region: Particles whose initial position lies in this shape are loaded.
        force: Total force, shared in proportion to mass [N] (2-D: [N/m]).
        acceleration: Force per mass, added to `force` [m/s^2].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
        bodies: Names of the bodies it acts on, all when empty.
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    force: Vector | None = None
    acceleration: Vector | None = None
    frequency: float = 0.0
    phase: float = 0.0
    bodies: tuple[str, ...] = ()
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A region of a body that is made of a material of its own: a layer, a core, a stiffener.

    Attributes:
        name: Name, unique among the parts of the scene.
        region: The body's particles whose initial position lies in this shape, faces included, are of the material;
            where parts of a body overlap, the last one counts.
        material: What the part is made of.
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    material: Material
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Body:
    """An elastic body, filled with particles on a regular lattice.

    Attributes:
        name: Name, unique in the scene and a valid USD prim name.
        shape: Region it fills.
        material: What it is made of.
        parts: Regions of it that are made of other materials.
        spacing: Particle spacing l0 [m].
        velocity: Initial velocity [m/s].
        angular_velocity: Initial angular velocity about the centre of mass [rad/s]: a number in 2-D, 3 numbers in 3-D.
        velocity_field: Initial velocity that varies along the body, added to `velocity`.
        node_axes: Axes of the shape along which the outermost particles lie on its faces; along the others they lie
            half a spacing inside.
        bonded_to: Names of bodies that it is joined to: their particles are neighbours as if of one body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    material: Material
    parts: tuple[Part, ...] = ()
    spacing: float
    velocity: Vector | None = None
    angular_velocity: float | Vector | None = None
    velocity_field: VelocityField | None = None
    node_axes: tuple[int, ...] = ()
    bonded_to: tuple[str, ...] = ()
    path: str = ""

    @property
    def materials(self) -> tuple[Material, ...]:
        """Its materials: its own, then those of its parts."""
        return (self.material, *(part.material for part in self.parts))


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A rigid body that elastic bodies touch, at rest or on a prescribed motion.

    A point X of it is at x = pivot + R(angle) (X - pivot) + displacement. It is filled with particles as a body is;
    walls may overlap each other, and do not touch each other.

    Attributes:
        name: Name, unique among bodies and walls and a valid USD prim name.
        shape: Region it fills.
        spacing: Particle spacing l0 [m].
        motion: Prescribed displacement; None is none.
        rotation: Prescribed turn; None is none.
        friction: Coefficient of friction of bodies on it [-]; None is that of `Contact`.
        slip: Whether fluid slides along it, one of `WALL_SLIPS`: ``free``, or ``no``, where it sticks.
        node_axes: Axes of the shape along which the outermost particles lie on its faces, as of a body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    spacing: float
    motion: HarmonicMotion | TableMotion | None = None
    rotation: HarmonicRotation | TableRotation | None = None
    friction: float | None = None
    slip: str = "free"
    node_axes: tuple[int, ...] = ()
    path: str = ""

    @property
    def moves(self) -> bool:
        """Whether it is ever elsewhere than it was drawn."""
        return self.motion is not None or self.rotation is not None


@dataclass(frozen=True)
class Liquid:
    """An incompressible, Newtonian liquid.

    Attributes:
        density: Mass density rho [kg/m^3].
        viscosity: Kinematic viscosity [m^2/s], at least 0; implicit where it would limit the time step.
        path: Where it was described, for error messages.
    """

    density: float = 1000.0
    viscosity: float = 1e-6
    path: str = field(default="liquid", kw_only=True)


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """A body of liquid, filled with particles on a regular lattice.

    Attributes:
        name: Name, unique in the scene and a valid USD prim name.
        shape: Region that it fills at the start.
        liquid: What it is; the same for all fluids of a scene.
        spacing: Particle spacing l0 [m]; the same for all fluids of a scene.
        velocity: Initial velocity [m/s].
        angular_velocity: Initial angular velocity about the centre of mass [rad/s]: a number in 2-D, 3 numbers in 3-D.
        velocity_field: Initial velocity that varies, added to `velocity`.
        node_axes: As those of a body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    spacing: float
    liquid: Liquid = Liquid()
    velocity: Vector | None = None
    angular_velocity: float | Vector | None = None
    velocity_field: VelocityField | None = None
    node_axes: tuple[int, ...] = ()
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Probe:
    """A quantity recorded through the run: at a point, averaged over a region, of a body or wall, or of a support.

    Exactly one of `point`, `region`, `body` and `support` is given; `PROBE_QUANTITIES` lists what each can record
    (a region records the mean of what a point does, and a wall has the `WALL_QUANTITIES`). In a scene of fluids points
    and regions stay where they are while the fluid goes through them, and have the `FLUID_QUANTITIES`, as a fluid has;
    `warp_mps.observers.fluid_sampling` defines these. A rotation is that of a
    rotation vector: its angle lies between -pi and pi, with the springs model in 2-D between -4 pi and 4 pi.
    `warp_mps.elastic.stresses` defines stress and strain; `strain_energy` is per reference volume.

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
        measure: How it is drawn, one of `MEASURES` (`warp_mps.measure` defines each).
        probe: Name of the probe.
        component: Component of the probe, counted from 0; `warp_mps.components` gives their order.
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


@dataclass(frozen=True, kw_only=True)
class Elasticity:
    """The elastic model and its choices, the same for every body of a scene.

    Attributes:
        model: ``hamiltonian``, accurate and for large strains, or ``springs``, the paper's.
        effective_radius: Effective radius r_e in units of the particle spacing [-].
        normalization: What the operators of ``springs`` are normalized by: ``lattice`` (n0 of a full lattice, as in
            eq. 14) or ``particle`` (the particle's own n_i, as in eq. 6).
        control: Strength with which ``hamiltonian`` resists zero-energy modes [-]. The default is the most accurate up
            to some 16 particles through a thickness; 0.65 to 0.7 shows the second order already from 8 on.
    """

    model: str = "hamiltonian"
    effective_radius: float = 1.5
    normalization: str = "lattice"
    control: float = 0.5


@dataclass(frozen=True, kw_only=True)
class Contact:
    """How bodies and walls repel each other where their faces meet; `warp_mps.elastic.contact_law` gives the law.

    Attributes:
        between: ``bodies`` (different bodies), ``all`` (also a body and itself), or ``none``. A body does not see
            itself across a gap that is narrower than two spacings.
        stiffness: Pressure of a small penetration in units of E penetration / l0 [-], E of the softer material.
        friction: Coefficient of Coulomb friction [-]; 0 is none.
    """

    between: str = "bodies"
    stiffness: float = 1.0
    friction: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Flow:
    """How fluids are computed, the same for all of a scene.

    Attributes:
        scheme: One of `FLUID_SCHEMES`: ``conservative`` (pair forces equal and opposite), ``corrected`` (gradients
            exact for linear pressures, with shifting), or the original MPS, ``koshizuka_oka``.
        effective_radius: Effective radius r_e in units of the particle spacing [-]; None is 3.1 in 2-D, 2.1 in 3-D.
        negative_pressure: ``clipped`` where water would have to pull, or ``allowed``.
        tolerance: True residual of the pressure solve, relative to its right-hand side [-].
        courant: Largest time step in units of l0 / u, u the speed of the fastest particle [-].
        domain: Lowest and highest corner of the region that is computed [m]; particles that leave it are counted and
            left out. None is a wide box about all particles.
        periodic: Axes along which the domain repeats itself (0 is x).
    """

    scheme: str = "conservative"
    effective_radius: float | None = None
    negative_pressure: str = "clipped"
    tolerance: float = 1e-4
    courant: float = 0.2
    domain: tuple[Vector, Vector] | None = None
    periodic: tuple[int, ...] = ()

    def radius(self, dimension: int) -> float:
        """Effective radius in units of the particle spacing [-], in 2 or 3 dimensions."""
        return self.effective_radius or (3.1 if dimension == 2 else 2.1)


@dataclass(frozen=True, kw_only=True)
class StageFrame:
    """How the scene lies in the stage that it was read from, and in which results are written.

    Attributes:
        axes: The stage's axes along which the scene's axes lie: ``xyz`` in 3-D, and ``xy``, ``xz`` or ``yz`` in 2-D.
        up_axis: Up axis of the stage, ``Y`` or ``Z``.
        meters_per_unit: Length of the stage's unit [m].
        kilograms_per_unit: Mass of the stage's unit [kg].
    """

    axes: str = "xy"
    up_axis: str = "Y"
    meters_per_unit: float = 1.0
    kilograms_per_unit: float = 1.0


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
        probes: Recorded quantities.
        measurements: Numbers drawn from the probes, with their references.
        elasticity: The elastic model.
        contact: Contact between bodies.
        flow: How fluids are computed.
        damping: Mass-proportional damping: force -damping * m * v, and likewise a torque where particles rotate [1/s].
        outputs: What frames hold beside positions, velocities and pressure, names of `OUTPUTS`.
        frame_rate: Saved frames per simulated second [1/s].
        sample_rate: Rows of probes.csv per simulated second, a multiple of `frame_rate` [1/s]; None is `frame_rate`.
        time_step: Time step [s]; None derives it from `courant`. Frames and rows then come every so many whole steps,
            as near to their rates as that allows.
        analysis: ``dynamic``, or ``static``: equilibrium under loads, weight and moving supports, which grow together
            with the load factor. The load factor stands for the time, from 0 to `duration`; 1 is all of them.
        load_steps: Increments of a static load; each makes a frame and a row.
        integrator: ``explicit``, or ``implicit``: steps of `time_step` of any length by the theta rule.
        theta: Theta of that rule: 0.5 keeps the energy, 1 damps most (`warp_mps.elastic.implicit.theta`).
        courant: Time step in units of l0 / c_p, c_p the speed of pressure waves [-], and at most 0.9
            of what is stable for small deformations.
        stage: How the scene lies in its stage; None is the x-y plane, or x, y, z in 3-D, of a stage in SI units.
        path: Where it was described, for error messages.

    Raises:
        InputError: Something in it is not allowed; see `warp_mps.checks`.
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
    integrator: str = "explicit"
    theta: float = 0.55
    courant: float = 0.25
    stage: StageFrame | None = None
    path: str = "scene"

    def __post_init__(self) -> None:
        from warp_mps.checks import check_scene

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

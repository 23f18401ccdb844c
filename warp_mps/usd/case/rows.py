"""The rows of the table of attributes: what each is called, what it fills, its unit, default and allowed values."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from warp_mps import scene as sc


@dataclass(frozen=True, kw_only=True)
class Attribute:
    """One attribute, or relationship, of a stage.

    Attributes:
        name: Name in the stage.
        kind: Type in the stage, ``rel`` for a relationship.
        role: What it belongs to: ``scene``, ``material`` or one of `warp_mps.usd.case.attributes.ROLES`.
        field: Field of the scene that it fills, as errors name it.
        meaning: What it says.
        unit: Unit, L the stage's length and M its mass.
        length: Power of the stage's length unit in it.
        mass: Power of the stage's mass unit in it.
        default: Value when it is not given; None when there is none.
        allowed: Allowed values.
        required: Whether it must be given.
        nature: How a vector lies in a plane: ``polar`` (no component out of it), ``axial`` (only that component) or
            ``point`` (that component does not matter).
    """

    name: str
    kind: str
    role: str
    field: str
    meaning: str
    unit: str = ""
    length: int = 0
    mass: int = 0
    default: Any = None
    allowed: tuple[str, ...] = ()
    required: bool = False
    nature: str = "polar"

    @property
    def own(self) -> bool:
        """Whether it is this package's, not one of `UsdPhysics`."""
        return self.name.startswith("mps:")


def _default(owner: type, name: str) -> Any:
    return next(field.default for field in fields(owner) if field.name == name)


def _table(role: str, *rows: dict[str, Any]) -> list[Attribute]:
    return [Attribute(role=role, **row) for row in rows]


def _row(name: str, kind: str, field: str, meaning: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "kind": kind, "field": field, "meaning": meaning, **more}


# A row is read as a row: it is not to be spread over ten lines.
# fmt: off
_SECONDS: dict[str, Any] = {"unit": "s"}
_HERTZ: dict[str, Any] = {"unit": "Hz", "default": 0.0}
_RADIANS: dict[str, Any] = {"unit": "rad", "default": 0.0}
_LENGTH: dict[str, Any] = {"unit": "L", "length": 1}
_VELOCITY: dict[str, Any] = {"unit": "L/s", "length": 1}
_ACCELERATION: dict[str, Any] = {"unit": "L/s^2", "length": 1}
_PROBES = tuple(dict.fromkeys(
    quantity
    for names in (*sc.PROBE_QUANTITIES.values(), sc.WALL_QUANTITIES, *sc.FLUID_QUANTITIES.values())
    for quantity in names
))

SCENE = _table(
    "scene",
    _row("mps:dimension", "int", "dimension", "2 or 3 dimensions", default=3, allowed=("2", "3")),
    _row("mps:plane", "token", "stage.axes", "plane of a 2-D scene: `xy` where y is up, `xz` where z is up",
         allowed=("xy", "xz", "yz")),
    _row("mps:planeModel", "token", "plane", "plane strain or plane stress, in 2-D",
         default=_default(sc.Scene, "plane"), allowed=sc.PLANE_MODELS),
    _row("physics:gravityDirection", "vector3f", "gravity.direction",
         "direction of gravity; zero points it down the up axis", default=(0.0, 0.0, 0.0)),
    _row("physics:gravityMagnitude", "float", "gravity", "acceleration of gravity; a negative number is 9.81 m/s^2",
         default=float("-inf"), **_ACCELERATION),
    _row("mps:duration", "double", "duration", "simulated time, above 0", required=True, **_SECONDS),
    _row("mps:frameRate", "double", "frame_rate", "saved frames per simulated second, above 0", unit="1/s",
         default=_default(sc.Scene, "frame_rate")),
    _row("mps:sampleRate", "double", "sample_rate",
         "rows of probes.csv per simulated second, a whole multiple of `mps:frameRate`, which it is if not given",
         unit="1/s"),
    _row("mps:timeStep", "double", "time_step",
         "time step, above 0; from `mps:courant` if not given. Frames and rows then come every so many whole steps. "
         "Fluids: the longest step, where that of `mps:fluidCourant` is not shorter",
         **_SECONDS),
    _row("mps:analysis", "token", "analysis",
         "motion in time, or static equilibrium under loads that grow with the load factor, which stands for the time",
         default=_default(sc.Scene, "analysis"), allowed=sc.ANALYSES),
    _row("mps:loadSteps", "int", "load_steps", "`static`: increments to the whole load, at least 1; each makes a frame",
         default=_default(sc.Scene, "load_steps")),
    _row("mps:integrator", "token", "integrator",
         "steps of elastic bodies: explicit, or implicit ones of any length: of `mps:timeStep`, or those of the water "
         "about them. `auto` is explicit for bodies alone, and in water where there is contact, a viscosity, "
         "or the model is springs",
         default=_default(sc.Scene, "integrator"), allowed=sc.INTEGRATORS),
    _row("mps:theta", "double", "theta",
         "theta of `implicit` steps, 0.5 (keeps energy) to 1 (damps most); explicit ones in water are damped as much",
         default=_default(sc.Scene, "theta")),
    _row("mps:courant", "double", "courant",
         "time step in units of spacing / speed of pressure waves, above 0; at most 0.9 of what is stable",
         default=_default(sc.Scene, "courant")),
    _row("mps:damping", "double", "damping",
         "force per mass and velocity, and torque per inertia and spin, that oppose motion, at least 0", unit="1/s",
         default=_default(sc.Scene, "damping")),
    _row("mps:outputs", "token[]", "outputs",
         "what frames hold beside positions, velocities and pressure", allowed=sc.OUTPUTS),
    _row("mps:elasticModel", "token", "model", "the elastic model: the accurate one, or the paper's",
         default=_default(sc.Elasticity, "model"), allowed=sc.ELASTIC_MODELS),
    _row("mps:effectiveRadius", "double", "effective_radius", "effective radius in particle spacings, 1.1 to 5",
         default=_default(sc.Elasticity, "effective_radius")),
    _row("mps:normalization", "token", "normalization",
         "`springs`: normalize by a full lattice or by each particle's own sum",
         default=_default(sc.Elasticity, "normalization"), allowed=sc.NORMALIZATIONS),
    _row("mps:control", "double", "control", "`hamiltonian`: resistance to zero-energy modes, 0 to 10",
         default=_default(sc.Elasticity, "control")),
    _row("mps:contact", "token", "contact", "contact between different bodies, also within a body, or none",
         default=_default(sc.Contact, "between"), allowed=sc.CONTACTS),
    _row("mps:contactStiffness", "double", "contact_stiffness",
         "pressure of a small penetration, in units of E penetration / spacing of the softer material, above 0",
         default=_default(sc.Contact, "stiffness")),
    _row("mps:friction", "double", "friction", "coefficient of friction of contacts, at least 0",
         default=_default(sc.Contact, "friction")),
    _row("mps:fluidScheme", "token", "flow.scheme",
         "fluids: pair forces that conserve momentum, gradients exact for linear pressures, or the original MPS",
         default=_default(sc.Flow, "scheme"), allowed=sc.FLUID_SCHEMES),
    _row("mps:fluidEffectiveRadius", "double", "flow.effective_radius",
         "fluids: effective radius in particle spacings, 1.5 to 4.1; if not given, 3.1 in 2-D and 2.1 in 3-D"),
    _row("mps:negativePressure", "token", "flow.negative_pressure",
         "fluids: whether pressures below 0 are cut off, or the liquid can pull",
         default=_default(sc.Flow, "negative_pressure"), allowed=sc.NEGATIVE_PRESSURES),
    _row("mps:pressureTolerance", "double", "flow.tolerance",
         "fluids: relative residual of the pressure solve, above 0 and at most 0.1",
         default=_default(sc.Flow, "tolerance")),
    _row("mps:fluidCourant", "double", "flow.courant",
         "fluids: time step in units of spacing / speed of the fastest particle, above 0 and at most 1",
         default=_default(sc.Flow, "courant")),
    _row("mps:domainLow", "double3", "flow.domain.low",
         "fluids: lowest corner of the region that is computed; particles that leave it are left out",
         nature="point", **_LENGTH),
    _row("mps:domainHigh", "double3", "flow.domain.high", "fluids: its highest corner", nature="point", **_LENGTH),
    _row("mps:periodicAxes", "token", "flow.periodic",
         "fluids: axes of the stage, such as `x` or `xz`, along which the region repeats itself"),
)

MATERIAL = _table(
    "material",
    _row("physics:density", "float", "density", "density, above 0; a body's own, by PhysicsMassAPI, wins",
         unit="M/L^3", mass=1, length=-3, required=True),
    _row("mps:youngsModulus", "double", "youngs_modulus", "Young's modulus, above 0", unit="M/(L s^2)", mass=1,
         length=-1, required=True),
    _row("mps:poissonsRatio", "double", "poissons_ratio",
         "Poisson's ratio, between -1 and 0.5 (plane stress: 1), both excluded", required=True),
    _row("mps:law", "token", "law", "how stress grows with large strain; `springs` is linear",
         default=_default(sc.Material, "law"), allowed=sc.LAWS),
    _row("mps:retardationTime", "double", "retardation_time",
         "Kelvin-Voigt damping of `hamiltonian`: viscous stress over rate of elastic stress, at least 0", unit="s",
         default=_default(sc.Material, "retardation_time")),
)

LIQUID = _table(
    "liquid",
    _row("physics:density", "float", "density",
         "density, above 0; a fluid's own, by PhysicsMassAPI, wins; 1000 kg/m^3 if not given", unit="M/L^3", mass=1,
         length=-3),
    _row("mps:viscosity", "double", "viscosity", "kinematic viscosity, at least 0; 1e-6 m^2/s if not given",
         unit="L^2/s", length=2),
)

_INNER = _row("mps:innerRadius", "double", "inner_radius", "radius of the bore of a Cylinder, less than its radius",
     default=0.0, **_LENGTH)

_FILLED = (
    _row("mps:spacing", "double", "spacing", "particle spacing, above 0", required=True, **_LENGTH),
    _INNER,
    _row("mps:nodeAxes", "token", "node_axes",
         "the shape's own axes, such as `xz`, along which the outermost particles lie on the faces"),
)
_START = (
    _row("mps:velocity", "double3", "velocity", "initial velocity, along the stage's axes", **_VELOCITY),
    _row("mps:angularVelocity", "double3", "angular_velocity", "initial angular velocity about the centre of mass",
         unit="rad/s", nature="axial"),
    _row("mps:velocityField", "token", "velocity_field", "initial velocity that varies along the body",
         allowed=sc.VELOCITY_FIELDS),
    _row("mps:velocityField:amplitude", "double3", "velocity_field.amplitude",
         "velocity where the shape is 1, of all but `twist` and `stagnation`", **_VELOCITY),
    _row("mps:velocityField:rate", "double", "velocity_field.rate",
         "`twist`: angular velocity where the shape is 1; `stagnation`: rate of stretching", unit="rad/s"),
    _row("mps:velocityField:axis", "double3", "velocity_field.axis",
         "direction along which the shape varies, axis of a twist"),
    _row("mps:velocityField:origin", "double3", "velocity_field.origin", "point where the shape begins",
         nature="point", **_LENGTH),
    _row("mps:velocityField:length", "double", "velocity_field.length",
         "length over which it varies, wave length of `taylor_green` and `standing_wave`", **_LENGTH),
    _row("mps:velocityField:depth", "double", "velocity_field.depth", "`standing_wave`: depth of the water",
         **_LENGTH),
    _row("mps:velocityField:mode", "int", "velocity_field.mode", "number of the mode, from 1", default=1),
)

BODY = _table(
    "body",
    *_FILLED,
    *_START,
    _row("mps:bondedTo", "rel", "bonded_to", "bodies that it is joined to, their particles neighbours as of one body"),
)

FLUID = _table("fluid", *_FILLED, *_START)

_MOTION = (
    _row("mps:motion:amplitude", "double3", "motion.amplitude",
         "amplitude of a displacement amplitude (sin(2 pi f t + phase) - sin(phase))", **_LENGTH),
    _row("mps:motion:frequency", "double", "motion.frequency", "its frequency f, above 0", unit="Hz"),
    _row("mps:motion:phase", "double", "motion.phase", "its phase", **_RADIANS),
    _row("mps:motion:times", "double[]", "motion.times", "times of a table of displacements, increasing", **_SECONDS),
    _row("mps:motion:displacements", "double3[]", "motion.displacements", "its displacements, one a time", **_LENGTH),
    _row("mps:motion:interpolation", "token", "motion.interpolation",
         "how they are joined: by straight lines, or by the spline that is at rest at both ends",
         default=_default(sc.TableMotion, "interpolation"), allowed=sc.INTERPOLATIONS),
)

WALL = _table(
    "wall",
    *_FILLED,
    _row("mps:friction", "double", "friction",
         "coefficient of friction of bodies on it; that of the scene if not given"),
    _row("mps:slip", "token", "slip", "whether fluid slides along it freely, or not at all",
         default=_default(sc.Wall, "slip"), allowed=sc.WALL_SLIPS),
    *_MOTION,
    _row("mps:rotation:amplitude", "double", "rotation.amplitude",
         "amplitude of a turn by amplitude (sin(2 pi f t + phase) - sin(phase))", unit="rad"),
    _row("mps:rotation:frequency", "double", "rotation.frequency", "its frequency f, above 0", unit="Hz"),
    _row("mps:rotation:phase", "double", "rotation.phase", "its phase", **_RADIANS),
    _row("mps:rotation:times", "double[]", "rotation.times", "times of a table of angles, increasing", **_SECONDS),
    _row("mps:rotation:angles", "double[]", "rotation.angles", "its angles, one a time", unit="rad"),
    _row("mps:rotation:interpolation", "token", "rotation.interpolation", "how they are joined, as of a motion",
         default=_default(sc.TableRotation, "interpolation"), allowed=sc.INTERPOLATIONS),
    _row("mps:rotation:pivot", "double3", "rotation.pivot",
         "point that it turns about, which a motion carries along", nature="point", **_LENGTH),
    _row("mps:rotation:axis", "double3", "rotation.axis",
         "direction that it turns about, by the right hand; in 2-D the normal of the plane if not given",
         nature="axial"),
)

PART = _table(
    "part",
    _row("mps:body", "rel", "body", "the body that it is a part of", required=True),
    _INNER,
)

_BODIES = _row("mps:bodies", "rel", "bodies", "bodies that it acts on, all if not given")
SUPPORT = _table(
    "support",
    _row("mps:axes", "token", "axes", "held axes of the stage, such as `y` or `xyz`; all if not given"),
    _BODIES,
    _row("mps:holdRotation", "bool", "hold_rotation",
         "whether the particles' rotation is held; if not given, where every axis is held"),
    *_MOTION,
    _INNER,
)

LOAD = _table(
    "load",
    _row("mps:force", "double3", "force", "total force on the region; in 2-D per metre of depth", unit="M L/s^2",
         mass=1, length=1),
    _row("mps:acceleration", "double3", "acceleration", "force per mass, added to the force", **_ACCELERATION),
    _row("mps:frequency", "double", "frequency", "frequency f of the factor sin(2 pi f t + phase); 0 is constant",
         **_HERTZ),
    _row("mps:phase", "double", "phase", "its phase", **_RADIANS),
    _BODIES,
    _INNER,
)

PROBE = _table(
    "probe",
    _row("mps:quantity", "token", "quantity", "what is recorded, of those that its place has",
         default=_default(sc.Probe, "quantity"), allowed=_PROBES),
    _row("mps:target", "rel", "target", "a body, wall, fluid or support that it records, instead of a place"),
    _row("mps:about", "double3", "about",
         "point about which a moment is taken: a `section_moment` inside a body, a `contact_moment` anywhere",
         nature="point", **_LENGTH),
    _row("mps:movesWith", "rel", "moves_with",
         "among fluids, the wall that a point is fixed to; it stays where it is if not given"),
    _INNER,
)

MEASUREMENT = _table(
    "measurement",
    _row("mps:measure", "token", "measure", "how the number is drawn from the probe's history", allowed=sc.MEASURES,
         required=True),
    _row("mps:probe", "rel", "probe", "the probe", required=True),
    _row("mps:component", "token", "component",
         "component of the probe: an axis of the stage, or of a stress or strain two; its first if not given",
         allowed=("x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz")),
    _row("mps:reference", "double", "reference", "value to expect, in `mps:unit` and not in the stage's units"),
    _row("mps:unit", "string", "unit",
         "SI unit of the number; a frequency is in rad/s, or with `Hz` in cycles a second", default=""),
    _row("mps:source", "string", "source", "where the reference comes from", default=""),
    _row("mps:start", "double", "start", "beginning of the history that is used", unit="s", default=0.0),
    _row("mps:end", "double", "end", "end of the history that is used; of the run if not given", **_SECONDS),
    _row("mps:frequency", "double", "frequency", "frequency of the harmonic measures", **_HERTZ),
    _row("mps:at", "double", "at", "time of `value_at`, in s; value of `time_at`, in SI units"),
)
# fmt: on

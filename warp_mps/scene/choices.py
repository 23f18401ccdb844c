"""The closed sets of words of a scene and of a run, and the units of recorded quantities."""

from __future__ import annotations

from typing import Literal, get_args

PrecisionName = Literal["float64", "float32"]
PlaneName = Literal["xy", "xz", "yz"]
StageAxesName = Literal["xyz", "xy", "xz", "yz"]
UpAxisName = Literal["Y", "Z"]
AnalysisName = Literal["dynamic", "static"]
IntegratorName = Literal["auto", "explicit", "implicit"]
ElasticModelName = Literal["hamiltonian", "springs"]
LawName = Literal["st_venant_kirchhoff", "neo_hookean"]
NormalizationName = Literal["lattice", "particle"]
PlaneModelName = Literal["strain", "stress"]
ContactName = Literal["none", "bodies", "all"]
InterpolationName = Literal["linear", "cubic"]
WallSlipName = Literal["free", "no"]
VelocityFieldName = Literal[
    "sine", "free_free_beam", "clamped_free_beam", "twist", "stagnation", "taylor_green", "standing_wave"
]
FluidSchemeName = Literal["conservative", "corrected", "koshizuka_oka"]
NegativePressureName = Literal["clipped", "allowed"]
OutputName = Literal["stress", "strain", "von_mises", "strain_energy"]
QuantityName = Literal[
    "position",
    "displacement",
    "velocity",
    "rotation",
    "pressure",
    "stress",
    "strain",
    "von_mises",
    "strain_energy",
    "section_force",
    "section_moment",
    "extent",
    "lowest",
    "highest",
    "momentum",
    "angular_momentum",
    "kinetic_energy",
    "contact_force",
    "reaction",
    "contact_moment",
    "elevation",
    "volume",
]
MeasureName = Literal[
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
]

PRECISIONS: tuple[PrecisionName, ...] = get_args(PrecisionName)
PLANES: tuple[PlaneName, ...] = get_args(PlaneName)
UP_AXES: tuple[UpAxisName, ...] = get_args(UpAxisName)
ANALYSES: tuple[AnalysisName, ...] = get_args(AnalysisName)
INTEGRATORS: tuple[IntegratorName, ...] = get_args(IntegratorName)
ELASTIC_MODELS: tuple[ElasticModelName, ...] = get_args(ElasticModelName)
LAWS: tuple[LawName, ...] = get_args(LawName)
NORMALIZATIONS: tuple[NormalizationName, ...] = get_args(NormalizationName)
PLANE_MODELS: tuple[PlaneModelName, ...] = get_args(PlaneModelName)
CONTACTS: tuple[ContactName, ...] = get_args(ContactName)
INTERPOLATIONS: tuple[InterpolationName, ...] = get_args(InterpolationName)
WALL_SLIPS: tuple[WallSlipName, ...] = get_args(WallSlipName)
VELOCITY_FIELDS: tuple[VelocityFieldName, ...] = get_args(VelocityFieldName)
FLUID_SCHEMES: tuple[FluidSchemeName, ...] = get_args(FluidSchemeName)
NEGATIVE_PRESSURES: tuple[NegativePressureName, ...] = get_args(NegativePressureName)
OUTPUTS: tuple[OutputName, ...] = get_args(OutputName)
QUANTITIES: tuple[QuantityName, ...] = get_args(QuantityName)
MEASURES: tuple[MeasureName, ...] = get_args(MeasureName)

_SHAPE = ("amplitude", "axis", "origin", "length")
# fields that each kind of velocity field requires
VELOCITY_FIELD_PARTS: dict[VelocityFieldName, tuple[str, ...]] = {
    "sine": _SHAPE,
    "free_free_beam": _SHAPE,
    "clamped_free_beam": _SHAPE,
    "twist": ("rate", "axis", "origin", "length"),
    "stagnation": ("rate", "axis", "origin"),
    "taylor_green": _SHAPE,
    "standing_wave": (*_SHAPE, "depth"),
}
# kinds that have modes
MODAL_FIELDS: tuple[VelocityFieldName, ...] = VELOCITY_FIELDS[:4]

_FIELDS: tuple[QuantityName, ...] = ("position", "displacement", "velocity", "rotation", "pressure", *OUTPUTS)
_WHOLE: tuple[QuantityName, ...] = ("position", "displacement", "velocity", "extent", "lowest", "highest")
_MASSIVE: tuple[QuantityName, ...] = ("momentum", "angular_momentum", "kinetic_energy")
PROBE_QUANTITIES: dict[str, tuple[QuantityName, ...]] = {
    "point": _FIELDS,
    "region": (*_FIELDS, "section_force", "section_moment"),
    "body": (*_WHOLE, *_MASSIVE, "contact_force"),
    "support": ("reaction",),
}
# quantities of a wall, which has no mass, and of a scene of fluids
WALL_QUANTITIES: tuple[QuantityName, ...] = (*_WHOLE, "contact_force", "contact_moment")
FLUID_QUANTITIES: dict[str, tuple[QuantityName, ...]] = {
    "point": ("pressure", "velocity", "elevation"),
    "region": ("pressure", "velocity"),
    "body": ("position", "velocity", "extent", "lowest", "highest", *_MASSIVE, "volume"),
    "support": (),
}
# quantities that are taken about a point
ABOUT_QUANTITIES: tuple[QuantityName, ...] = ("section_moment", "contact_moment")
# unit of each quantity in 2-D, per metre of depth where it is extensive, and in 3-D
PROBE_UNITS: dict[QuantityName, tuple[str, str]] = {
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
# measures that need `Measurement.at`
AT_MEASURES: tuple[MeasureName, ...] = ("value_at", "time_at")
# units of measures that do not have the unit of their probe
MEASURE_UNITS: dict[MeasureName, tuple[str, ...]] = {
    "frequency": ("rad/s", "Hz"),
    "period": ("s",),
    "contact_time": ("s",),
    "time_at": ("s",),
    "restitution": ("-",),
    "harmonic_phase": ("deg",),
}

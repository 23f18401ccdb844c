"""The words that a scene may use, and the units of what is recorded."""

from __future__ import annotations

ANALYSES = ("dynamic", "static")
INTEGRATORS = ("auto", "explicit", "implicit")
ELASTIC_MODELS = ("hamiltonian", "springs")
LAWS = ("st_venant_kirchhoff", "neo_hookean")
NORMALIZATIONS = ("lattice", "particle")
PLANE_MODELS = ("strain", "stress")
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

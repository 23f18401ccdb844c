"""Description of a case: bodies, walls, materials, supports, loads, probes and the answers to expect.

A :class:`Scene` is plain data in SI units. It knows neither Warp nor USD: `warp_mps.usd` reads one from a stage and
saves it as one, `warp_mps.particles.filling` fills it with particles. A 2-D scene lies in the x-y plane of its own
coordinates; quantities are then per metre of depth.
"""

from warp_mps.scene.actions import Load, Support
from warp_mps.scene.bodies import Body, Fluid, Part, Wall
from warp_mps.scene.body_force import BodyForce
from warp_mps.scene.case import Scene
from warp_mps.scene.choices import (
    ABOUT_QUANTITIES,
    ANALYSES,
    AT_MEASURES,
    CONTACTS,
    ELASTIC_MODELS,
    FLUID_QUANTITIES,
    FLUID_SCHEMES,
    INTEGRATORS,
    INTERPOLATIONS,
    LAWS,
    MEASURE_UNITS,
    MEASURES,
    MODAL_FIELDS,
    NEGATIVE_PRESSURES,
    NORMALIZATIONS,
    OUTPUTS,
    PLANE_MODELS,
    PROBE_QUANTITIES,
    PROBE_UNITS,
    VELOCITY_FIELD_PARTS,
    VELOCITY_FIELDS,
    WALL_QUANTITIES,
    WALL_SLIPS,
)
from warp_mps.scene.filling_level import fill_to
from warp_mps.scene.materials import Liquid, Material
from warp_mps.scene.motions import HarmonicMotion, HarmonicRotation, TableMotion, TableRotation, Vector, VelocityField
from warp_mps.scene.numerics import Contact, Elasticity, Flow, StageFrame
from warp_mps.scene.probes import Measurement, Probe
from warp_mps.scene.tank_walls import tank

__all__ = [
    "ABOUT_QUANTITIES",
    "ANALYSES",
    "AT_MEASURES",
    "CONTACTS",
    "ELASTIC_MODELS",
    "FLUID_QUANTITIES",
    "FLUID_SCHEMES",
    "INTEGRATORS",
    "INTERPOLATIONS",
    "LAWS",
    "MEASURES",
    "MEASURE_UNITS",
    "MODAL_FIELDS",
    "NEGATIVE_PRESSURES",
    "NORMALIZATIONS",
    "OUTPUTS",
    "PLANE_MODELS",
    "PROBE_QUANTITIES",
    "PROBE_UNITS",
    "VELOCITY_FIELDS",
    "VELOCITY_FIELD_PARTS",
    "WALL_QUANTITIES",
    "WALL_SLIPS",
    "Body",
    "BodyForce",
    "Contact",
    "Elasticity",
    "Flow",
    "Fluid",
    "HarmonicMotion",
    "HarmonicRotation",
    "Liquid",
    "Load",
    "Material",
    "Measurement",
    "Part",
    "Probe",
    "Scene",
    "StageFrame",
    "Support",
    "TableMotion",
    "TableRotation",
    "Vector",
    "VelocityField",
    "Wall",
    "fill_to",
    "tank",
]

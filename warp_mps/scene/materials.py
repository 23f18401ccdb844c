"""The materials of bodies and the liquids of fluids."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_mps.scene.choices import LawName
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.record import Record


@described
@dataclass(frozen=True)
class Material(Record):
    """An elastic, isotropic material."""

    density: float = field(metadata=attribute("physics:density", kind="float", unit="kg/m^3", above=0.0))
    """Mass density rho; in a stage a body's own, by PhysicsMassAPI, replaces it."""
    youngs_modulus: float = field(metadata=attribute("mps:youngsModulus", unit="Pa", above=0.0))
    """Young's modulus E."""
    poissons_ratio: float = field(metadata=attribute("mps:poissonsRatio"))
    """Poisson's ratio nu: -1 < nu < 0.5, and -1 < nu < 1 in plane stress."""
    law: LawName = field(default="st_venant_kirchhoff", metadata=attribute("mps:law"))
    """Constitutive law at large strain (`warp_mps.elastic.materials.laws` has the formulas); the springs model is
    linear."""
    retardation_time: float = field(
        default=0.0, kw_only=True, metadata=attribute("mps:retardationTime", unit="s", minimum=0.0)
    )
    """Kelvin-Voigt damping of the hamiltonian model: a viscous stress of this time tau times the rate of the elastic
    stress. A mode of angular frequency omega has the damping ratio tau omega / 2."""
    path: str = field(default="material", kw_only=True)
    """Where it was described, for error messages."""


@described
@dataclass(frozen=True)
class Liquid(Record):
    """An incompressible, Newtonian liquid."""

    density: float = field(
        default=1000.0, metadata=attribute("physics:density", kind="float", unit="kg/m^3", above=0.0)
    )
    """Mass density rho; in a stage a fluid's own, by PhysicsMassAPI, replaces it."""
    viscosity: float = field(default=1e-6, metadata=attribute("mps:viscosity", unit="m^2/s", minimum=0.0))
    """Kinematic viscosity; the viscous term is implicit where it would limit the time step."""
    path: str = field(default="liquid", kw_only=True)
    """Where it was described, for error messages."""

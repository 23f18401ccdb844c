"""What bodies and fluids are made of."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Material:
    """An elastic, isotropic material.

    Attributes:
        density: Mass density rho [kg/m^3].
        youngs_modulus: Young's modulus E [Pa].
        poissons_ratio: Poisson's ratio nu [-]: -1 < nu < 0.5, and -1 < nu < 1 in plane stress.
        law: How stress grows with large strain, one of `LAWS` (`warp_mps.elastic.materials.laws` gives the formulas).
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

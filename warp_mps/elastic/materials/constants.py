"""Lame's constants of a material in 3-D, plane strain and plane stress."""

from __future__ import annotations

import math

from warp_mps.scene import Material
from warp_mps.scene.choices import PlaneModelName

# largest lambda over mu that acts on a particle's own dilatation [-]: that of nu = 0.4
LOCAL_LAME = 4.0
# excess over it that is rounding, relative to lambda
ROUNDING = 1e-9


def lame_constants(material: Material, dimension: int, plane: PlaneModelName) -> tuple[float, float]:
    """Lame's constants lambda and mu [Pa].

    2 mu = E / (1 + nu) (eq. 2); lambda = nu E / (1 - nu^2) in plane stress (eq. 3), and
    nu E / ((1 + nu)(1 - 2 nu)) in plane strain and in 3-D.

    Args:
        material: The material.
        dimension: 2 or 3.
        plane: ``strain`` or ``stress``, in 2-D.
    """
    youngs, nu = material.youngs_modulus, material.poissons_ratio
    if dimension == 2 and plane == "stress":
        lame = nu * youngs / (1.0 - nu**2)
    else:
        lame = nu * youngs / ((1.0 + nu) * (1.0 - 2.0 * nu))
    return lame, 0.5 * youngs / (1.0 + nu)


def law_constants(material: Material, dimension: int, plane: PlaneModelName) -> tuple[float, float]:
    """Lame's constants as the material's law takes them [Pa]: a neo-Hookean one finds plane stress by itself."""
    return lame_constants(material, dimension, "strain" if material.law == "neo_hookean" else plane)


def pressure_wave_speed(material: Material, dimension: int, plane: PlaneModelName) -> float:
    """Speed of pressure waves c_p = sqrt((lambda + 2 mu) / rho) [m/s]."""
    lame, mu = lame_constants(material, dimension, plane)
    return math.sqrt((lame + 2.0 * mu) / material.density)


def mean_lame(material: Material, dimension: int, plane: PlaneModelName) -> float:
    """The part of lambda that acts on the mean dilatation of a neighbourhood [Pa]: the excess over 4 mu.

    It is 0 up to nu = 0.4, and in plane stress, where no constraint of volume acts in the plane.
    """
    if dimension == 2 and plane == "stress":
        return 0.0
    lame, mu = lame_constants(material, dimension, plane)
    excess = lame - LOCAL_LAME * mu
    return excess if excess > ROUNDING * lame else 0.0

"""The factors of the MPS operators, from sums over a full lattice.

Every operator is scaled so that it is exact there: div x = d, lap r^2 = 2 d, grad of a linear field. With
w = r_e/r - 1 and x_ij = x_j - x_i:

    div u = divergence * sum_j x_ij . u_ij / r^3     (the rate of the number density; Khayyer & Gotoh 2009)
    lap p = laplacian * sum_j w p_ij                 (Koshizuka & Oka 1996)
    grad p = gradient * sum_j g p_ij x_ij / r_e^2    with g = (1 - r/r_e)^3 (Wendland 1995)

and the original gradient with g = w (r_e/r)^2. Its weight grows so fast towards small distances that forces which are
equal and opposite, see `warp_mps.fluid.gradient`, make deep water unstable where the lattice does not fit its tank.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Khayyer, A. and Gotoh, H., Coastal Engineering 56 (2009) 419.
    Wendland, H., Advances in Computational Mathematics 4 (1995) 389.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warp_mps.core.weights import lattice_distances, weight


@dataclass(frozen=True)
class Operators:
    """Factors of the operators.

    Attributes:
        radius: Effective radius r_e [m].
        number_density: Number density n0 of a full lattice [-].
        smooth_density: Smooth number density S0 of a full lattice [-], see `warp_mps.fluid.volumes`.
        neighbours: Number of neighbours in a full lattice.
        divergence: Factor of the divergence [m].
        laplacian: Factor of the Laplacian [1/m^2].
        gradient: Factor of the gradient [-].
        original_gradient: Factor of the original gradient [-].
        beyond: Factors b1, b2 of what lies beyond a free surface [-], see `warp_mps.fluid.pressure.rows`.
    """

    radius: float
    number_density: float
    smooth_density: float
    neighbours: int
    divergence: float
    laplacian: float
    gradient: float
    original_gradient: float
    beyond: tuple[float, float]


def operators(dimension: int, spacing: float, effective_radius: float) -> Operators:
    """Factors for a dimension and a spacing.

    Args:
        dimension: 2 or 3.
        spacing: Particle spacing l0 [m].
        effective_radius: In spacings [-].
    """
    r = lattice_distances(dimension, effective_radius)
    r = r[r < effective_radius]
    w = weight(r, effective_radius)
    return Operators(
        radius=effective_radius * spacing,
        number_density=float(w.sum()),
        smooth_density=float(1.0 + np.sum((1.0 - (r / effective_radius) ** 2) ** 4)),
        neighbours=len(r),
        divergence=float(dimension / np.sum(1.0 / r)) * spacing,
        laplacian=float(2.0 * dimension / np.sum(w * r**2)) / spacing**2,
        gradient=gradient_factor(dimension, effective_radius),
        original_gradient=float(dimension / w.sum()),
        beyond=_beyond(dimension, effective_radius),
    )


def gradient_factor(dimension: int, radius: float) -> float:
    """Factor of the gradient with the pair weight (1 - r/r_e)^3 [-].

    Args:
        dimension: 2 or 3.
        radius: Radius r_e of the weight [l0].
    """
    q = lattice_distances(dimension, radius) / radius
    q = q[q < 1.0]
    return float(dimension / np.sum((1.0 - q) ** 3 * q**2))


def _beyond(dimension: int, reach: float) -> tuple[float, float]:
    """Factors b1, b2 with M/(n0 s) = q (b1 + b2 q) in the two rows below a plane surface of a lattice.

    q is the share of the number density n0 that is beyond the surface, M the sum of w times the height above the
    particle there, and s the particle's depth, 0.5 and 1.5 spacings.
    """
    line = np.arange(-math.ceil(reach), math.ceil(reach) + 1)
    x = np.stack(np.meshgrid(*[line] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    r = np.linalg.norm(x, axis=1)
    near = (r > 0.0) & (r < reach)
    height, w = x[near, 1], weight(r[near], reach)
    shares, slopes = [], []
    for row in (1, 2):
        gone = height >= row
        shares.append(w[gone].sum() / w.sum())
        slopes.append(w[gone] @ height[gone] / (row - 0.5) / w.sum())
    if shares[1] == 0.0:  # the second row does not reach beyond
        return float(slopes[0] / shares[0]), 0.0
    first, second = np.linalg.solve([[q, q**2] for q in shares], slopes)
    return float(first), float(second)

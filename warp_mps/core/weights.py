"""The MPS weight and Wendland's C2 kernel, on arrays and in Warp kernels, and sums of the weight over a full lattice.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421; eqs. 5 and 8 of the paper.
    Wendland, H., Advances in Computational Mathematics 4 (1995) 389.
"""

import functools
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from warp_mps.core.types import NumericTypes

# distances below this share of r_e count as this share, so that two particles in one place have a finite weight
LEAST_DISTANCE = 1.0e-6
# a lattice places neighbours exactly at r_e: rounding must not decide which particles are neighbours
REACH_TOLERANCE = 1.0 + 1e-6


def weight(r: np.ndarray, r_e: np.ndarray | float) -> np.ndarray:
    """Weight w(r) = r_e / r - 1 for r < r_e, else 0 (eq. 5) [-]."""
    return np.maximum(r_e / r - 1.0, 0.0)


@functools.cache
def weight_function(types: "NumericTypes") -> Any:
    """The weight w(r) = r_e / r - 1 for r < r_e, else 0 (eq. 5), as a Warp function `weight(r, r_e)` of two reals.

    It is finite at r = 0; see `LEAST_DISTANCE`.
    """
    # the sums over lattices are needed where Warp is not loaded
    import warp as wp

    real = types.real

    @types.func("weights")
    def weight(r: real, r_e: real) -> real:
        """w(r) = r_e / r - 1 for r < r_e, else 0 (Koshizuka & Oka 1996, eq. 5) [-]."""
        return wp.max(r_e / wp.max(r, real(wp.static(LEAST_DISTANCE)) * r_e) - real(1.0), real(0.0))

    return weight


def wendland_c2(s: np.ndarray) -> np.ndarray:
    """Wendland's C2 kernel W(s) = (1 - s)^4 (1 + 4 s) of s = r / support, 0 beyond s = 1 [-]."""
    return np.maximum(1.0 - s, 0.0) ** 4 * (1.0 + 4.0 * s)


def wendland_c2_slope(s: np.ndarray) -> np.ndarray:
    """Derivative dW/ds = -20 s (1 - s)^3 of Wendland's C2 kernel [-]."""
    return -20.0 * s * np.maximum(1.0 - s, 0.0) ** 3


@functools.cache
def wendland_functions(types: "NumericTypes") -> SimpleNamespace:
    """Wendland's C2 kernel as the Warp functions `wendland_c2(s)` and `wendland_c2_slope_ratio(s)` of a real s >= 0."""
    # the sums over lattices are needed where Warp is not loaded
    import warp as wp

    real = types.real

    @types.func("weights")
    def wendland_c2(s: real) -> real:
        """W(s) = (1 - s)^4 (1 + 4 s) for s < 1, else 0 (Wendland 1995) [-]."""
        t = wp.max(real(1.0) - s, real(0.0))
        return t * t * t * t * (real(1.0) + real(4.0) * s)

    @types.func("weights")
    def wendland_c2_slope_ratio(s: real) -> real:
        """-W'(s) / s = 20 (1 - s)^3 for s < 1, else 0; finite at s = 0 [-]."""
        t = wp.max(real(1.0) - s, real(0.0))
        return real(20.0) * t * t * t

    return SimpleNamespace(wendland_c2=wendland_c2, wendland_c2_slope_ratio=wendland_c2_slope_ratio)


def lattice_number_density(dimension: int, effective_radius: float) -> float:
    """Particle number density n0 = sum_j w inside a full lattice (eq. 8) [-].

    Args:
        dimension: 2 or 3.
        effective_radius: Effective radius in units of the spacing [-].
    """
    return float(np.sum(weight(lattice_distances(dimension, effective_radius), effective_radius)))


def lattice_neighbours(dimension: int, effective_radius: float) -> int:
    """Number of neighbours inside a full lattice, as the search finds them.

    Args:
        dimension: 2 or 3.
        effective_radius: Effective radius in units of the spacing [-].
    """
    return int(np.sum(lattice_distances(dimension, effective_radius) < effective_radius * REACH_TOLERANCE))


def lattice_distances(dimension: int, effective_radius: float) -> np.ndarray:
    """Distances to all other points of a lattice about one of its points, in spacings."""
    reach = np.arange(-int(effective_radius) - 1, int(effective_radius) + 2)
    offsets = np.stack(np.meshgrid(*[reach] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    distances = np.linalg.norm(offsets, axis=1)
    return distances[distances > 0.0]

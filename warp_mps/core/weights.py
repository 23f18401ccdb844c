"""The MPS weight function and what it sums to on a full lattice.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421; eqs. 5 and 8 of the paper.
"""

import numpy as np

# a lattice places neighbours exactly at r_e: rounding must not decide who is one
REACH_TOLERANCE = 1.0 + 1e-6


def weight(r: np.ndarray, r_e: np.ndarray | float) -> np.ndarray:
    """Weight w(r) = r_e / r - 1 for r < r_e, else 0 (eq. 5) [-]."""
    return np.maximum(r_e / r - 1.0, 0.0)


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

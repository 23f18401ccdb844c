"""Particles at the surface of a set, and the nearest of one set to those of another."""

from __future__ import annotations

import numpy as np

from warp_mps.shapes.point_search import cell_pairs, nearest_points

# in spacings: how far off its place a neighbour on a lattice may be, which may be stretched and turned
BESIDE = 1.3


def surface_particles(positions: np.ndarray, spacing: float) -> np.ndarray:
    """Flags of the particles that have fewer neighbours beside them than one inside a lattice, shape [n].

    Args:
        positions: Positions [m], shape [n, d].
        spacing: Particle spacing [m].
    """
    x, counts = _in_space(positions), np.zeros(len(positions), np.int64)
    for owners, others in cell_pairs(x, x, BESIDE * spacing):
        close = np.linalg.norm(x[owners] - x[others], axis=1) <= BESIDE * spacing
        counts += np.bincount(owners[close], minlength=len(x))
    # a particle is a neighbour of itself here
    return counts < 2 * positions.shape[1] + 1


def nearest_offsets(queries: np.ndarray, points: np.ndarray, distance: float) -> np.ndarray:
    """Vectors from each query to the nearest of the points [m], NaN where none is within a distance, shape [n, d].

    Args:
        queries: Positions [m], shape [n, d].
        points: Points [m], shape [m, d].
        distance: Largest distance [m].
    """
    result = np.full(queries.shape, np.nan)
    low, high = points.min(axis=0) - distance, points.max(axis=0) + distance
    near = np.flatnonzero(np.all((queries >= low) & (queries <= high), axis=1))
    low, high = queries.min(axis=0) - distance, queries.max(axis=0) + distance
    points = points[np.all((points >= low) & (points <= high), axis=1)]
    if not len(near) or not len(points):
        return result
    _, nearest = nearest_points(_in_space(queries[near]), _in_space(points), distance)
    found = nearest >= 0
    result[near[found]] = points[nearest[found]] - queries[near[found]]
    return result


def _in_space(positions: np.ndarray) -> np.ndarray:
    """Positions with a third coordinate, in 2-D 0, shape [n, 3]."""
    return np.pad(positions, ((0, 0), (0, 3 - positions.shape[1])))

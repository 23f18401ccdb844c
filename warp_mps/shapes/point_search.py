"""Search for the nearest of a set of points, by sorting them into cells."""

from __future__ import annotations

import numpy as np

from warp_mps.shapes.lattice import expand, product


def near_points(queries: np.ndarray, points: np.ndarray, distance: float) -> np.ndarray:
    """Whether each query lies within a distance of one of the points.

    Args:
        queries: Positions to test [m], shape [n, 3].
        points: Points [m], shape [m, 3].
        distance: Largest distance [m].

    Returns:
        Flags, shape [n].
    """
    near = np.zeros(len(queries), bool)
    if not len(points) or not len(queries):
        return near
    lower = np.minimum(points.min(0), queries.min(0))
    span = np.maximum(points.max(0), queries.max(0)) - lower
    # Cells no finer than 2^-19 of the span keep the packed key within 62 bits.
    size = max(distance, float(span.max()) * 2.0**-19, 1e-300)
    order, keys = _sorted_keys(points, lower, size)
    for shift in product([np.arange(-1, 2)] * 3):
        wanted = _pack(np.floor((queries - lower) / size).astype(np.int64) + shift)
        first = np.searchsorted(keys, wanted, "left")
        owners, entries = expand(first, np.searchsorted(keys, wanted, "right") - first)
        close = np.linalg.norm(queries[owners] - points[order[entries]], axis=1) <= distance
        near[owners[close]] = True
    return near


def _sorted_keys(points: np.ndarray, lower: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    keys = _pack(np.floor((points - lower) / size).astype(np.int64))
    order = np.argsort(keys, kind="stable")
    return order, keys[order]


def _pack(cell: np.ndarray) -> np.ndarray:
    shifted = cell + 1
    return (shifted[:, 0] << 40) | (shifted[:, 1] << 20) | shifted[:, 2]

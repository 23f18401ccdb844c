"""Regular lattices over a box, and the pair lists that searches on a lattice of cells need."""

from __future__ import annotations

import numpy as np


def cells(extent: float, spacing: float, *, whole: bool, nodes: bool) -> int:
    """Number of particles along an axis.

    Args:
        extent: Length to fill [m].
        spacing: Particle spacing [m].
        whole: Whether the ends are faces that the lattice fits between (a box), so that the nearest number of
            particles is right; otherwise the lattice covers the extent and what lies outside is dropped later.
        nodes: Whether the outermost particles lie on the ends rather than half a spacing inside.

    Returns:
        The number, below 1 if the extent is thinner than one particle.
    """
    ratio = extent / spacing
    if round(ratio) < 1:
        return 0
    if nodes:
        return round(ratio) + 1
    # A length that is a multiple of the spacing but for rounding must not gain a cell.
    return round(ratio) if whole else int(np.ceil(ratio - 1e-6))


def coordinates(centre: float, count: int, spacing: float) -> np.ndarray:
    """Coordinates of `count` particles, symmetric about the centre [m], shape [count]."""
    return centre + (np.arange(count) - 0.5 * (count - 1)) * spacing


def product(lines: list[np.ndarray]) -> np.ndarray:
    """Every combination of the coordinates of each axis, the last axis fastest, shape [n, axes]."""
    grids = np.meshgrid(*lines, indexing="ij")
    return np.stack([grid.ravel() for grid in grids], axis=1)


def rigid_axes(linear: np.ndarray) -> np.ndarray | None:
    """Directions of the local axes under a linear map, or None if the map shears.

    Args:
        linear: Linear map, columns are the images of the local axes, shape [3, 3].

    Returns:
        Unit columns, orthogonal to each other, shape [3, 3].
    """
    axes = linear / np.linalg.norm(linear, axis=0)
    return axes if np.allclose(axes.T @ axes, np.eye(3), atol=1e-9) else None


def expand(starts: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (owner, entry) of a list of ranges.

    Args:
        starts: First entry of each owner's range, shape [n].
        counts: Number of entries in each range, shape [n].

    Returns:
        The owner and the entry of each pair, two arrays of shape [sum of counts].
    """
    owners = np.repeat(np.arange(len(counts)), counts)
    offsets = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owners, np.repeat(starts, counts) + offsets


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

"""Search among a set of points for near ones, by sorting them into cells."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.shapes.lattice import expand, product

# number of queries whose candidates are held in memory at a time
BLOCK = 50_000
# cells are numbered by these; two far apart may share a number, which costs candidates and changes no result
FACTORS = np.array([2_654_435_761 * 40_503, 73_856_093, 1], np.int64)
MASK = 2**62 - 1
# least edge of a cell as a share of the extent of the points
FINEST = 2.0**-50


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
    for owners, entries in cell_pairs(queries, points, distance):
        near[owners[np.linalg.norm(queries[owners] - points[entries], axis=1) <= distance]] = True
    return near


def nearest_points(
    queries: np.ndarray, points: np.ndarray, reach: float, own: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The nearest of a set of points to each query.

    Args:
        queries: Positions to look from [m], shape [n, 3].
        points: Points [m], shape [m, 3].
        reach: Largest distance to look at [m].
        own: Indices of the points that the queries are, which are left out, shape [n]; None where they are others.

    Returns:
        Distances, infinite where there is none within reach [m], and indices of the nearest points, both of shape [n].
    """
    distances, nearest = np.full(len(queries), np.inf), np.full(len(queries), -1)
    for owners, entries in cell_pairs(queries, points, reach):
        apart = np.linalg.norm(queries[owners] - points[entries], axis=1)
        allowed = apart <= reach if own is None else (own[owners] != entries) & (apart <= reach)
        good = np.flatnonzero(allowed)
        # farthest first, so that the last one to be assigned is the nearest
        good = good[np.argsort(-apart[good], kind="stable")]
        closer = good[apart[good] < distances[owners[good]]]
        distances[owners[closer]], nearest[owners[closer]] = apart[closer], entries[closer]
    return distances, nearest


def pair_in_a_cell(points: np.ndarray, distance: float) -> tuple[int, int] | None:
    """Two points within a distance [m] that share a cell of that diagonal, if any do; points have shape [n, 3].

    It finds a dense cluster before a search for the neighbours of each of its points would take too long.
    """
    lower = points.min(0)
    keys = _keys(points, lower, max(distance / np.sqrt(3.0), FINEST * _extent(points, lower), 1e-300))
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(np.diff(keys[order]) == 0)
    one, other = order[same], order[same + 1]
    near = np.flatnonzero(np.linalg.norm(points[one] - points[other], axis=1) <= distance)
    return (int(one[near[0]]), int(other[near[0]])) if len(near) else None


def crowd(points: np.ndarray, size: float) -> float:
    """Mean number of points in the cell of a point, of cells with an edge [m]; points have shape [n, 3]."""
    counts = np.unique(_keys(points, points.min(0), size), return_counts=True)[1]
    return float((counts.astype(float) ** 2).sum() / len(points))


def cell_pairs(queries: np.ndarray, points: np.ndarray, distance: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs (query, point) whose cells, as wide as a distance [m], are the same or neighbours, in blocks.

    Args:
        queries: Positions to look from [m], shape [n, 3].
        points: Points [m], shape [m, 3].
        distance: Distance within which no point is missed [m].

    Yields:
        Indices of queries and of points, two arrays of the same length; some of the pairs are farther apart.
    """
    if not len(points) or not len(queries):
        return
    lower = np.minimum(points.min(0), queries.min(0))
    size = max(distance, FINEST * max(_extent(points, lower), _extent(queries, lower)), 1e-300)
    keys, wanted = _keys(points, lower, size), _keys(queries, lower, size)
    order, turn = np.argsort(keys, kind="stable"), np.argsort(wanted, kind="stable")
    keys = keys[order]
    # neighbours along the last axis have neighbouring numbers
    shifts = product([np.arange(-1, 2)] * 2) @ FACTORS[:2]
    for start in range(0, len(queries), BLOCK):
        part = turn[start : start + BLOCK]
        for shift in shifts:
            beside = (wanted[part] + shift) & MASK
            first, last = np.searchsorted(keys, beside - 1, "left"), np.searchsorted(keys, beside + 1, "right")
            owners, entries = expand(first, last - first)
            yield part[owners], order[entries]


def _keys(points: np.ndarray, lower: np.ndarray, size: float) -> np.ndarray:
    """Numbers of the cells of points, of at least 0; they overflow without harm."""
    return (np.floor((points - lower) / size).astype(np.int64) * FACTORS).sum(axis=1) & MASK


def _extent(points: np.ndarray, lower: np.ndarray) -> float:
    return float((points - lower).max())

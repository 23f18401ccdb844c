"""Closed surfaces of triangles: how often they wind about points, how near points are, and where they are open.

A ray along z leaves every point; the winding number counts its crossings of the surface. Points and triangles meet
through a grid of cells over x and y, so that a ray sees only the triangles of its own cell.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.shapes.lattice import expand

BLOCK = 1_000_000
# A shift of the rays, in diagonals of the surface, that keeps them off edges and vertices: far above rounding, far
# below a particle spacing, and in no simple ratio of the axes.
RAY_SHIFT = np.array([0.7548776662, 0.5698402910, 0.4301597090]) * 1e-9


def windings(points: np.ndarray, corners: np.ndarray, shells: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Winding numbers of the shells of a closed surface about points, where they are not 0.

    A shell winds about a point as often as a ray from the point leaves it, less the times that the ray enters it.

    Args:
        points: Points [m], shape [n, 3].
        corners: Corners of the triangles [m], those of a shell turned alike, shape [m, 3, 3].
        shells: Shell of each triangle, shape [m].

    Returns:
        The point, the shell and the winding number of each pair, three arrays of equal length.
    """
    lower, upper = corners.min((0, 1)), corners.max((0, 1))
    shift = RAY_SHIFT * np.linalg.norm(upper - lower)
    candidates = np.flatnonzero(((points >= lower - shift) & (points <= upper)).all(1))
    shifted = points[candidates] + shift
    count = int(shells.max()) + 1
    found = [np.zeros((0, 3), np.int64)]
    for owners, triangles in _Grid(corners, 0.0).pairs(shifted):
        signs = _crossings(shifted[owners], corners[triangles])
        hits = signs != 0
        # all triangles that a point meets are in one block
        keys, index = np.unique(owners[hits] * count + shells[triangles[hits]], return_inverse=True)
        sums = np.bincount(index.reshape(-1), signs[hits], len(keys)).astype(np.int64)
        wound = sums != 0
        keys = keys[wound]
        found.append(np.column_stack((candidates[keys // count], keys % count, sums[wound])))
    pairs = np.concatenate(found)
    return pairs[:, 0], pairs[:, 1], pairs[:, 2]


def near_surface(points: np.ndarray, corners: np.ndarray, distance: float) -> np.ndarray:
    """Tell which points lie within a distance [m] of a surface; arguments as for `windings`."""
    near = np.zeros(len(points), bool)
    lower, upper = corners.min((0, 1)) - distance, corners.max((0, 1)) + distance
    candidates = np.flatnonzero(((points >= lower) & (points <= upper)).all(1))
    for owners, triangles in _Grid(corners, distance).pairs(points[candidates]):
        close = _distances(points[candidates[owners]], corners[triangles]) <= distance
        near[candidates[owners[close]]] = True
    return near


def same_places(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number the different places of points, shape [n, 3].

    Returns:
        A point at each place, shape [places], and the place of each point, shape [n].
    """
    order = np.lexsort(points.T)
    first = np.append(True, (np.diff(points[order], axis=0) != 0.0).any(axis=1))
    places = np.empty(len(points), np.int64)
    places[order] = np.cumsum(first) - 1
    return order[first], places


def proper(triangles: np.ndarray) -> np.ndarray:
    """Which triangles have three different vertices, shape [m]."""
    return (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)


def open_edge(triangles: np.ndarray, vertices: np.ndarray) -> str:
    """Where a surface is not closed: an edge that does not belong to exactly two triangles.

    Args:
        triangles: Vertices of each triangle, each place one vertex, shape [m, 3]; those that are not `proper` are left
            out.
        vertices: The vertices [m], shape [n, 3].

    Returns:
        A clause for an error message with the ends of the edge, empty if the surface is closed.
    """
    triangles = triangles[proper(triangles)]
    if not len(triangles):
        return "it has no triangle"
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    keys, counts = np.unique(edges[:, 0] * len(vertices) + edges[:, 1], return_counts=True)
    bad = np.flatnonzero(counts != 2)
    if not len(bad):
        return ""
    ends = np.array(divmod(keys[bad[0]], len(vertices)))
    a, b = (f"({', '.join(f'{c:.6g}' for c in vertices[end])})" for end in ends)
    return f"that from {a} to {b} m belongs to {counts[bad[0]]}, as one of {len(bad)} such edges"


def section(corners: np.ndarray) -> np.ndarray:
    """Ends of the segments in which triangles cross the plane z = 0, shape [segments, 2, 3].

    A corner in the plane counts as below it, so that a closed surface has a closed section.
    """
    ends = []
    above = corners[..., 2] > 0
    for k in range(3):
        a, b = corners[:, k], corners[:, (k + 1) % 3]
        crossing = above[:, k] != above[:, (k + 1) % 3]
        rise = np.where(crossing, b[:, 2] - a[:, 2], 1.0)
        ends.append(np.where(crossing[:, None], a - (a[:, 2] / rise)[:, None] * (b - a), np.nan))
    stacked = np.stack(ends, axis=1)[above.any(1) & ~above.all(1)]
    return stacked[~np.isnan(stacked[..., 0])].reshape(-1, 2, 3)


def _crossings(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """How the ray from each point towards +z crosses the triangle beside it: 1 or -1, 0 where it does not."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area_a, area_b, area_c = _area(points, b, c), _area(points, c, a), _area(points, a, b)
    total = area_a + area_b + area_c
    within = ((area_a > 0) == (area_b > 0)) & ((area_b > 0) == (area_c > 0)) & (total != 0)
    height = area_a * a[:, 2] + area_b * b[:, 2] + area_c * c[:, 2]
    return np.where(within & (height * np.sign(total) > points[:, 2] * np.abs(total)), np.sign(total), 0.0)


def _area(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a[:, 0] - p[:, 0]) * (b[:, 1] - p[:, 1]) - (a[:, 1] - p[:, 1]) * (b[:, 0] - p[:, 0])


def _distances(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of each point to the triangle beside it [m], shape [n]."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    nearest = np.minimum(_to_edge(points, a, b), np.minimum(_to_edge(points, b, c), _to_edge(points, c, a)))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(length > 0, length, 1.0)[:, None]
    sides = [_dot(np.cross(v - u, points - u), unit) for u, v in ((a, b), (b, c), (c, a))]
    over = (length > 0) & (np.minimum(np.minimum(sides[0], sides[1]), sides[2]) >= 0)
    return np.where(over, np.abs(_dot(points - a, unit)), nearest)


def _to_edge(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    along = b - a
    square = _dot(along, along)
    part = np.clip(_dot(points - a, along) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.linalg.norm(points - a - part[:, None] * along, axis=1)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)


class _Grid:
    """Triangles sorted by the cells over x and y that their bounds, widened by a margin, overlap."""

    def __init__(self, corners: np.ndarray, margin: float) -> None:
        low, high = corners[..., :2].min(1) - margin, corners[..., :2].max(1) + margin
        self.origin = low.min(0)
        self.shape = np.full(2, max(1, min(1024, int(np.sqrt(len(corners))))))
        self.size = np.maximum((high.max(0) - self.origin) / self.shape, 1e-300)
        first, last = self._cell(low), self._cell(high)
        widths = last - first + 1
        owners, entries = expand(np.zeros(len(corners), np.int64), widths.prod(1))
        rows = first[owners, 0] + entries // widths[owners, 1]
        keys = rows * self.shape[1] + first[owners, 1] + entries % widths[owners, 1]
        order = np.argsort(keys, kind="stable")
        self.triangles, self.keys = owners[order], keys[order]

    def _cell(self, points: np.ndarray) -> np.ndarray:
        cell = np.floor((points[:, :2] - self.origin) / self.size).astype(np.int64)
        return np.clip(cell, 0, self.shape - 1)

    def pairs(self, points: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Pairs (point, triangle) that share a cell, in blocks that bound the memory."""
        cell = self._cell(points)
        keys = cell[:, 0] * self.shape[1] + cell[:, 1]
        starts = np.searchsorted(self.keys, keys, "left")
        counts = np.searchsorted(self.keys, keys, "right") - starts
        block = np.cumsum(counts) // BLOCK
        for number in np.unique(block):
            members = np.flatnonzero(block == number)
            owners, entries = expand(starts[members], counts[members])
            yield members[owners], self.triangles[entries]

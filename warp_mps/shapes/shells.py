"""The shells of a closed surface of triangles: which of them bound solids, and which bound cavities in solids.

A shell is a part of the surface whose triangles are connected by edges. What several shells enclose is the union of
their insides, also where they overlap. A shell that is turned opposite to the outermost shell around it is a cavity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warp_mps.shapes.closed_surface import near_surface, proper, windings

# distance up to which a vertex touches another shell, in diagonals of the surface
TOUCHING = 1e-7
SOLID, CAVITY = 1, -1
ONE_SIDED = "the mesh has one side only, so that nothing is inside"


@dataclass(frozen=True, eq=False)
class Shells:
    """The shells of a surface.

    Attributes:
        points: Its vertices [m], shape [n, 3].
        triangles: Vertices of the triangles that are not degenerate, those of a shell turned alike, shape [m, 3].
        numbers: Shell of each of them, shape [m].
        roles: `SOLID` or `CAVITY`, shape [shells].
        idle: A vertex of each solid that lies in another one, not in its cavities, and so adds nothing, shape [n, 3].
        fault: Why the inside is not defined, empty if it is.
    """

    points: np.ndarray
    triangles: np.ndarray
    numbers: np.ndarray
    roles: np.ndarray
    idle: np.ndarray
    fault: str = ""


def find_shells(points: np.ndarray, triangles: np.ndarray) -> Shells:
    """Find the shells of a surface all of whose edges belong to two triangles.

    Args:
        points: Vertices [m], no two at the same place, shape [n, 3].
        triangles: Vertices of each triangle, shape [m, 3].
    """
    triangles = triangles[proper(triangles)]
    first, second, alike = _neighbours(triangles)
    count = len(triangles)
    if not alike.all():
        # each triangle stands twice, as it is and turned over; two neighbours that go alike are of one sheet
        partner = np.where(alike, second, second + count)
        opposite = np.where(alike, second + count, second)
        both = _connected(2 * count, np.append(first, first + count), np.append(partner, opposite))
        as_it_is, over = both[:count], both[count:]
        if (as_it_is == over).any():
            return Shells(points, triangles, np.zeros(count, int), np.ones(1, int), np.zeros((0, 3)), ONE_SIDED)
        numbers = np.unique(np.minimum(as_it_is, over), return_inverse=True)[1].reshape(-1)
        turned = as_it_is > over
        # a shell goes as most of its triangles do
        turned ^= (np.bincount(numbers, turned) > 0.5 * np.bincount(numbers))[numbers]
        triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    else:
        numbers = np.unique(_connected(count, first, second), return_inverse=True)[1].reshape(-1)
    return _with_roles(points, triangles, numbers)


def _neighbours(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The two triangles of each edge, and whether both are turned alike: they pass it in opposite directions."""
    count = len(triangles)
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = ends[:, 0] < ends[:, 1]
    order = np.lexsort(np.sort(ends, axis=1).T)
    first, second = order[0::2], order[1::2]
    return first % count, second % count, forward[first] != forward[second]


def _connected(count: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The least number among the nodes that each node is connected with, shape [count]."""
    label = np.arange(count)
    while True:
        low = np.minimum(label[first], label[second])
        lower = label.copy()
        np.minimum.at(lower, label[first], low)
        np.minimum.at(lower, label[second], low)
        while not np.array_equal(lower, lower[lower]):
            lower = lower[lower]
        if np.array_equal(lower, label):
            return label
        label = lower


def _with_roles(points: np.ndarray, triangles: np.ndarray, numbers: np.ndarray) -> Shells:
    """The shells with their roles, by what lies in what."""
    count = int(numbers.max()) + 1
    roles = np.full(count, SOLID)
    if count == 1:
        return Shells(points, triangles, numbers, roles, np.zeros((0, 3)))
    corners = points[triangles]
    centred = corners - points.mean(axis=0)
    parts = np.einsum("ij,ij->i", centred[:, 0], np.cross(centred[:, 1], centred[:, 2])) / 6.0
    volumes = np.bincount(numbers, parts, count)
    shells, vertices = _vertices(triangles, numbers, len(points))
    vertex = dict(zip(shells[::-1].tolist(), vertices[::-1].tolist(), strict=True))
    around: dict[int, list[int]] = {}
    crossing = []
    for inner, outer, share in _nested(points[vertices], shells, corners, numbers):
        opposite = volumes[inner] * volumes[outer] < 0
        touching = share < 1.0 and opposite
        clear = _clear_share(points[vertices[shells == inner]], corners, numbers, outer) if touching else share
        if clear == 1.0:
            around.setdefault(inner, []).append(outer)
        elif opposite and clear > 0.0:
            crossing.append((inner, outer))
    outermost = {inner: max(outers, key=lambda number: abs(volumes[number])) for inner, outers in around.items()}
    cavities = {inner for inner, outer in outermost.items() if volumes[inner] * volumes[outer] < 0}
    roles[[*sorted(cavities)]] = CAVITY
    # a solid in a cavity of another one does add something
    idle = [
        points[vertex[inner]] for inner, outers in around.items() if inner not in cavities and roles[outers].sum() > 0
    ]
    # a cavity of one solid may cross another
    wrong = [inner for inner, outer in crossing if not {inner, outer} & cavities]
    fault = ""
    if wrong:
        place = f"({', '.join(f'{c:.6g}' for c in points[vertex[wrong[0]]])})"
        fault = (
            f"the mesh has shells that cross and are turned opposite ways, one of them at {place} m: turn both alike"
        )
    return Shells(points, triangles, numbers, roles, np.array(idle).reshape(-1, 3), fault)


def _vertices(triangles: np.ndarray, numbers: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """The vertices of each shell, as pairs of a shell and a vertex, two arrays of equal length."""
    keys = np.unique(np.repeat(numbers, 3) * points + triangles.reshape(-1))
    return keys // points, keys % points


def _nested(
    vertices: np.ndarray, shells: np.ndarray, corners: np.ndarray, numbers: np.ndarray
) -> Iterator[tuple[int, int, float]]:
    """Pairs of shells of which the second winds about vertices of the first, and about which share of them."""
    owners, outer, _ = windings(vertices, corners, numbers)
    inner, count = shells[owners], int(numbers.max()) + 1
    keys, sums = np.unique(inner[inner != outer] * count + outer[inner != outer], return_counts=True)
    totals = np.bincount(shells, minlength=count)
    for key, number in zip(keys.tolist(), sums.tolist(), strict=True):
        yield key // count, key % count, number / totals[key // count]


def _clear_share(vertices: np.ndarray, corners: np.ndarray, numbers: np.ndarray, outer: int) -> float:
    """Share of the vertices that a shell winds about among those that do not touch it, where rounding decides."""
    reach = TOUCHING * float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    own = corners[numbers == outer]
    clear = vertices[~near_surface(vertices, own, reach)]
    return len(windings(clear, own, np.zeros(len(own), int))[0]) / max(1, len(clear))

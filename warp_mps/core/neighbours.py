"""Neighbour lists, found with `wp.HashGrid` and stored, so that the kernels of a method never search.

A list has a row for each particle: entries `start[i]` to `start[i + 1]` of `index`, sorted by neighbour, so that the
sums over a row do not depend on the order of the cells in the grid.
"""

import functools
from types import SimpleNamespace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes, numeric_types
from warp_mps.core.weights import REACH_TOLERANCE

METHOD = "neighbours"


@functools.cache
def neighbour_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `count` and `fill` of a reference neighbour list."""
    real, vec3 = types.real, types.vec3

    @types.kernel(METHOD)
    def count(
        # Model:
        grid: wp.uint64,  # hash grid of the particles
        points: wp.array(dtype=vec3),  # positions [m], [n]
        groups: wp.array(dtype=wp.int32),  # groups of bonded bodies, [n]
        reach: wp.array(dtype=real),  # effective radii r_e [m], [n]
        cell: real,  # largest effective radius [m]
        # State out:
        counts_out: wp.array(dtype=wp.int32),  # number of neighbours, [n]
    ):
        """Number of neighbours: particles of the same group with |x_ij| < (r_e,i + r_e,j) / 2."""
        i = wp.tid()
        found = wp.int32(0)
        for j in wp.hash_grid_query(grid, points[i], cell):
            r = wp.length(points[j] - points[i])
            if j != i and groups[j] == groups[i] and r < real(0.5) * (reach[i] + reach[j]):
                found += 1
        counts_out[i] = found

    @types.kernel(METHOD)
    def fill(
        # Model:
        grid: wp.uint64,  # hash grid of the particles
        points: wp.array(dtype=vec3),  # positions [m], [n]
        groups: wp.array(dtype=wp.int32),  # groups of bonded bodies, [n]
        reach: wp.array(dtype=real),  # effective radii r_e [m], [n]
        cell: real,  # largest effective radius [m]
        start: wp.array(dtype=wp.int32),  # first entry of each row, [n + 1]
        # State out:
        index_out: wp.array(dtype=wp.int32),  # neighbours, row by row, [pairs]
    ):
        """Row of the list: the neighbours of a particle, sorted."""
        i = wp.tid()
        first = start[i]
        last = first
        for j in wp.hash_grid_query(grid, points[i], cell):
            r = wp.length(points[j] - points[i])
            if j != i and groups[j] == groups[i] and r < real(0.5) * (reach[i] + reach[j]):
                k = last
                while k > first and index_out[wp.max(k - 1, first)] > j:
                    index_out[k] = index_out[k - 1]
                    k -= 1
                index_out[k] = j
                last += 1

    return SimpleNamespace(count=count, fill=fill)


def make_grid(extent: np.ndarray, cell: float, *, types: NumericTypes, device: Any) -> wp.HashGrid:
    """A hash grid that spans a domain, with cells as wide as the search radius, and one out of the plane in 2-D.

    Args:
        extent: Size of the domain [m], shape [d].
        cell: Width of a cell [m].
        types: Number types.
        device: Warp device.
    """
    # cells beyond the grid alias, which is correct but slower: a very large domain gets a smaller grid
    cells = [int(np.clip(np.ceil(length / cell) + 1, 1, 2048 if types.dimension == 2 else 256)) for length in extent]
    dims = (*cells, 1) if types.dimension == 2 else tuple(cells)
    return wp.HashGrid(*dims, device=device, dtype=types.real)


def as_vec3(positions: np.ndarray) -> np.ndarray:
    """Positions as 3-vectors, with 0 out of the plane in 2-D."""
    return np.pad(positions, ((0, 0), (0, 3 - positions.shape[1])))


def reference_neighbours(
    positions: np.ndarray, groups: np.ndarray, reach: np.ndarray, *, device: Any
) -> tuple[wp.array, wp.array]:
    """All pairs of a reference configuration that are closer than their mean reach, as a list.

    The search runs in double precision whatever that of the run: the neighbours must not depend on it.

    Args:
        positions: Reference positions X [m], shape [n, d].
        groups: Only particles of the same group are neighbours, shape [n].
        reach: Effective radius of each particle [m], shape [n].
        device: Warp device on which the search runs.

    Returns:
        `start`, shape [n + 1], and `index`, shape [start[n]], on the device.

    Raises:
        MemoryError: There are more pairs than a 32-bit index can address.
    """
    types = numeric_types(positions.shape[1], "float64")
    kernels = neighbour_kernels(types)
    n = len(positions)
    cell = float(reach.max()) * REACH_TOLERANCE
    low = positions.min(axis=0)
    points = wp.array(as_vec3(positions - low), dtype=types.vec3, device=device)
    grid = make_grid(positions.max(axis=0) - low, cell, types=types, device=device)
    grid.build(points, cell)
    radii = wp.array(reach * REACH_TOLERANCE, dtype=types.real, device=device)
    group = wp.array(groups, dtype=wp.int32, device=device)
    counts = wp.empty(n, dtype=wp.int32, device=device)
    wp.launch(kernels.count, n, [grid.id, points, group, radii, cell], [counts], device=device)
    start = np.concatenate(([0], np.cumsum(counts.numpy(), dtype=np.int64)))
    if start[-1] >= 2**31:
        raise MemoryError(
            f"the scene has {start[-1]} pairs of neighbours, must be fewer than 2^31; use a larger spacing or a "
            "smaller effective radius"
        )
    index = wp.empty(int(start[-1]), dtype=wp.int32, device=device)
    starts = wp.array(start.astype(np.int32), dtype=wp.int32, device=device)
    wp.launch(kernels.fill, n, [grid.id, points, group, radii, cell, starts], [index], device=device)
    return starts, index

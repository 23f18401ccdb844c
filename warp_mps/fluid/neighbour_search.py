"""Kernels of the search for neighbours, and the table of neighbours that the other kernels read."""

import functools
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD

# share of the room from which on lists ask for more: dam breaks were seen to crowd by 1.25 in 3-D, and by 1.14 in 2-D
FULL = 0.8


@functools.cache
def neighbour_table_struct() -> Any:
    """The Warp struct `NeighbourTable`."""

    @wp.struct
    class NeighbourTable:
        """The neighbours of n particles.

        Attributes:
            index: Neighbours of each particle, in no order, [n, room].
            count: Number of neighbours of each particle, [n].
        """

        index: wp.array(dtype=wp.int32, ndim=2)
        count: wp.array(dtype=wp.int32)

    return NeighbourTable


@functools.cache
def neighbour_search_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `locate_in_cells` and `search_neighbours`."""
    real, vec, vec3, d = types.real, types.vec, types.vec3, types.dimension
    displacement = displacement_function(types)

    @types.kernel(METHOD)
    def locate_in_cells(
        # Model:
        low: vec,
        cell: vec,
        cells: vec,
        margin: real,
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        x_listed: wp.array(dtype=vec),  # positions at which the lists were made [m], [n]
        # State out:
        points_out: wp.array(dtype=vec3),  # positions in cells [-], [n]
        stale_out: wp.array(dtype=wp.int32),  # 1 if a particle has moved too far, else untouched, [1]
    ):
        """Positions in cells, (x - low)/cell + cells, and whether a particle has moved by half of the margin."""
        i = wp.tid()
        point = vec3()
        x_i = x[i]
        for axis in range(wp.static(d)):
            # a grid's cells are counted from 0: away from it, or rounding towards it would join two of them
            point[axis] = (x_i[axis] - low[axis]) / cell[axis] + cells[axis]
        points_out[i] = point
        moved = x_i - x_listed[i]
        if real(4.0) * wp.dot(moved, moved) > margin * margin:
            stale_out[0] = 1

    @types.kernel(METHOD)
    def search_neighbours(
        # Model:
        grid: wp.uint64,
        reach: real,
        period: vec,
        walls: wp.int32,
        # State in:
        points: wp.array(dtype=vec3),  # positions in cells [-], [n]
        x: wp.array(dtype=vec),  # positions [m], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        # State out:
        listed_out: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count_out: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        x_listed_out: wp.array(dtype=vec),  # positions of the lists [m], [n]
        overflow_out: wp.array(dtype=wp.int32),  # 1 + a particle whose list is too short, else untouched, [1]
        crowded_out: wp.array(dtype=wp.int32),  # 1 if a list is nearly full, else untouched, [1]
        stale_out: wp.array(dtype=wp.int32),  # 0, [1]
    ):
        """List the neighbours of a particle within the reach, |x_ij| < reach; wall-wall pairs are excluded."""
        i = wp.tid()
        n = wp.int32(0)
        x_i = x[i]
        if lost[i] == 0:
            for j in wp.hash_grid_query(grid, points[i], real(1.0)):
                if i >= walls or j >= walls:
                    # most of what a query gives is too far away, so that this is asked before the rest
                    x_ij = displacement(x_i, x[j], period)
                    if wp.dot(x_ij, x_ij) < reach * reach and j != i and lost[j] == 0:
                        if n < listed_out.shape[1]:
                            listed_out[i, n] = j
                            n += 1
                        else:
                            overflow_out[0] = i + 1
        count_out[i] = n
        if real(n) > real(FULL) * real(listed_out.shape[1]):
            crowded_out[0] = 1
        x_listed_out[i] = x_i
        if i == 0:
            stale_out[0] = 0

    return SimpleNamespace(locate_in_cells=locate_in_cells, search_neighbours=search_neighbours)

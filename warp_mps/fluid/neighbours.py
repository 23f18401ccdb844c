"""Neighbour lists of moving particles, kept as long as they hold.

They are found with `wp.HashGrid`, a margin beyond the effective radius, and made anew when a particle has moved by half
of that margin. The grid is built over coordinates in units of its cells, so that along a periodic axis a whole number
of cells fits the period: the grid's own wrapping then finds the neighbours across it.

A list has room for more neighbours than water has. Where a cluster of particles comes close to filling one, all lists
get twice the room, up to a limit; a cluster that comes at once, and does not fit, is left out of its lists until then.
"""

import functools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import lattice_neighbours
from warp_mps.fluid import METHOD
from warp_mps.scene.numerics import SKIN

# room for neighbours, in units of those in even water
ROOM = 1.75
# share of the room from which on lists ask for more: dam breaks were seen to crowd by 1.25 in 3-D, and by 1.14 in 2-D
FULL = 0.8
# the room that they may have, in units of that at first
MOST_ROOM = 8
MOST_CELLS = {2: 4096, 3: 512}


def expected_neighbours(dimension: int, effective_radius: float) -> int:
    """Neighbours in a list of even water, the margin included: of a full lattice, or of disorder, which has no shells.

    Args:
        dimension: 2 or 3.
        effective_radius: In spacings [-].
    """
    reach = effective_radius + SKIN
    ball = math.pi * reach**2 if dimension == 2 else 4.0 / 3.0 * math.pi * reach**3
    return max(lattice_neighbours(dimension, reach), round(ball) - 1)


@functools.cache
def neighbour_list_kernels(types: NumericTypes) -> SimpleNamespace:
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
        x: wp.array(dtype=vec),
        x_listed: wp.array(dtype=vec),
        # Out:
        points_out: wp.array(dtype=vec3),
        stale_out: wp.array(dtype=wp.int32),
    ):
        """Positions in cells, and whether any particle has moved by half of the margin since the last list."""
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
        points: wp.array(dtype=vec3),
        x: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        # Out:
        listed_out: wp.array(dtype=wp.int32, ndim=2),
        count_out: wp.array(dtype=wp.int32),
        x_listed_out: wp.array(dtype=vec),
        overflow_out: wp.array(dtype=wp.int32),
        crowded_out: wp.array(dtype=wp.int32),
        stale_out: wp.array(dtype=wp.int32),
    ):
        """List the neighbours of a particle; walls, which come first, are none to each other."""
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


class NeighbourLists:
    """The lists of a set of particles, of which the first ones are walls.

    Attributes:
        listed: Neighbours of each particle, int32 [n, room].
        count: Number of neighbours of each particle, int32 [n].
        x_listed: Positions at which the lists were made [m], vec [n].
        stale: Whether they must be made anew, int32 [1].
        period: Period along each axis [m], 0 where there is none.

    Args:
        count: Number of particles.
        walls: Number of those that are walls, the first ones.
        low: Lowest corner of the domain [m].
        high: Its highest corner [m].
        periodic: Its periodic axes.
        radius: Effective radius [m].
        spacing: Particle spacing [m].
        neighbours: Neighbours of even water, for which there is room and to spare; see `expected_neighbours`.
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self,
        count: int,
        *,
        walls: int,
        low: np.ndarray,
        high: np.ndarray,
        periodic: tuple[int, ...],
        radius: float,
        spacing: float,
        neighbours: int,
        types: NumericTypes,
        device: Any,
    ) -> None:
        self._kernels, self._device, self._walls = neighbour_list_kernels(types), device, walls
        d, self._margin = types.dimension, SKIN * spacing
        self._reach = radius + self._margin
        size = np.asarray(high, float) - low
        cells = np.clip(np.floor(size / self._reach), 1, MOST_CELLS[d])
        wraps = np.isin(np.arange(d), periodic)
        cell = np.where(wraps, size / cells, self._reach)
        dims = [int(c) + (0 if wrap else 1) for c, wrap in zip(cells, wraps, strict=True)]
        self._low, self._cell, self._cells = types.vec(*low), types.vec(*cell), types.vec(*dims)
        self.period = types.vec(*np.where(wraps, size, 0.0))
        self._grid = wp.HashGrid(*(*dims, 1)[:3], device=device, dtype=types.real)
        self._grid.reserve(count)
        width = int(ROOM * neighbours)
        self._points = wp.zeros(count, dtype=types.vec3, device=device)
        self.x_listed = wp.zeros(count, dtype=types.vec, device=device)
        self.listed = wp.zeros((count, width), dtype=wp.int32, device=device)
        self._most_room = MOST_ROOM * width
        self.count = wp.zeros(count, dtype=wp.int32, device=device)
        self.stale = wp.zeros(1, dtype=wp.int32, device=device)
        self._overflow = wp.zeros(1, dtype=wp.int32, device=device)
        self._crowded = wp.zeros(1, dtype=wp.int32, device=device)

    def renew(self, x: wp.array, lost: wp.array) -> None:
        """Launch new lists, whether or not the old ones are stale."""
        self.stale.fill_(1)
        self.update(x, lost)

    def update(self, x: wp.array, lost: wp.array) -> None:
        """Launch new lists if a particle has moved far enough since they were made."""
        inputs = [self._low, self._cell, self._cells, self._margin, x, self.x_listed]
        wp.launch(self._kernels.locate_in_cells, len(x), inputs, [self._points, self.stale], device=self._device)
        wp.capture_if(self.stale, self._search, x=x, lost=lost)

    def overflowed(self) -> int | None:
        """A particle that has had more neighbours than the lists hold, if there was one."""
        particle = int(self._overflow.numpy()[0])
        return particle - 1 if particle else None

    @property
    def can_grow(self) -> bool:
        """Whether the lists may have more room."""
        return 2 * self.listed.shape[1] <= self._most_room

    def crowded(self) -> bool:
        """Whether a list has come close to its room, or beyond it, since they were given more."""
        return bool(self._crowded.numpy()[0])

    def grow(self) -> None:
        """Give the lists twice the room, in new arrays; they are empty until they are made anew."""
        count, width = self.listed.shape
        self.listed = wp.zeros((count, 2 * width), dtype=wp.int32, device=self._device)
        self.count.zero_()
        self._overflow.zero_()
        self._crowded.zero_()

    def _search(self, x: wp.array, lost: wp.array) -> None:
        self._grid.build(self._points, 1.0)
        inputs = [self._grid.id, self._reach, self.period, self._walls, self._points, x, lost]
        outputs = [self.listed, self.count, self.x_listed, self._overflow, self._crowded, self.stale]
        wp.launch(self._kernels.search_neighbours, len(x), inputs, outputs, device=self._device)

"""Neighbour lists of moving particles, kept as long as they hold.

They are found with `wp.HashGrid`, a margin beyond the effective radius, and renewed when a particle has moved by half
of that margin. The grid is built over coordinates in units of its cells, so that along a periodic axis a whole number
of cells fits the period: the grid's own wrapping then finds the neighbours across it.

A list has room for more neighbours than water has. Where a cluster of particles comes close to filling one, all lists
get twice the room, up to a limit; a cluster that comes at once, and does not fit, is left out of its lists until then.
"""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid.neighbour_room import MOST_ENTRIES, MOST_ROOM, room_for
from warp_mps.fluid.neighbour_search import neighbour_search_kernels, neighbour_table_struct
from warp_mps.scene.numerics import SKIN

MOST_CELLS = {2: 4096, 3: 512}


class NeighbourLists:
    """The lists of a set of particles, of which the first ones are walls.

    Attributes:
        listed: Neighbours of each particle, int32 [n, room].
        count: Number of neighbours of each particle, int32 [n].
        table: Both as kernels take them, a `NeighbourTable`.
        x_listed: Positions at which the lists were made [m], vec [n].
        stale: Whether they must be renewed, int32 [1].
        period: Period along each axis [m], 0 where there is none.

    Args:
        count: Number of particles.
        walls: Number of those that are walls, the first ones.
        low: Lowest corner of the domain [m].
        high: Its highest corner [m].
        periodic: Its periodic axes.
        radius: Effective radius [m].
        spacing: Particle spacing [m].
        neighbours: Neighbours of even water, for which there is room and to spare; see `warp_mps.fluid.neighbour_room`.
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
        self._kernels, self._device, self._walls = neighbour_search_kernels(types), device, walls
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
        width = room_for(neighbours)
        self._points = wp.zeros(count, dtype=types.vec3, device=device)
        self.x_listed = wp.zeros(count, dtype=types.vec, device=device)
        self.listed = wp.zeros((count, width), dtype=wp.int32, device=device)
        self._most_room = MOST_ROOM * width
        self.count = wp.zeros(count, dtype=wp.int32, device=device)
        self.table = self._make_table()
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
        """Whether the lists may have more room, and the rows of the pressure matrix with them."""
        count, width = self.listed.shape
        return 2 * width <= self._most_room and 2 * width * (count - self._walls) <= MOST_ENTRIES

    def crowded(self) -> bool:
        """Whether a list has come close to its room, or beyond it, since they were given more."""
        return bool(self._crowded.numpy()[0])

    def grow(self) -> None:
        """Give the lists twice the room, in new arrays; they are empty until they are renewed."""
        count, width = self.listed.shape
        self.listed = wp.zeros((count, 2 * width), dtype=wp.int32, device=self._device)
        self.table = self._make_table()
        self.count.zero_()
        self._overflow.zero_()
        self._crowded.zero_()

    def _make_table(self) -> Any:
        table = neighbour_table_struct()()
        table.index, table.count = self.listed, self.count
        return table

    def _search(self, x: wp.array, lost: wp.array) -> None:
        self._grid.build(self._points, 1.0)
        inputs = [self._grid.id, self._reach, self.period, self._walls, self._points, x, lost]
        outputs = [self.listed, self.count, self.x_listed, self._overflow, self._crowded, self.stale]
        wp.launch(self._kernels.search_neighbours, len(x), inputs, outputs, device=self._device)

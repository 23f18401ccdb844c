"""Numbering of the cells of the multigrid preconditioner, as Warp functions.

A level is a grid of cells. Its matrix has an entry for each of the 3^d cells around a cell, `coupling`, in the order of
their offsets (that of the cell itself is 0); and an `excess` of the diagonal over the sum of the couplings. In cells
without an unknown the diagonal is 0. `wraps` is 1 along periodic axes, else 0.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes

METHOD = "multigrid"

# Damping of the Jacobi sweeps on the cells, measured: 0.67 takes an iteration more.
DAMPING = 0.85


def cell_type(types: NumericTypes) -> type:
    """Whole numbers of cells along each axis."""
    return wp.types.vector(length=types.dimension, dtype=wp.int32)


def corner_type(types: NumericTypes) -> type:
    """One value for each corner of a square or cube."""
    return wp.types.vector(length=2**types.dimension, dtype=wp.float64)


@functools.cache
def grid_functions(types: NumericTypes) -> SimpleNamespace:
    """Functions of one dimension: `flat`, `unflat`, `corner`, `inside`, `wrapped`, `nearest`, `slot` and `close`."""
    d, around = types.dimension, 3**types.dimension
    ivec, numbers = cell_type(types), wp.array(dtype=wp.float64)

    @types.func(METHOD)
    def flat(cell: ivec, dims: ivec):
        """Number of a cell: the first axis runs fastest, as in `wp.HashGrid`, by which particles are sorted."""
        number = cell[d - 1]
        for m in range(1, d):
            axis = d - 1 - m
            number = number * dims[axis] + cell[axis]
        return number

    @types.func(METHOD)
    def unflat(number: wp.int32, dims: ivec):
        """Cell of a number."""
        cell = ivec()
        rest = number
        for m in range(d):
            cell[m] = rest % dims[m]
            rest = rest // dims[m]
        return cell

    @types.func(METHOD)
    def corner(k: wp.int32):
        """Corner k of a square or cube: 0 or 1 along each axis."""
        offset = ivec()
        for m in range(d):
            offset[m] = (k >> m) & 1
        return offset

    @types.func(METHOD)
    def inside(cell: ivec, dims: ivec):
        """Whether a grid has such a cell."""
        found = True
        for m in range(d):
            if cell[m] < 0 or cell[m] >= dims[m]:
                found = False
        return found

    @types.func(METHOD)
    def wrapped(cell: ivec, dims: ivec, wraps: ivec):
        """The periodic image of a cell within the grid; the cell is at most one beyond it."""
        same = cell
        for m in range(d):
            if wraps[m] == 1:
                same[m] = (cell[m] + dims[m]) % dims[m]
        return same

    @types.func(METHOD)
    def nearest(offset: ivec, dims: ivec, wraps: ivec):
        """The shortest offset to a periodic image of the same cell (minimum image)."""
        shortest = offset
        for m in range(d):
            if wraps[m] == 1 and 2 * wp.abs(offset[m]) > dims[m]:
                shortest[m] = offset[m] - wp.sign(offset[m]) * dims[m]
        return shortest

    @types.func(METHOD)
    def slot(offset: ivec):
        """Place of a neighbouring cell, or of the cell itself, in a row; -1 if it is farther away."""
        place = wp.int32(0)
        farthest = wp.int32(0)
        for m in range(d):
            place = place * 3 + offset[d - 1 - m] + 1
            farthest = wp.max(farthest, wp.abs(offset[m]))
        if farthest > 1:
            place = -1
        return place

    @types.func(METHOD)
    def finish_row(c: wp.int32, excess: wp.float64, coupling_out: numbers, excess_out: numbers, diagonal_out: numbers):
        """Excess and diagonal (excess plus sum of the couplings) of a row; both are 0 in a cell without unknowns."""
        total = excess
        for s in range(around):
            total += coupling_out[c * around + s]
        excess_out[c] = excess
        diagonal_out[c] = total

    made = (flat, unflat, corner, inside, wrapped, nearest, slot, finish_row)
    return SimpleNamespace(**{function.func.__name__: function for function in made})

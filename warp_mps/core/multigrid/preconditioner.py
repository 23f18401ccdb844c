"""A multigrid preconditioner for pressure Poisson equations: the iterations hardly grow with the number of unknowns.

The unknowns are aggregated into square cells as wide as the effective radius, and these into cells twice as wide, down
to one or two. Within the radius a sum over neighbours couples everything with everything, so that the diagonal is a
good smoother there; the cells correct the smooth remainder of the error:

    M^-1 = D^-1 + P V P^T

P interpolates linearly between the centres of cells, and V is a V-cycle on the cells, with a damped Jacobi sweep before
and after the coarse-grid correction. It costs a small part of a product with the matrix. A row of P is scaled by the
share of its couplings in its diagonal, which is the effect of a Jacobi sweep on a constant (smoothed aggregation,
Vanek et al.): at a free surface, rows are coupled to the value 0 more than to each other.

The matrix of the cells is the sum of the entries between their unknowns, as for a P that is constant in a cell. Its
couplings are scaled down, because a constant P makes them too stiff (overcorrection, Braess). The constant P keeps a
nearest-neighbour matrix on each level, and the linear P in the transfer keeps the number of iterations low, as in
cell-centred multigrid (Wesseling). M is symmetric and positive for any matrix. Periodic axes are periodic on every
level.

References:
    Vanek, P., Mandel, J. and Brezina, M., Computing 56 (1996) 179.
    Braess, D., Computing 55 (1995) 379.
    Wesseling, P., SIAM J. Sci. Stat. Comput. 9 (1988) 451.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import Matrix
from warp_mps.core.multigrid.cell_kernels import cell_kernels
from warp_mps.core.multigrid.cell_numbering import METHOD, cell_type, corner_type
from warp_mps.core.multigrid.particle_kernels import BINS_PER_THREAD, particle_kernels
from warp_mps.core.multigrid.transfer_tables import (
    TransferTable,
    cell_neighbours,
    coarse_dims,
    interpolation,
    transpose,
)
from warp_mps.core.types import NumericTypes

# Stiffness of a linear field over that of its piecewise constant image in cells as wide as the effective radius:
# sum w x^2 / (r_e sum w |x|), with w = r_e/r - 1. It is 0.39 in the limit of many neighbours, 0.43 to 0.48 for 2.1 and
# 3.1 spacings in 2-D and 3-D.
SCALE = 0.45
COARSEST_SWEEPS = 8


class Level:
    """A level of the hierarchy: a grid of cells, its matrix, its vectors, and the transfer to the next level.

    Args:
        dims: Cells along each axis.
        wraps: Whether each axis is periodic.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, dims: np.ndarray, wraps: np.ndarray, *, types: NumericTypes, device: Any) -> None:
        self.size, ivec = int(np.prod(dims)), cell_type(types)
        self.dims = ivec(*[int(length) for length in dims])
        around = cell_neighbours(dims, wraps)
        self.there = wp.array(around.ravel(), dtype=wp.int32, device=device)
        self.coupling = wp.zeros(around.size, dtype=wp.float64, device=device)
        coarse = [int(length) for length in coarse_dims(dims)]
        above = [interpolation(int(n), half, wrap) for n, half, wrap in zip(dims, coarse, wraps, strict=True)]
        below = [transpose(*table, half, wrap) for table, half, wrap in zip(above, coarse, wraps, strict=True)]
        self.above, self.below = (TransferTable(tables, ivec=ivec, device=device) for tables in (above, below))
        vectors = [wp.zeros(self.size, dtype=wp.float64, device=device) for _ in range(5)]
        self.excess, self.diagonal, self.r, self.e, self.spare = vectors

    @property
    def matrix(self) -> list[wp.array]:
        """Outputs of `coarsen`: couplings, excess and diagonal."""
        return [self.coupling, self.excess, self.diagonal]

    @property
    def rows(self) -> list[wp.array]:
        """Inputs of a product with the matrix."""
        return [self.there, self.coupling, self.diagonal]


class MultigridPreconditioner:
    """Preconditioner of `warp_mps.core.linear.conjugate_gradient.ConjugateGradient` for unknowns that are particles.

    Args:
        positions: Positions of the rows [m], read in every `prepare`, shape [capacity].
        low: Lower corner of the domain [m], shape [d]. Particles may leave it; far outside they cost iterations.
        high: Upper corner of the domain [m], shape [d].
        reach: Effective radius of the matrix's sums [m].
        types: Number types of the matrix and the positions.
        device: Warp device.
        periodic: Axes along which the domain is periodic.

    Attributes:
        positions: Positions of the rows [m].
        levels: Grids of cells, the finest one first.
    """

    def __init__(
        self,
        positions: wp.array,
        *,
        low: np.ndarray,
        high: np.ndarray,
        reach: float,
        types: NumericTypes,
        device: Any,
        periodic: tuple[int, ...] = (),
    ) -> None:
        self._device, self.positions = device, positions
        self._cells, self._particles = cell_kernels(types), particle_kernels(types)
        self._n = len(positions)
        extent = np.asarray(high, dtype=float) - np.asarray(low, dtype=float)
        width = reach
        # a nearly empty domain gets wider cells instead of more memory
        while np.prod(np.ceil(extent / width)) > max(self._n, 64):
            width *= 1.25
        wraps = np.isin(np.arange(types.dimension), periodic)
        # a period is a whole number of cells, which are then somewhat wider
        dims = np.maximum(np.where(wraps, np.floor(extent / width + 1e-6), np.ceil(extent / width)), 1).astype(int)
        widths = np.where(wraps, extent / dims, width)
        self._scale = float(SCALE * reach / widths.min())
        self.levels = [Level(dims, wraps, types=types, device=device)]
        while dims.max() > 2:
            dims = coarse_dims(dims)
            self.levels.append(Level(dims, wraps, types=types, device=device))
        top = self.levels[0]
        self._wraps = cell_type(types)(*[int(wrap) for wrap in wraps])
        self._grid = [top.dims, self._wraps]
        self._bins = top.size * 2**types.dimension
        self._box = [types.vec(*[float(x) for x in low]), types.vec(*[float(x) for x in widths]), *self._grid]
        self._allocate(types)

    def _allocate(self, types: NumericTypes) -> None:
        n, device, dims = self._n, self._device, self.levels[0].dims
        # boxes between the centres of cells
        self._sums = int(np.prod([dims[axis] + 1 - self._wraps[axis] for axis in range(types.dimension)]))
        shares = corner_type(types)
        # sorting takes room for two copies
        self._bin = wp.zeros(2 * n, dtype=wp.int32, device=device)
        self._order = wp.zeros(2 * n, dtype=wp.int32, device=device)
        self._start = wp.zeros(self._bins + 1, dtype=wp.int32, device=device)
        self._between = wp.zeros(n, dtype=wp.int32, device=device)
        self._cell = wp.zeros(n, dtype=type(dims), device=device)
        self._weight = wp.zeros(n, dtype=shares, device=device)
        self._share = wp.zeros(n, dtype=wp.float64, device=device)
        self._corner_sums = wp.zeros(self._sums, dtype=shares, device=device)

    def prepare(self, matrix: Matrix, inverse: wp.array) -> None:
        """Launch the sorting of the unknowns into cells, and the matrices of all levels."""
        particles, levels, top = self._particles, self.levels, self.levels[0]
        self._inverse = inverse
        outputs = [self._bin, self._order, self._between, self._cell, self._weight]
        self._launch(particles.locate_particles, self._n, [*self._box, self._bins, inverse, self.positions], outputs)
        wp.utils.radix_sort_pairs(self._bin, self._order, self._n, end_bit=self._bins.bit_length())
        self._launch(
            particles.find_starts, self._bins // BINS_PER_THREAD + 1, [self._n, self._bins, self._bin], [self._start]
        )
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal]
        inputs = [*self._grid, self._scale, *rows, self._start, self._order, self._cell]
        self._launch(particles.assemble_cell_matrix, top.size, inputs, [self._share, *top.matrix])
        self._launch(particles.corner_values, self._sums, [*self._grid, top.diagonal], [self._corner_sums])
        self._launch(
            particles.normalize_weights,
            self._n,
            [inverse, self._between, self._share, self._corner_sums],
            [self._weight],
        )
        for fine, coarse in itertools.pairwise(levels):
            inputs = [fine.dims, coarse.dims, self._wraps, fine.coupling, fine.excess]
            self._launch(self._cells.coarsen, coarse.size, inputs, coarse.matrix)

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Launch z = z + P V P^T r."""
        self.restrict(r)
        self.prolongate(self._cycle(0), z)

    def restrict(self, r: wp.array) -> None:
        """Launch the sums P^T r of the unknowns over the cells of the finest level, and its first sweep."""
        particles, top, sums = self._particles, self.levels[0], self._corner_sums
        inputs = [*self._grid, self._start, self._order, self._weight, r]
        self._launch(particles.restrict_particles, self._sums, inputs, [sums])
        self._launch(particles.restrict_corners, top.size, [*self._grid, top.diagonal, sums], [top.r, top.e])

    def prolongate(self, e: wp.array, z: wp.array) -> None:
        """Launch z = z + P e, the linear interpolation of values of the finest level's cells to the unknowns."""
        particles, sums = self._particles, self._corner_sums
        self._launch(particles.corner_values, self._sums, [*self._grid, e], [sums])
        inputs = [self._inverse, self._between, self._weight, sums]
        self._launch(particles.prolong_to_particles, self._n, inputs, [z])

    def _cycle(self, k: int) -> wp.array:
        """Launch the V-cycle from level k on, whose first sweep has been made, and return its solution."""
        level = self.levels[k]
        if k == len(self.levels) - 1:
            e, spare = level.e, level.spare
            for _ in range(COARSEST_SWEEPS):
                self._launch(self._cells.jacobi_sweep, level.size, [*level.rows, level.r, e], [spare])
                e, spare = spare, e
            return e
        coarse = self.levels[k + 1]
        self._launch(self._cells.residual, level.size, [*level.rows, level.r, level.e], [level.spare])
        inputs = [level.dims, coarse.dims, *level.below.inputs, coarse.diagonal, level.spare]
        self._launch(self._cells.restrict_cells, coarse.size, inputs, [coarse.r, coarse.e])
        inputs = [level.dims, coarse.dims, *level.above.inputs, level.diagonal, self._cycle(k + 1)]
        self._launch(self._cells.prolong_to_cells, level.size, inputs, [level.e])
        self._launch(self._cells.jacobi_sweep, level.size, [*level.rows, level.r, level.e], [level.spare])
        return level.spare

    def _launch(self, kernel: Any, n: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, n, inputs, outputs, device=self._device)


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare the preconditioner's kernels, and return the names of their modules."""
    particle_kernels(types)
    cell_kernels(types)
    return [types.module(METHOD)]

"""Kernels of the multigrid preconditioner on cells: coarse matrices, smoother, restriction and prolongation."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.multigrid.cell_numbering import DAMPING, METHOD, cell_type, grid_functions
from warp_mps.core.multigrid.transfer_tables import ABOVE, BELOW
from warp_mps.core.types import NumericTypes


@functools.cache
def cell_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels of one dimension; vectors are always in double precision."""
    real64, d, ivec = wp.float64, types.dimension, cell_type(types)
    around, corners, below, above = 3**d, 2**d, BELOW**d, ABOVE**d
    counts, numbers = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64)
    grid = grid_functions(types)
    flat, unflat, corner, slot, finish_row = grid.flat, grid.unflat, grid.corner, grid.slot, grid.finish_row
    inside, wrapped, nearest = grid.inside, grid.wrapped, grid.nearest

    @types.func(METHOD)
    def coupling_sum(c: wp.int32, there: counts, coupling: numbers, e: numbers):
        """Sum over the cells around a cell of coupling e; a coupling across the edge of the grid is 0."""
        total = real64(0.0)
        for s in range(c * around, (c + 1) * around):
            total += coupling[s] * e[there[s]]
        return total

    @types.kernel(METHOD)
    def coarsen(
        # Model:
        dims: ivec,  # cells along each axis
        coarse_dims: ivec,  # coarse cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        # State in:
        coupling: numbers,  # couplings of each cell to those around it, [cells 3^d]
        excess: numbers,  # excess of the diagonal over the couplings, [cells]
        # State out:
        coupling_out: numbers,  # couplings of each cell to those around it, [cells 3^d]
        excess_out: numbers,  # excess of the diagonal over the couplings, [cells]
        diagonal_out: numbers,  # diagonal, [cells]
    ):
        """Coarse-grid matrix between cells twice as wide; couplings count half, since the distance has doubled."""
        c = wp.tid()
        here = unflat(c, coarse_dims)
        for s in range(around):
            coupling_out[c * around + s] = real64(0.0)
        total = real64(0.0)
        for k in range(corners):
            child = 2 * here + corner(k)
            if inside(child, dims):
                f = flat(child, dims)
                total += excess[f]
                for s in range(around):
                    if coupling[f * around + s] > real64(0.0):
                        rest = s
                        offset = ivec()
                        for m in range(d):
                            offset[m] = rest % 3 - 1
                            rest = rest // 3
                        there = wrapped(child + offset, dims, wraps)
                        for m in range(d):
                            offset[m] = there[m] // 2 - here[m]
                        to = slot(nearest(offset, coarse_dims, wraps))
                        if to != around // 2:
                            coupling_out[c * around + to] += real64(0.5) * coupling[f * around + s]
        finish_row(c, total, coupling_out, excess_out, diagonal_out)

    @types.kernel(METHOD)
    def residual(
        # Model:
        there: counts,  # cells around each cell, [cells 3^d]
        # State in:
        coupling: numbers,  # couplings of each cell to those around it, [cells 3^d]
        diagonal: numbers,  # diagonal, 0 without unknowns, [cells]
        r: numbers,  # residual, [cells]
        e: numbers,  # correction, [cells]
        # State out:
        residual_out: numbers,  # residual of the correction, [cells]
    ):
        """Residual r - A e of the correction e; 0 in cells without unknowns."""
        c = wp.tid()
        residual_c = real64(0.0)
        if diagonal[c] > real64(0.0):
            residual_c = r[c] - diagonal[c] * e[c] + coupling_sum(c, there, coupling, e)
        residual_out[c] = residual_c

    @types.kernel(METHOD)
    def restrict_cells(
        # Model:
        dims: ivec,  # cells along each axis
        coarse_dims: ivec,  # coarse cells along each axis
        first: ivec,  # first row of the tables along each axis
        cell: counts,  # cells of the other level, by row of the tables
        share: numbers,  # their weights, by row of the tables [-]
        # State in:
        diagonal: numbers,  # diagonal, 0 without unknowns, [cells]
        fine_r: numbers,  # residual on the fine cells
        # State out:
        r_out: numbers,  # residual, [cells]
        e_out: numbers,  # correction, [cells]
    ):
        """Restriction r_coarse = P^T r, and the first smoothing sweep from e = 0: e = omega r / diagonal."""
        c = wp.tid()
        total = real64(0.0)
        e = real64(0.0)
        if diagonal[c] > real64(0.0):
            here = unflat(c, coarse_dims)
            for k in range(below):
                rest = wp.int32(k)
                fine = ivec()
                weight = real64(1.0)
                for m in range(d):
                    at = (first[m] + here[m]) * BELOW + rest % BELOW
                    fine[m] = cell[at]
                    weight *= share[at]
                    rest = rest // BELOW
                if weight > real64(0.0):
                    total += weight * fine_r[flat(fine, dims)]
            e = real64(DAMPING) * total / diagonal[c]
        r_out[c] = total
        e_out[c] = e

    @types.kernel(METHOD)
    def prolong_to_cells(
        # Model:
        dims: ivec,  # cells along each axis
        coarse_dims: ivec,  # coarse cells along each axis
        first: ivec,  # first row of the tables along each axis
        cell: counts,  # cells of the other level, by row of the tables
        share: numbers,  # their weights, by row of the tables [-]
        # State in:
        diagonal: numbers,  # diagonal, 0 without unknowns, [cells]
        coarse_e: numbers,  # correction on the coarse cells
        # State in and out:
        e: numbers,  # correction, [cells]
    ):
        """Coarse-grid correction e += P e_coarse, with linear interpolation P."""
        c = wp.tid()
        if diagonal[c] > real64(0.0):
            here = unflat(c, dims)
            total = real64(0.0)
            for k in range(above):
                rest = wp.int32(k)
                coarse = ivec()
                weight = real64(1.0)
                for m in range(d):
                    at = (first[m] + here[m]) * ABOVE + rest % ABOVE
                    coarse[m] = cell[at]
                    weight *= share[at]
                    rest = rest // ABOVE
                if weight > real64(0.0):
                    total += weight * coarse_e[flat(coarse, coarse_dims)]
            e[c] += total

    @types.kernel(METHOD)
    def jacobi_sweep(
        # Model:
        there: counts,  # cells around each cell, [cells 3^d]
        # State in:
        coupling: numbers,  # couplings of each cell to those around it, [cells 3^d]
        diagonal: numbers,  # diagonal, 0 without unknowns, [cells]
        r: numbers,  # residual, [cells]
        e: numbers,  # correction, [cells]
        # State out:
        e_out: numbers,  # correction, [cells]
    ):
        """Smoother: a damped Jacobi sweep e += omega (r - A e) / diagonal."""
        c = wp.tid()
        if diagonal[c] > real64(0.0):
            residual_c = r[c] - diagonal[c] * e[c] + coupling_sum(c, there, coupling, e)
            e_out[c] = e[c] + real64(DAMPING) * residual_c / diagonal[c]
        else:
            e_out[c] = real64(0.0)

    made = (coarsen, residual, restrict_cells, prolong_to_cells, jacobi_sweep)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})

"""Kernels of the multilevel preconditioner between cells: matrices, sweeps, and the way to the next level and back."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.core.multilevel_grid import DAMPING, METHOD, cell_type, grid_functions


@functools.cache
def cell_kernels(kit: Kit) -> SimpleNamespace:
    """Kernels of one dimension; vectors are always in double precision."""
    real64, d, ivec = wp.float64, kit.dimension, cell_type(kit)
    around, corners, reached = 3**d, 2**d, 4**d
    counts, numbers = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64)
    grid = grid_functions(kit)
    flat, unflat, corner, slot, close = grid.flat, grid.unflat, grid.corner, grid.slot, grid.close

    @kit.func(METHOD)
    def coupled(c: wp.int32, steps: counts, coupling: numbers, e: numbers):
        """Sum over the cells around a cell of coupling e; a coupling across the edge of the grid is 0."""
        total = real64(0.0)
        for s in range(around):
            total += coupling[c * around + s] * e[wp.clamp(c + steps[s], 0, e.shape[0] - 1)]
        return total

    @kit.func(METHOD)
    def share(fine: wp.int32, coarse: wp.int32, n: wp.int32):
        """Weight of a coarse cell in the linear interpolation to a fine one's centre, along one axis of n cells."""
        near = fine // 2
        far = near - 1 + 2 * (fine % 2)
        weight = real64(0.0)
        if coarse == near:
            weight = real64(0.75)
            if far < 0 or far >= n:
                weight = real64(1.0)
        elif coarse == far:
            weight = real64(0.25)
        return weight

    @kit.kernel(METHOD)
    def coarsen(
        # Model:
        dims: ivec,
        coarse_dims: ivec,
        # State in:
        coupling: numbers,
        excess: numbers,
        # Out:
        coupling_out: numbers,
        excess_out: numbers,
        diagonal_out: numbers,
    ):
        """The matrix between cells twice as wide: couplings count half, as the distance has doubled."""
        c = wp.tid()
        here = unflat(c, coarse_dims)
        for s in range(around):
            coupling_out[c * around + s] = real64(0.0)
        total = real64(0.0)
        for k in range(corners):
            child = 2 * here + corner(k)
            inside = wp.int32(1)
            for m in range(d):
                if child[m] >= dims[m]:
                    inside = 0
            if inside == 1:
                f = flat(child, dims)
                total += excess[f]
                for s in range(around):
                    if coupling[f * around + s] > real64(0.0):
                        rest = s
                        offset = ivec()
                        for m in range(d):
                            offset[m] = (child[m] + rest % 3 - 1) // 2 - here[m]
                            rest = rest // 3
                        to = slot(offset)
                        if to != around // 2:
                            coupling_out[c * around + to] += real64(0.5) * coupling[f * around + s]
        close(c, total, coupling_out, excess_out, diagonal_out)

    @kit.kernel(METHOD)
    def find_residual(
        # Model:
        steps: counts,
        # State in:
        coupling: numbers,
        diagonal: numbers,
        r: numbers,
        e: numbers,
        # Out:
        left_out: numbers,
    ):
        """What is left of the residual: r - A e; nothing in cells without an unknown."""
        c = wp.tid()
        left = real64(0.0)
        if diagonal[c] > real64(0.0):
            left = r[c] - diagonal[c] * e[c] + coupled(c, steps, coupling, e)
        left_out[c] = left

    @kit.kernel(METHOD)
    def collect_cells(
        # Model:
        dims: ivec,
        coarse_dims: ivec,
        # State in:
        diagonal: numbers,
        left: numbers,
        # Out:
        r_out: numbers,
        e_out: numbers,
    ):
        """Residual of each coarse cell, by the transpose of the interpolation, and the first sweep on it."""
        c = wp.tid()
        total = real64(0.0)
        e = real64(0.0)
        if diagonal[c] > real64(0.0):
            here = unflat(c, coarse_dims)
            for k in range(reached):
                rest = wp.int32(k)
                fine = ivec()
                weight = real64(1.0)
                for m in range(d):
                    fine[m] = 2 * here[m] - 1 + rest % 4
                    rest = rest // 4
                    if fine[m] >= 0 and fine[m] < dims[m]:
                        weight *= share(fine[m], here[m], coarse_dims[m])
                    else:
                        weight = real64(0.0)
                if weight > real64(0.0):
                    total += weight * left[flat(fine, dims)]
            e = real64(DAMPING) * total / diagonal[c]
        r_out[c] = total
        e_out[c] = e

    @kit.kernel(METHOD)
    def interpolate_cells(
        # Model:
        dims: ivec,
        coarse_dims: ivec,
        # State in:
        diagonal: numbers,
        coarse_e: numbers,
        # Out:
        e_out: numbers,
    ):
        """Add the correction of the coarse cells."""
        c = wp.tid()
        if diagonal[c] > real64(0.0):
            here = unflat(c, dims)
            total = real64(0.0)
            for k in range(corners):
                at = corner(k)
                coarse = ivec()
                weight = real64(1.0)
                for m in range(d):
                    near = here[m] // 2
                    coarse[m] = near + at[m] * (2 * (here[m] % 2) - 1)
                    if coarse[m] >= 0 and coarse[m] < coarse_dims[m]:
                        weight *= share(here[m], coarse[m], coarse_dims[m])
                    else:
                        weight = real64(0.0)
                if weight > real64(0.0):
                    total += weight * coarse_e[flat(coarse, coarse_dims)]
            e_out[c] += total

    @kit.kernel(METHOD)
    def sweep(
        # Model:
        steps: counts,
        # State in:
        coupling: numbers,
        diagonal: numbers,
        r: numbers,
        e: numbers,
        # Out:
        e_out: numbers,
    ):
        """A damped Jacobi sweep."""
        c = wp.tid()
        if diagonal[c] > real64(0.0):
            left = r[c] - diagonal[c] * e[c] + coupled(c, steps, coupling, e)
            e_out[c] = e[c] + real64(DAMPING) * left / diagonal[c]
        else:
            e_out[c] = real64(0.0)

    made = (coarsen, find_residual, collect_cells, interpolate_cells, sweep)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})

"""Kernels of the multigrid preconditioner between particles and the cells of its finest level (aggregation)."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.multigrid.cell_numbering import DAMPING, METHOD, cell_type, corner_type, grid_functions
from warp_mps.core.types import NumericTypes

# Excess of the diagonal, relative to it, that counts as 0: the rounding of a matrix of each precision.
ROUNDING = {"float64": 1.0e-10, "float32": 2.0e-6}

# Bins of one thread: it searches for the start of the first by bisection, and of the others from there.
BINS_PER_THREAD = 8

# Cell of a row that is not an unknown: far from all others.
NO_CELL = -1_000_000


@functools.cache
def particle_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels of one dimension and precision of the matrix; vectors are always in double precision."""
    real, vec, real64, d = types.real, types.vec, wp.float64, types.dimension
    around, corners = 3**d, 2**d
    ivec, shares = cell_type(types), corner_type(types)
    row = wp.types.vector(length=around, dtype=wp.float64)
    counts, numbers = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64)
    grid = grid_functions(types)
    flat, unflat, corner, slot, finish_row = grid.flat, grid.unflat, grid.corner, grid.slot, grid.finish_row
    inside, wrapped, nearest = grid.inside, grid.wrapped, grid.nearest

    @types.kernel(METHOD)
    def locate_particles(
        # Model:
        low: vec,  # lowest corner of the grid [m]
        width: vec,  # widths of a cell [m]
        dims: ivec,  # cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        bins: wp.int32,  # number of bins
        # State in:
        inverse: numbers,  # D^-1 of the matrix, 0 in rows that are not unknowns, [n]
        positions: wp.array(dtype=vec),  # positions [m], [n]
        # State out:
        bin_out: counts,  # bin of each row, [n]
        order_out: counts,  # numbers of the rows, to be sorted by bin, [n]
        between_out: counts,  # box between cell centres of each row, [n]
        cell_out: wp.array(dtype=ivec),  # cell of each row, [n]
        weight_out: wp.array(dtype=shares),  # weights in the 2^d cells around it [-], [n]
    ):
        """The bin (half a cell wide) and the cell of each unknown, and its weights in the cells around it.

        These are the 2^d cells whose centres surround it. The boxes between cell centres are numbered like cells.
        """
        i = wp.tid()
        order_out[i] = i
        if inverse[i] == real64(0.0):
            bin_out[i] = bins
            between_out[i] = 0
            cell_out[i] = ivec(NO_CELL)
            weight_out[i] = shares()
            return
        half = ivec()
        cell = ivec()
        above = ivec()
        upper = vec()
        for m in range(d):
            y = (positions[i][m] - low[m]) / width[m]
            if wraps[m] == 1:
                y -= real(dims[m]) * wp.floor(y / real(dims[m]))
            # beyond the grid: in the cell at its edge
            y = wp.clamp(y, real(0.0), real(dims[m]))
            half[m] = wp.clamp(wp.int32(real(2.0) * y), 0, 2 * dims[m] - 1)
            cell[m] = half[m] // 2
            above[m] = (half[m] + 1) // 2
            upper[m] = wp.clamp(y + real(0.5) - real(above[m]), real(0.0), real(1.0))
            if wraps[m] == 1:
                above[m] = above[m] % dims[m]
            elif above[m] == 0:
                upper[m] = real(1.0)
            elif above[m] == dims[m]:
                upper[m] = real(0.0)
        weight = shares()
        for k in range(corners):
            at = corner(k)
            product = real64(1.0)
            for m in range(d):
                if at[m] == 1:
                    product *= real64(upper[m])
                else:
                    product *= real64(1.0) - real64(upper[m])
            weight[k] = product
        bin_out[i] = flat(half, 2 * dims)
        between_out[i] = flat(above, dims + ivec(1) - wraps)
        cell_out[i] = cell
        weight_out[i] = weight

    @types.kernel(METHOD)
    def find_starts(
        # Model:
        n: wp.int32,  # number of rows
        bins: wp.int32,  # number of bins
        # State in:
        bin: counts,  # bins, sorted, [n]
        # State out:
        start_out: counts,  # first row of each bin, [bins + 1]
    ):
        """First of the sorted unknowns in each of a few bins, or in a later one where it is empty."""
        first = BINS_PER_THREAD * wp.tid()
        low = wp.int32(0)
        high = n
        # not `wp.lower_bound`, which gives n - 1 where all are smaller
        while low < high:
            middle = (low + high) // 2
            if bin[middle] < first:
                low = middle + 1
            else:
                high = middle
        for b in range(first, wp.min(first + BINS_PER_THREAD, bins + 1)):
            while low < n and bin[low] < b:
                low += 1
            start_out[b] = low

    @types.kernel(METHOD)
    def assemble_cell_matrix(
        # Model:
        dims: ivec,  # cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        scale: wp.float64,  # factor of the couplings [-]
        first: counts,  # first entry of each row, [n]
        count: counts,  # number of entries of each row, [n]
        index: counts,  # column of each entry, [entries]
        value: wp.array(dtype=real),  # off-diagonal entries with their sign turned, [entries]
        diagonal: wp.array(dtype=real),  # diagonal of the matrix, [n]
        # State in:
        start: counts,  # first row of each bin, [bins + 1]
        order: counts,  # rows, sorted by bin, [n]
        cell: wp.array(dtype=ivec),  # cell of each row, [n]
        # State out:
        share_out: numbers,  # share of each row [-], [n]
        coupling_out: numbers,  # couplings of each cell to those around it, [cells 3^d]
        excess_out: numbers,  # excess of the diagonal over the couplings, [cells]
        diagonal_out: numbers,  # diagonal, [cells]
    ):
        """Finest cell matrix: scaled sums of the entries between the unknowns of two cells; share of each row.

        The share of a row is the sum of its couplings to other unknowns over its diagonal. Its excess counts with this
        share, which is what remains of it after eliminating the unknown.
        """
        c = wp.tid()
        here = unflat(c, dims)
        sums = row()
        total = real64(0.0)
        excess = real64(0.0)
        for k in range(corners):
            bin = flat(2 * here + corner(k), 2 * dims)
            for place in range(start[bin], start[bin + 1]):
                i = order[place]
                row_total = real64(diagonal[i])
                coupled = real64(0.0)
                for entry in range(first[i], first[i] + count[i]):
                    there = cell[index[entry]]
                    if there[0] >= 0:
                        v = real64(value[entry])
                        coupled += v
                        to = slot(there - here)
                        if to < 0:
                            to = slot(nearest(there - here, dims, wraps))
                        if to >= 0:
                            sums[to] += v
                share = wp.clamp(coupled / row_total, real64(0.0), real64(1.0))
                share_out[i] = share
                total += row_total
                excess += share * (row_total - coupled)
        for s in range(around):
            # a preconditioner has to be positive, whatever the matrix
            coupling_out[c * around + s] = wp.max(scale * sums[s], real64(0.0))
        coupling_out[c * around + around // 2] = real64(0.0)
        if excess < real64(wp.static(ROUNDING[types.precision])) * total:
            # the cells of a singular matrix must be singular, too: their constant part is divided by the excess
            excess = real64(0.0)
        excess *= wp.min(real64(1.0), real64(2.0) * scale)
        finish_row(c, excess, coupling_out, excess_out, diagonal_out)

    @types.kernel(METHOD)
    def normalize_weights(
        # State in:
        inverse: numbers,  # D^-1 of the matrix, 0 in rows that are not unknowns, [n]
        between: counts,  # box between cell centres of each row, [n]
        share: numbers,  # share of each row [-], [n]
        corner_diagonal: wp.array(dtype=shares),  # diagonals of the cells around each box, [boxes]
        # State in and out:
        weight: wp.array(dtype=shares),  # weights in the 2^d cells around each row [-], [n]
    ):
        """Normalize the weights over cells with unknowns, so that constants are interpolated exactly; scale by shares.

        Without the normalization, a domain that the cells do not divide evenly takes half as many iterations again.
        The share smooths P: a row of the free surface hardly follows the rows below it.
        """
        i = wp.tid()
        if inverse[i] == real64(0.0):
            return
        w = weight[i]
        there = corner_diagonal[between[i]]
        total = real64(0.0)
        for k in range(corners):
            if there[k] <= real64(0.0):
                w[k] = real64(0.0)
            total += w[k]
        if total > real64(0.0):
            w /= total
        weight[i] = share[i] * w

    @types.kernel(METHOD)
    def restrict_particles(
        # Model:
        dims: ivec,  # cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        # State in:
        start: counts,  # first row of each bin, [bins + 1]
        order: counts,  # rows, sorted by bin, [n]
        weight: wp.array(dtype=shares),  # weights in the 2^d cells around each row [-], [n]
        r: numbers,  # residual, [n]
        # State out:
        corner_out: wp.array(dtype=shares),  # weighted sums for the 2^d cells around each box, [boxes]
    ):
        """Restriction, first part: sums of weighted residuals of the unknowns between the same 2^d cell centres."""
        t = wp.tid()
        above = unflat(t, dims + ivec(1) - wraps)
        total = shares()
        for k in range(corners):
            half = wrapped(2 * above - ivec(1) + corner(k), 2 * dims, wraps)
            if inside(half, 2 * dims):
                bin = flat(half, 2 * dims)
                for place in range(start[bin], start[bin + 1]):
                    i = order[place]
                    total += r[i] * weight[i]
        corner_out[t] = total

    @types.kernel(METHOD)
    def restrict_corners(
        # Model:
        dims: ivec,  # cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        # State in:
        diagonal: numbers,  # diagonal, 0 without unknowns, [cells]
        corner_sums: wp.array(dtype=shares),  # weighted sums for the 2^d cells around each box, [boxes]
        # State out:
        r_out: numbers,  # residual, [cells]
        e_out: numbers,  # correction, [cells]
    ):
        """Restriction, second part: residual r = P^T r of each cell, and the first sweep e = omega r / diagonal."""
        c = wp.tid()
        here = unflat(c, dims)
        total = real64(0.0)
        boxes = dims + ivec(1) - wraps
        for k in range(corners):
            total += corner_sums[flat(wrapped(here + ivec(1) - corner(k), boxes, wraps), boxes)][k]
        r_out[c] = total
        e = real64(0.0)
        if diagonal[c] > real64(0.0):
            e = real64(DAMPING) * total / diagonal[c]
        e_out[c] = e

    @types.kernel(METHOD)
    def corner_values(
        # Model:
        dims: ivec,  # cells along each axis
        wraps: ivec,  # 1 along periodic axes, else 0
        # State in:
        e: numbers,  # correction, [cells]
        # State out:
        corner_out: wp.array(dtype=shares),  # values of the 2^d cells around each box, [boxes]
    ):
        """Values of the 2^d cells around each box between centres; a cell beyond the edge has weight 0."""
        t = wp.tid()
        above = unflat(t, dims + ivec(1) - wraps)
        values = shares()
        for k in range(corners):
            cell = wrapped(above - ivec(1) + corner(k), dims, wraps)
            for m in range(d):
                cell[m] = wp.clamp(cell[m], 0, dims[m] - 1)
            values[k] = e[flat(cell, dims)]
        corner_out[t] = values

    @types.kernel(METHOD)
    def prolong_to_particles(
        # State in:
        inverse: numbers,  # D^-1 of the matrix, 0 in rows that are not unknowns, [n]
        between: counts,  # box between cell centres of each row, [n]
        weight: wp.array(dtype=shares),  # weights in the 2^d cells around each row [-], [n]
        corner_e: wp.array(dtype=shares),  # corrections of the cells around each box, [boxes]
        # State in and out:
        z: numbers,  # preconditioned residual, [n]
    ):
        """Coarse-grid correction z += P e of the unknowns."""
        i = wp.tid()
        if inverse[i] != real64(0.0):
            z[i] += wp.dot(weight[i], corner_e[between[i]])

    made = (
        locate_particles,
        find_starts,
        assemble_cell_matrix,
        normalize_weights,
        restrict_particles,
        restrict_corners,
        corner_values,
        prolong_to_particles,
    )
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})

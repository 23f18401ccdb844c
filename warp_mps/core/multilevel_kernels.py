"""Kernels of the multilevel preconditioner; see `warp_mps.core.multilevel` for what they do together.

A level is a grid of cells. Its matrix has an entry for each of the 3^d cells around a cell, `coupling`, in the order
of their offsets (that of the cell itself is 0); and an `excess` of the diagonal over the sum of the couplings.
Cells without an unknown have the inverse diagonal 0.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit

METHOD = "multilevel"

# Damping of the Jacobi sweeps on the cells, measured: 0.67 takes an iteration more.
DAMPING = 0.85

# Excess of the diagonal, relative to it, that is taken for none.
ROUNDING = 1.0e-10

# Cell of a row that is no unknown: far from all others.
NOWHERE = -1_000_000


@functools.cache
def multilevel_kernels(kit: Kit) -> SimpleNamespace:
    """Kernels of one dimension and precision of the matrix; vectors are always in double precision."""
    real, vec, real64 = kit.real, kit.vec, wp.float64
    d = kit.dimension
    around, corners, reached = 3**d, 2**d, 4**d
    ivec = wp.types.vector(length=d, dtype=wp.int32)
    shares = wp.types.vector(length=corners, dtype=wp.float64)
    row = wp.types.vector(length=around, dtype=wp.float64)
    counts, numbers = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64)

    @kit.func(METHOD)
    def flat(cell: ivec, dims: ivec):
        """Number of a cell: the first axis runs fastest, as in `wp.HashGrid`, by which particles are sorted."""
        number = cell[d - 1]
        for m in range(1, d):
            axis = d - 1 - m
            number = number * dims[axis] + cell[axis]
        return number

    @kit.func(METHOD)
    def unflat(number: wp.int32, dims: ivec):
        """Cell of a number."""
        cell = ivec()
        rest = number
        for m in range(d):
            cell[m] = rest % dims[m]
            rest = rest // dims[m]
        return cell

    @kit.func(METHOD)
    def corner(k: wp.int32):
        """Corner k of a square or cube: 0 or 1 along each axis."""
        offset = ivec()
        for m in range(d):
            offset[m] = (k >> m) & 1
        return offset

    @kit.func(METHOD)
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
    def locate(
        # Model:
        low: vec,
        width: real,
        dims: ivec,
        bins: wp.int32,
        # State in:
        inverse: numbers,
        positions: wp.array(dtype=vec),
        # Out:
        bin_out: counts,
        order_out: counts,
        between_out: counts,
        cell_out: wp.array(dtype=ivec),
        weight_out: wp.array(dtype=shares),
    ):
        """The bin (half a cell wide) and the cell of each unknown, and its weights in the cells around it.

        These are the 2^d whose centres it lies between. Such boxes between centres have a number of their own.
        """
        i = wp.tid()
        order_out[i] = i
        if inverse[i] == real64(0.0):
            bin_out[i] = bins
            between_out[i] = 0
            cell_out[i] = ivec(NOWHERE)
            weight_out[i] = shares()
            return
        half = ivec()
        cell = ivec()
        above = ivec()
        upper = vec()
        for m in range(d):
            # beyond the grid: in the cell at its edge
            y = wp.clamp((positions[i][m] - low[m]) / width, real(0.0), real(dims[m]))
            half[m] = wp.clamp(wp.int32(real(2.0) * y), 0, 2 * dims[m] - 1)
            cell[m] = half[m] // 2
            above[m] = (half[m] + 1) // 2
            upper[m] = wp.clamp(y + real(0.5) - real(above[m]), real(0.0), real(1.0))
            if above[m] == 0:
                upper[m] = real(1.0)
            if above[m] == dims[m]:
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
        between_out[i] = flat(above, dims + ivec(1))
        cell_out[i] = cell
        weight_out[i] = weight

    @kit.kernel(METHOD)
    def find_starts(n: wp.int32, bin: counts, start_out: counts):
        """First of the sorted unknowns in each bin, or in a later one where it is empty."""
        b = wp.tid()
        low = wp.int32(0)
        high = n
        # not `wp.lower_bound`, which gives n - 1 where all are smaller
        while low < high:
            middle = (low + high) // 2
            if bin[middle] < b:
                low = middle + 1
            else:
                high = middle
        start_out[b] = low

    @kit.func(METHOD)
    def close(c: wp.int32, excess: wp.float64, coupling_out: numbers, excess_out: numbers, diagonal_out: numbers):
        """Finish a row of a level's matrix: one with neither couplings nor excess stays out."""
        total = excess
        for s in range(around):
            total += coupling_out[c * around + s]
        excess_out[c] = excess
        diagonal_out[c] = total

    @kit.kernel(METHOD)
    def gather(
        # Model:
        dims: ivec,
        scale: wp.float64,
        # Matrix:
        first: counts,
        count: counts,
        index: counts,
        value: wp.array(dtype=real),
        diagonal: wp.array(dtype=real),
        # State in:
        start: counts,
        order: counts,
        cell: wp.array(dtype=ivec),
        # Out:
        coupling_out: numbers,
        excess_out: numbers,
        diagonal_out: numbers,
    ):
        """The matrix between cells: the sums of all entries between their unknowns, scaled."""
        c = wp.tid()
        here = unflat(c, dims)
        sums = row()
        total = real64(0.0)
        excess = real64(0.0)
        for k in range(corners):
            bin = flat(2 * here + corner(k), 2 * dims)
            for place in range(start[bin], start[bin + 1]):
                i = order[place]
                total += real64(diagonal[i])
                for entry in range(first[i], first[i] + count[i]):
                    there = cell[index[entry]]
                    v = real64(value[entry])
                    to = slot(there - here)
                    if to >= 0:
                        sums[to] += v
                    elif there[0] >= 0:
                        # across a periodic boundary, perhaps
                        excess -= v
        for s in range(around):
            excess -= sums[s]
            # a preconditioner has to be positive, whatever the matrix
            coupling_out[c * around + s] = wp.max(scale * sums[s], real64(0.0))
        coupling_out[c * around + around // 2] = real64(0.0)
        excess += total
        if excess < real64(ROUNDING) * total:
            # the cells of a singular matrix must be singular, too: their constant part is divided by the excess
            excess = real64(0.0)
        excess *= wp.min(real64(1.0), real64(2.0) * scale)
        close(c, excess, coupling_out, excess_out, diagonal_out)

    @kit.kernel(METHOD)
    def weigh_again(
        # State in:
        inverse: numbers,
        between: counts,
        corner_diagonal: wp.array(dtype=shares),
        # Out:
        weight_out: wp.array(dtype=shares),
    ):
        """Leave cells without an unknown out of the interpolation, so that constants remain constant beside them.

        Otherwise a domain that the cells do not divide evenly takes half as many iterations again.
        """
        i = wp.tid()
        if inverse[i] == real64(0.0):
            return
        weight = weight_out[i]
        there = corner_diagonal[between[i]]
        total = real64(0.0)
        for k in range(corners):
            if there[k] <= real64(0.0):
                weight[k] = real64(0.0)
            total += weight[k]
        if total > real64(0.0):
            weight /= total
        weight_out[i] = weight

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
    def collect_particles(
        # Model:
        dims: ivec,
        # State in:
        start: counts,
        order: counts,
        weight: wp.array(dtype=shares),
        r: numbers,
        # Out:
        corner_out: wp.array(dtype=shares),
    ):
        """Residuals of the unknowns between the same 2^d cell centres, weighted for each of these cells."""
        t = wp.tid()
        above = unflat(t, dims + ivec(1))
        total = shares()
        for k in range(corners):
            half = 2 * above - ivec(1) + corner(k)
            inside = wp.int32(1)
            for m in range(d):
                if half[m] < 0 or half[m] >= 2 * dims[m]:
                    inside = 0
            if inside == 1:
                bin = flat(half, 2 * dims)
                for place in range(start[bin], start[bin + 1]):
                    i = order[place]
                    total += r[i] * weight[i]
        corner_out[t] = total

    @kit.kernel(METHOD)
    def collect_corners(
        # Model:
        dims: ivec,
        # State in:
        diagonal: numbers,
        corner_sums: wp.array(dtype=shares),
        # Out:
        r_out: numbers,
        e_out: numbers,
    ):
        """Residual of each cell, and the first sweep on it."""
        c = wp.tid()
        here = unflat(c, dims)
        total = real64(0.0)
        for k in range(corners):
            total += corner_sums[flat(here + ivec(1) - corner(k), dims + ivec(1))][k]
        r_out[c] = total
        e = real64(0.0)
        if diagonal[c] > real64(0.0):
            e = real64(DAMPING) * total / diagonal[c]
        e_out[c] = e

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

    @kit.kernel(METHOD)
    def spread(dims: ivec, e: numbers, corner_out: wp.array(dtype=shares)):
        """Values of the 2^d cells around each box between centres; a cell beyond the edge has weight 0."""
        t = wp.tid()
        above = unflat(t, dims + ivec(1))
        values = shares()
        for k in range(corners):
            cell = above - ivec(1) + corner(k)
            for m in range(d):
                cell[m] = wp.clamp(cell[m], 0, dims[m] - 1)
            values[k] = e[flat(cell, dims)]
        corner_out[t] = values

    @kit.kernel(METHOD)
    def interpolate_particles(
        # State in:
        inverse: numbers,
        between: counts,
        weight: wp.array(dtype=shares),
        corner_e: wp.array(dtype=shares),
        # Out:
        z_out: numbers,
    ):
        """Add the correction of the cells to the unknowns."""
        i = wp.tid()
        if inverse[i] != real64(0.0):
            z_out[i] += wp.dot(weight[i], corner_e[between[i]])

    made = (locate, find_starts, gather, weigh_again, coarsen, collect_particles, collect_corners, find_residual)
    made += (collect_cells, interpolate_cells, sweep, spread, interpolate_particles)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})

"""Kernels of the preconditioned conjugate gradient method: products, dot products in a fixed order, convergence.

The loop has two kinds of pass, selected by a flag on the device. An iteration updates the residual by recurrence. A
restart pass computes the true residual b - A x with the same kernels, and restarts the search directions from it. The
first pass is a restart, and so is the one after a residual that seems below the target. Only true residuals are
reported.

References:
    Hestenes, M. R. and Stiefel, E., J. Res. Natl. Bur. Stand. 49 (1952) 409.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes

METHOD = "solver"

# Integers of the loop: whether this pass is a restart, whether p.A p or r.z was not positive, and two counters.
RESTART, INDEFINITE, ITERATIONS, PASSES, CONTROLS = 0, 1, 2, 3, 4

# Scalars of the loop: alpha, beta, r.z, and the squares of the reference norm, of the target and of the last true
# residual.
ALPHA, BETA, RZ, REFERENCE, TARGET, LAST, SCALARS = 0, 1, 2, 3, 4, 5, 6

# Statistics over all solves, and of the last one.
SOLVES, SUM, MOST, WORST, STAGNATED, EXHAUSTED, ITERATIONS_NOW, RESIDUAL_NOW, STATISTICS = 0, 1, 2, 3, 4, 5, 6, 7, 8


@functools.cache
def solver_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels of one precision of the matrix; unknowns and sums are always in double precision."""
    real, real64 = types.real, wp.float64
    zero = wp.constant(wp.float64(0.0))
    counts, numbers, pairs = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64), wp.array(dtype=wp.vec2d)

    @types.func(METHOD)
    def off_diagonal(
        first: wp.int32,
        count: wp.int32,
        index: wp.array(dtype=wp.int32),
        value: wp.array(dtype=real),
        v: wp.array(dtype=wp.float64),
    ):
        """Sum over a row of value v, in two strands: a sum in one waits for every addition."""
        even = real64(0.0)
        odd = real64(0.0)
        k = first
        last = first + count
        while k + 1 < last:
            even += real64(value[k]) * v[index[k]]
            odd += real64(value[k + 1]) * v[index[k + 1]]
            k += 2
        if k < last:
            even += real64(value[k]) * v[index[k]]
        return even + odd

    @types.kernel(METHOD)
    def prepare(
        # Model:
        rows: counts,  # number of rows in use n, [1]
        active: counts,  # 1 for unknowns, else 0, [room]
        diagonal: wp.array(dtype=real),  # diagonal, [room]
        b: numbers,  # right-hand side b, [room]
        # State out:
        inverse_out: numbers,  # D^-1, [room]
        rhs_out: numbers,  # right-hand side b, [room]
        r_out: numbers,  # residual, [room]
        z_out: numbers,  # preconditioned residual, [room]
        p_out: numbers,  # search direction, [room]
        q_out: numbers,  # product A p, [room]
    ):
        """D^-1, which is 0 in rows that are not unknowns, the right-hand side b, and vectors that start at 0."""
        i = wp.tid()
        inverse = zero
        rhs = zero
        if i < rows[0] and active[i] != 0 and diagonal[i] > real(0.0):
            inverse = real64(1.0) / real64(diagonal[i])
            rhs = b[i]
        inverse_out[i] = inverse
        rhs_out[i] = rhs
        r_out[i] = zero
        z_out[i] = zero
        p_out[i] = zero
        q_out[i] = zero

    @types.kernel(METHOD)
    def multiply(
        # Model:
        first: counts,  # first entry of each row, [room]
        count: counts,  # number of entries of each row, [room]
        index: counts,  # column of each entry, [entries]
        value: wp.array(dtype=real),  # off-diagonal entries with their sign turned, [entries]
        diagonal: wp.array(dtype=real),  # diagonal, [room]
        inverse: numbers,  # D^-1, 0 in rows that are not unknowns, [room]
        # State in:
        control: counts,  # integers of the loop, [CONTROLS]
        x: numbers,  # solution, [room]
        p: numbers,  # search direction, [room]
        # State out:
        q_out: numbers,  # product A p, [room]
    ):
        """Product q = A p, or A x in a restart pass."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        if control[RESTART] != 0:
            q_out[i] = real64(diagonal[i]) * x[i] - off_diagonal(first[i], count[i], index, value, x)
        else:
            q_out[i] = real64(diagonal[i]) * p[i] - off_diagonal(first[i], count[i], index, value, p)

    @types.kernel(METHOD)
    def start_solve(
        # Model:
        tolerance: wp.float64,  # target relative to |b| [-]
        floor: wp.float64,  # least target
        # State in:
        square: pairs,  # b . b, [1]
        # State out:
        running_out: counts,  # 1 while the loop runs, [1]
        control_out: counts,  # integers of the loop, [CONTROLS]
        scalars_out: numbers,  # scalars of the loop, [SCALARS]
    ):
        """Start a solve with a restart pass; the target is |r| <= max(tolerance |b|, floor)."""
        running_out[0] = 1
        for k in range(CONTROLS):
            control_out[k] = 0
        for k in range(SCALARS):
            scalars_out[k] = zero
        control_out[RESTART] = 1
        reference = square[0][0]
        scalars_out[REFERENCE] = reference
        scalars_out[TARGET] = wp.max(tolerance * tolerance * reference, floor * floor)

    @types.kernel(METHOD)
    def step_length(
        # State in:
        pq: pairs,  # p . A p, [1]
        # State in and out:
        control: counts,  # integers of the loop, [CONTROLS]
        scalars: numbers,  # scalars of the loop, [SCALARS]
    ):
        """Step length alpha = r.z / p.A p; 0 where the matrix or its preconditioner is not positive."""
        rz = scalars[RZ]
        if pq[0][0] > zero and rz > zero:
            scalars[ALPHA] = rz / pq[0][0]
            control[INDEFINITE] = 0
        else:
            scalars[ALPHA] = zero
            control[INDEFINITE] = 1

    @types.kernel(METHOD)
    def update_solution(
        # Model:
        inverse: numbers,  # D^-1, 0 in rows that are not unknowns, [room]
        # State in:
        control: counts,  # integers of the loop, [CONTROLS]
        scalars: numbers,  # scalars of the loop, [SCALARS]
        rhs: numbers,  # right-hand side b, [room]
        p: numbers,  # search direction, [room]
        q: numbers,  # product A p, or A x, [room]
        # State in and out:
        x: numbers,  # solution, [room]
        r: numbers,  # residual, [room]
        # State out:
        z_out: numbers,  # preconditioned residual, [room]
    ):
        """Step x += alpha p and r -= alpha A p, or r = b - A x in a restart pass; z = D^-1 r with the diagonal D."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        r_i = zero
        if control[RESTART] != 0:
            r_i = rhs[i] - q[i]
        else:
            alpha = scalars[ALPHA]
            x[i] += alpha * p[i]
            r_i = r[i] - alpha * q[i]
        r[i] = r_i
        z_out[i] = inverse[i] * r_i

    @types.kernel(METHOD)
    def check_convergence(
        # Model:
        tolerance: wp.float64,  # target relative to |b| [-]
        max_iterations: wp.int32,  # most iterations
        max_restarts: wp.int32,  # most restarts
        # State in:
        products: pairs,  # r . z and r . r, [1]
        # State in and out:
        control: counts,  # integers of the loop, [CONTROLS]
        scalars: numbers,  # scalars of the loop, [SCALARS]
        statistics: numbers,  # statistics, [STATISTICS]
        # State out:
        running_out: counts,  # 1 while the loop runs, [1]
    ):
        """Beta = r.z / (r.z of the last pass), whether to continue, and whether the next pass is a restart.

        A solve ends after a restart pass alone, whose residual is the true one: if it is below the target, if it no
        longer decreases (stagnation), if it is not finite, or if the iterations are used up.
        """
        rz = products[0][0]
        rr = products[0][1]
        if control[RESTART] == 0:
            control[ITERATIONS] += 1
            scalars[BETA] = rz / wp.max(scalars[RZ], real64(1.0e-300))
            scalars[RZ] = rz
            exhausted = control[ITERATIONS] >= max_iterations
            # NaN fails every comparison, and the restart pass that follows detects it
            if exhausted or control[INDEFINITE] != 0 or not (rr > scalars[TARGET]):
                control[RESTART] = 1
            return

        if control[PASSES] == 0 and scalars[REFERENCE] == zero:
            # b = 0: what remains of the initial residual
            scalars[REFERENCE] = rr
            scalars[TARGET] = wp.max(tolerance * tolerance * rr, scalars[TARGET])
        done = rr <= scalars[TARGET]
        exhausted = control[ITERATIONS] >= max_iterations
        stagnated = False
        if control[PASSES] > 0 and not (rr < scalars[LAST]):
            stagnated = True
        if control[PASSES] > max_restarts or not (rr >= zero):
            stagnated = True
        if done or exhausted or stagnated:
            running_out[0] = 0
            iterations = real64(control[ITERATIONS])
            residual = wp.sqrt(rr)
            if scalars[REFERENCE] > zero:
                residual /= wp.sqrt(scalars[REFERENCE])
            statistics[SOLVES] += real64(1.0)
            statistics[SUM] += iterations
            statistics[MOST] = wp.max(statistics[MOST], iterations)
            # NaN is the worst, and stays
            if residual > statistics[WORST] or wp.isnan(residual):
                statistics[WORST] = residual
            statistics[ITERATIONS_NOW] = iterations
            statistics[RESIDUAL_NOW] = residual
            if not done and exhausted:
                statistics[EXHAUSTED] += real64(1.0)
            if not done and not exhausted:
                statistics[STAGNATED] += real64(1.0)
        control[RESTART] = 0
        control[PASSES] += 1
        scalars[LAST] = rr
        scalars[BETA] = zero
        scalars[RZ] = rz

    @types.kernel(METHOD)
    def update_direction(
        # Model:
        inverse: numbers,  # D^-1, 0 in rows that are not unknowns, [room]
        # State in:
        scalars: numbers,  # scalars of the loop, [SCALARS]
        z: numbers,  # preconditioned residual, [room]
        # State in and out:
        p: numbers,  # search direction, [room]
    ):
        """The next search direction p = z + beta p."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        beta = scalars[BETA]
        if beta == zero:
            # p is undefined after a restart pass
            p[i] = z[i]
        else:
            p[i] = z[i] + beta * p[i]

    @types.kernel(METHOD)
    def mark_unknowns(
        # Model:
        inverse: numbers,  # D^-1, 0 in rows that are not unknowns, [room]
        # State out:
        mask_out: numbers,  # 1 for unknowns, else 0, [room]
    ):
        """1 in the rows of unknowns, else 0."""
        i = wp.tid()
        unknown = zero
        if inverse[i] != zero:
            unknown = real64(1.0)
        mask_out[i] = unknown

    @types.kernel(METHOD)
    def remove_mean(
        # Model:
        singular: counts,  # 1 if constants are in the null space, else 0, [1]
        inverse: numbers,  # D^-1, 0 in rows that are not unknowns, [room]
        # State in:
        sums: pairs,  # sum over the unknowns and their number, [1]
        # State in and out:
        v: numbers,  # the vector, [room]
    ):
        """Subtract the mean of the unknowns from a vector if the system is singular."""
        i = wp.tid()
        if singular[0] != 0 and inverse[i] != zero:
            v[i] -= sums[0][0] / sums[0][1]

    return SimpleNamespace(
        prepare=prepare,
        multiply=multiply,
        start_solve=start_solve,
        step_length=step_length,
        update_solution=update_solution,
        check_convergence=check_convergence,
        update_direction=update_direction,
        mark_unknowns=mark_unknowns,
        remove_mean=remove_mean,
    )

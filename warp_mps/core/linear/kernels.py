"""Kernels of the conjugate gradients: products with a matrix in rows, dots in a fixed order, and the loop's decisions.

The loop has two kinds of pass, told apart by a flag on the device: an iteration, and a *fresh* pass, which computes
the true residual b - A x with the same kernels and starts the search directions anew. The first pass is fresh, and so
is the one that follows a residual which seems small enough. Nothing is reported that a fresh pass has not seen.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes

METHOD = "solver"

# Terms that one thread adds up. A sum over n rows is made in about log(n)/log(CHUNK) launches.
CHUNK = 128

# The loop's integers: whether this pass is fresh, whether its step length was meaningless, and what was counted.
RESTART, BROKEN, ITERATIONS, PASSES, CONTROLS = 0, 1, 2, 3, 4

# The loop's numbers: step length, direction's share of the last one, r.z, squares of the norm that the residual is
# measured by, of the residual asked for, and of the last true residual.
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
        # Matrix:
        rows: counts,
        active: counts,
        diagonal: wp.array(dtype=real),
        b: numbers,
        # Out:
        inverse_out: numbers,
        rhs_out: numbers,
        r_out: numbers,
        z_out: numbers,
        p_out: numbers,
        q_out: numbers,
    ):
        """The inverse of the diagonal, which is 0 in rows that are no unknowns, and vectors that are 0 there."""
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
        # Matrix:
        first: counts,
        count: counts,
        index: counts,
        value: wp.array(dtype=real),
        diagonal: wp.array(dtype=real),
        inverse: numbers,
        # State in:
        control: counts,
        x: numbers,
        p: numbers,
        # Out:
        q_out: numbers,
    ):
        """Q = A p, or A x in a fresh pass."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        if control[RESTART] != 0:
            q_out[i] = real64(diagonal[i]) * x[i] - off_diagonal(first[i], count[i], index, value, x)
        else:
            q_out[i] = real64(diagonal[i]) * p[i] - off_diagonal(first[i], count[i], index, value, p)

    @types.kernel(METHOD)
    def dots(across: wp.int32, along: wp.int32, a: numbers, b: numbers, c: numbers, sums_out: pairs):
        """Partial sums of a.b and a.c: thread t adds up the elements `across` t + `along` k, k < CHUNK."""
        t = wp.tid()
        ab = zero
        ac = zero
        i = across * t
        for _k in range(CHUNK):
            if i < a.shape[0]:
                ab += a[i] * b[i]
                ac += a[i] * c[i]
            i += along
        sums_out[t] = wp.vec2d(ab, ac)

    @types.kernel(METHOD)
    def fold(across: wp.int32, along: wp.int32, n: wp.int32, values: pairs, sums_out: pairs):
        """Partial sums of partial sums."""
        t = wp.tid()
        total = wp.vec2d()
        i = across * t
        for _k in range(CHUNK):
            if i < n:
                total += values[i]
            i += along
        sums_out[t] = total

    @types.kernel(METHOD)
    def begin(
        tolerance: wp.float64,
        floor: wp.float64,
        # State in:
        square: pairs,
        # Out:
        running_out: counts,
        control_out: counts,
        scalars_out: numbers,
    ):
        """Start a solve with a fresh pass; the residual is measured by the norm of b."""
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
    def measure_step(
        # State in:
        pq: pairs,
        # Out:
        control_out: counts,
        scalars_out: numbers,
    ):
        """Alpha = r.z / p.A p. The matrix or its preconditioner is not positive where one of the two is not."""
        rz = scalars_out[RZ]
        if pq[0][0] > zero and rz > zero:
            scalars_out[ALPHA] = rz / pq[0][0]
            control_out[BROKEN] = 0
        else:
            scalars_out[ALPHA] = zero
            control_out[BROKEN] = 1

    @types.kernel(METHOD)
    def advance(
        # Matrix:
        inverse: numbers,
        # State in:
        control: counts,
        scalars: numbers,
        rhs: numbers,
        p: numbers,
        q: numbers,
        # Out:
        x_out: numbers,
        r_out: numbers,
        z_out: numbers,
    ):
        """One step along p, or the true residual in a fresh pass, and the diagonal's share of the preconditioner."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        r = zero
        if control[RESTART] != 0:
            r = rhs[i] - q[i]
        else:
            alpha = scalars[ALPHA]
            x_out[i] += alpha * p[i]
            r = r_out[i] - alpha * q[i]
        r_out[i] = r
        z_out[i] = inverse[i] * r

    @types.kernel(METHOD)
    def decide(
        tolerance: wp.float64,
        max_iterations: wp.int32,
        max_restarts: wp.int32,
        # State in:
        products: pairs,
        # Out:
        running_out: counts,
        control_out: counts,
        scalars_out: numbers,
        statistics_out: numbers,
    ):
        """Whether to go on, and with a fresh pass or not, by r.z and r.r."""
        rz = products[0][0]
        rr = products[0][1]
        if control_out[RESTART] == 0:
            control_out[ITERATIONS] += 1
            scalars_out[BETA] = rz / wp.max(scalars_out[RZ], real64(1.0e-300))
            scalars_out[RZ] = rz
            exhausted = control_out[ITERATIONS] >= max_iterations
            # a comparison with a number that is none fails, and the fresh pass that follows says so
            if exhausted or control_out[BROKEN] != 0 or not (rr > scalars_out[TARGET]):
                control_out[RESTART] = 1
            return

        if control_out[PASSES] == 0 and scalars_out[REFERENCE] == zero:
            # b = 0: what remains of the initial residual
            scalars_out[REFERENCE] = rr
            scalars_out[TARGET] = wp.max(tolerance * tolerance * rr, scalars_out[TARGET])
        done = rr <= scalars_out[TARGET]
        exhausted = control_out[ITERATIONS] >= max_iterations
        stagnated = False
        if control_out[PASSES] > 0 and not (rr < scalars_out[LAST]):
            stagnated = True
        if control_out[PASSES] > max_restarts or not (rr >= zero):
            stagnated = True
        if done or exhausted or stagnated:
            running_out[0] = 0
            iterations = real64(control_out[ITERATIONS])
            residual = wp.sqrt(rr)
            if scalars_out[REFERENCE] > zero:
                residual /= wp.sqrt(scalars_out[REFERENCE])
            statistics_out[SOLVES] += real64(1.0)
            statistics_out[SUM] += iterations
            statistics_out[MOST] = wp.max(statistics_out[MOST], iterations)
            # where the residual is no number, it is the worst
            if not (residual <= statistics_out[WORST]):
                statistics_out[WORST] = residual
            statistics_out[ITERATIONS_NOW] = iterations
            statistics_out[RESIDUAL_NOW] = residual
            if not done and exhausted:
                statistics_out[EXHAUSTED] += real64(1.0)
            if not done and not exhausted:
                statistics_out[STAGNATED] += real64(1.0)
        control_out[RESTART] = 0
        control_out[PASSES] += 1
        scalars_out[LAST] = rr
        scalars_out[BETA] = zero
        scalars_out[RZ] = rz

    @types.kernel(METHOD)
    def turn(
        # Matrix:
        inverse: numbers,
        # State in:
        scalars: numbers,
        z: numbers,
        # Out:
        p_out: numbers,
    ):
        """The next direction p = z + beta p."""
        i = wp.tid()
        if inverse[i] == zero:
            return
        beta = scalars[BETA]
        if beta == zero:
            # after a fresh pass p may be anything
            p_out[i] = z[i]
        else:
            p_out[i] = z[i] + beta * p_out[i]

    @types.kernel(METHOD)
    def mark(inverse: numbers, mask_out: numbers):
        """1 in the rows of unknowns, else 0."""
        i = wp.tid()
        unknown = zero
        if inverse[i] != zero:
            unknown = real64(1.0)
        mask_out[i] = unknown

    @types.kernel(METHOD)
    def centre(singular: counts, inverse: numbers, sums: pairs, v_out: numbers):
        """Take the mean of the unknowns out of a vector if the system is singular."""
        i = wp.tid()
        if singular[0] != 0 and inverse[i] != zero:
            v_out[i] -= sums[0][0] / sums[0][1]

    return SimpleNamespace(
        prepare=prepare,
        multiply=multiply,
        dots=dots,
        fold=fold,
        begin=begin,
        measure_step=measure_step,
        advance=advance,
        decide=decide,
        turn=turn,
        mark=mark,
        centre=centre,
    )

"""Kernels of the two-level preconditioner: restriction, coarse solve and prolongation by rigid motions of aggregates.

z += P A_c^-1 P^T r,   A_c = P^T (K + m a) P
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.implicit.tangent_kernels import METHOD


@functools.cache
def two_level_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `arms`, `rigid_motion`, `restrict`, `sum_parts`, `coarse_solve`, `sum_shares` and `prolong`.

    A motion of an aggregate is a velocity of its centre and an angular velocity about it: 3 values in 2-D, 6 in 3-D.
    The conjugate wrench is a force and a moment. All kernels return at once while `on` is 0.
    """
    vec, d = types.vec, types.dimension
    real64 = wp.float64
    vec64 = wp.types.vector(length=d, dtype=wp.float64)
    modes = wp.types.vector(length=3 * (d - 1), dtype=wp.float64)
    counts, numbers = wp.array(dtype=wp.int32), wp.array(dtype=wp.float64)

    if d == 2:

        @types.func(METHOD)
        def wrench(arm: vec64, f: vec64) -> modes:
            """Force and moment of a force at an arm."""
            return modes(f[0], f[1], arm[0] * f[1] - arm[1] * f[0])

        @types.func(METHOD)
        def motion(arm: vec64, m: modes) -> vec64:
            """Velocity v + omega x arm of a motion of an aggregate at an arm."""
            return vec64(m[0] - m[2] * arm[1], m[1] + m[2] * arm[0])

    else:

        @types.func(METHOD)
        def wrench(arm: vec64, f: vec64) -> modes:
            """Force and moment of a force at an arm."""
            t = wp.cross(arm, f)
            return modes(f[0], f[1], f[2], t[0], t[1], t[2])

        @types.func(METHOD)
        def motion(arm: vec64, m: modes) -> vec64:
            """Velocity v + omega x arm of a motion of an aggregate at an arm."""
            return vec64(m[0], m[1], m[2]) + wp.cross(vec64(m[3], m[4], m[5]), arm)

    @types.kernel(METHOD)
    def arms(
        # Model:
        first: counts,  # first particle of each aggregate, [aggregates + 1]
        order: counts,  # particles, sorted by aggregate, [members]
        reference: wp.array(dtype=vec64),  # reference positions X [m], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements [m], [n]
        # State out:
        arm_out: wp.array(dtype=vec64),  # arms [m], [n]
    ):
        """Arms x_i - mean(x) from the centre of an aggregate to its particles, at their present positions."""
        a = wp.tid()
        total = vec64()
        for k in range(first[a], first[a + 1]):
            i = order[k]
            total += reference[i] + vec64(u[i])
        center = total / real64(first[a + 1] - first[a])
        for k in range(first[a], first[a + 1]):
            i = order[k]
            arm_out[i] = reference[i] + vec64(u[i]) - center

    @types.kernel(METHOD)
    def rigid_motion(
        # Model:
        colour: wp.int32,  # the colour
        mode: wp.int32,  # the unit motion
        aggregate: counts,  # aggregate of each particle, -1 for none, [n]
        colours: counts,  # colours of the aggregates, [aggregates]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        arm: wp.array(dtype=vec64),  # arms [m], [n]
        # State out:
        x_out: wp.array(dtype=vec64),  # the column, [n]
    ):
        """Column of P: a unit motion of all aggregates of one colour."""
        i = wp.tid()
        a = aggregate[i]
        x_out[i] = vec64()
        if a < 0:
            return
        if colours[a] == colour:
            unit = modes()
            unit[mode] = real64(1.0)
            x_out[i] = wp.cw_mul(vec64(free[i]), motion(arm[i], unit))

    @types.kernel(METHOD)
    def restrict(
        # Model:
        on: counts,  # 0 to return at once, [1]
        first: counts,  # first particle of each part, [parts + 1]
        order: counts,  # particles, sorted by aggregate, [members]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        arm: wp.array(dtype=vec64),  # arms [m], [n]
        r: wp.array(dtype=vec64),  # residual [N], [n]
        # State out:
        wrench_out: wp.array(dtype=modes),  # forces [N] and moments [N m], [parts]
    ):
        """Restriction P^T r on parts of the aggregates: sums of forces and moments."""
        part = wp.tid()
        if on[0] == 0:
            return
        total = modes()
        for k in range(first[part], first[part + 1]):
            i = order[k]
            total += wrench(arm[i], wp.cw_mul(vec64(free[i]), r[i]))
        wrench_out[part] = total

    @types.kernel(METHOD)
    def sum_parts(
        # Model:
        on: counts,  # 0 to return at once, [1]
        place: wp.int32,  # place of the first aggregate in the result
        first: counts,  # first part of each aggregate, [aggregates + 1]
        # State in:
        parts: wp.array(dtype=modes),  # wrenches on the parts [N], [N m], [parts]
        # State out:
        wrench_out: wp.array(dtype=modes),  # forces [N] and moments [N m], [aggregates]
    ):
        """Restriction of an aggregate: sum over its parts."""
        a = wp.tid()
        if on[0] == 0:
            return
        total = modes()
        for k in range(first[a], first[a + 1]):
            total += parts[k]
        wrench_out[place + a] = total

    @types.kernel(METHOD)
    def coarse_solve(
        # Model:
        on: counts,  # 0 to return at once, [1]
        shares: wp.int32,  # number of shares of a row
        by_columns: wp.int32,  # 1 to read the block by columns, else 0
        row_first: counts,  # first row of the block of each row, [rows]
        row_block: counts,  # first entry of its block, [rows]
        row_count: counts,  # number of rows of its block, [rows]
        # State in:
        inverse: numbers,  # entries of A_c^-1, block by block
        wrenches: numbers,  # wrenches on the aggregates [N], [N m], [rows]
        # State out:
        motion_out: numbers,  # shares of the motions, [shares rows]
    ):
        """A share of a row of A_c^-1, in the block of its body, times the wrenches, in four partial sums for speed.

        The block is symmetric: threads side by side read elements side by side if it is read by columns.
        """
        t = wp.tid()
        if on[0] == 0:
            return
        rows = row_first.shape[0]
        row = t % rows
        share = t // rows
        count = row_count[row]
        before = share * count // shares
        first = row_first[row] + before
        last = row_first[row] + (share + 1) * count // shares
        along = 1
        k = row_block[row] + (row - row_first[row]) * count + before
        if by_columns != 0:
            along = count
            k = row_block[row] + row - row_first[row] + before * count
        a = real64(0.0)
        b = real64(0.0)
        c = real64(0.0)
        e = real64(0.0)
        column = first
        while column + 3 < last:
            a += inverse[k] * wrenches[column]
            b += inverse[k + along] * wrenches[column + 1]
            c += inverse[k + 2 * along] * wrenches[column + 2]
            e += inverse[k + 3 * along] * wrenches[column + 3]
            k += 4 * along
            column += 4
        while column < last:
            a += inverse[k] * wrenches[column]
            k += along
            column += 1
        motion_out[t] = (a + b) + (c + e)

    @types.kernel(METHOD)
    def sum_shares(
        # Model:
        on: counts,  # 0 to return at once, [1]
        shares: wp.int32,  # number of shares of a row
        # State in:
        parts: numbers,  # shares of the motions, [shares rows]
        # State out:
        motion_out: numbers,  # motions of the aggregates [m], [rad], [rows]
    ):
        """Sum of the shares of a row."""
        row = wp.tid()
        if on[0] == 0:
            return
        total = real64(0.0)
        for share in range(shares):
            total += parts[share * motion_out.shape[0] + row]
        motion_out[row] = total

    @types.kernel(METHOD)
    def prolong(
        # Model:
        on: counts,  # 0 to return at once, [1]
        aggregate: counts,  # aggregate of each particle, -1 for none, [n]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        arm: wp.array(dtype=vec64),  # arms [m], [n]
        motions: wp.array(dtype=modes),  # motions of the aggregates [m], [rad], [aggregates]
        # State in and out:
        z: wp.array(dtype=vec64),  # preconditioned residual [m], [n]
    ):
        """Coarse correction z += P m: the rigid motions m of the aggregates at their particles."""
        i = wp.tid()
        if on[0] == 0:
            return
        a = aggregate[i]
        if a >= 0:
            z[i] = z[i] + wp.cw_mul(vec64(free[i]), motion(arm[i], motions[a]))

    made = (arms, rigid_motion, restrict, sum_parts, coarse_solve, sum_shares, prolong)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})

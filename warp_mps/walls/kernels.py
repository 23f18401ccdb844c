"""Rigid motion of walls on the device: the pose of every wall at a time, and the motion of its particles.

A point X of a wall, with r = X - pivot, angle a and unit axis k, is at

    x = X + s + (R - I) r,   (R - I) r = sin(a) k x r + 2 sin^2(a/2) k x (k x r)

s its displacement; its velocity is s' + a' k x R r, and its acceleration s'' + a'' k x R r + a'^2 k x (k x R r). The
rotation is formed from the half angle, and everything in double precision whatever that of the run, so that small
motions keep their digits.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.prescribed_motion import prescribed_motion_functions
from warp_mps.core.types import NumericTypes

METHOD = "walls"


@functools.cache
def wall_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `clock`, `pose`, `place`, `move_walls`, `wall_work` and `clear_forces`."""
    vec, d = types.vec, types.dimension
    vec64 = wp.types.vector(length=d, dtype=wp.float64)
    motions = prescribed_motion_functions(wp.float64, vec64, types.module(METHOD))
    harmonic_motion, table_motion = motions.harmonic_motion, motions.table_motion

    if d == 2:

        @types.func(METHOD)
        def axis_cross(axis: wp.vec3d, r: vec64) -> vec64:
            """The product k x r."""
            return vec64(-r[1], r[0])

    else:

        @types.func(METHOD)
        def axis_cross(axis: wp.vec3d, r: vec64) -> vec64:
            """The product k x r."""
            return wp.cross(axis, r)

    @types.func(METHOD)
    def rigid_motion(
        w: wp.int32,
        x: vec64,
        pivot: wp.array(dtype=vec64),
        axis: wp.array(dtype=wp.vec3d),
        value: wp.array(dtype=vec64, ndim=2),
        rate: wp.array(dtype=vec64, ndim=2),
        second: wp.array(dtype=vec64, ndim=2),
    ):
        """Displacement, velocity and acceleration of the point X of a wall; R r is its arm from the displaced pivot."""
        k = axis[w]
        r = x - pivot[w]
        angle = value[w, 1][0]
        half = wp.sin(wp.float64(0.5) * angle)
        across = axis_cross(k, r)
        u = value[w, 0] + wp.sin(angle) * across + (wp.float64(2.0) * half * half) * axis_cross(k, across)
        turning = rate[w, 1][0]
        around = axis_cross(k, r + u - value[w, 0])
        v = rate[w, 0] + turning * around
        a = second[w, 0] + second[w, 1][0] * around + (turning * turning) * axis_cross(k, around)
        return u, v, a

    @types.kernel(METHOD)
    def clock(
        # State in:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
        # Model:
        dt: wp.float64,  # time step [s]
        # State out:
        time_out: wp.array(dtype=wp.float64),  # time [s], [1]
    ):
        """Time t = n dt after n steps."""
        time_out[0] = wp.float64(steps[0]) * dt

    @types.kernel(METHOD)
    def pose(
        # Model:
        amplitude: wp.array(dtype=vec64, ndim=2),  # amplitudes [m] or [rad], [walls, 2]
        frequency: wp.array(dtype=wp.float64, ndim=2),  # frequencies, 0 for a table [Hz], [walls, 2]
        phase: wp.array(dtype=wp.float64, ndim=2),  # phases [rad], [walls, 2]
        start: wp.array(dtype=wp.int32, ndim=2),  # first row of each table and one past its last, [walls, 4]
        times: wp.array(dtype=wp.float64),  # times of the rows [s], [rows]
        rows: wp.array(dtype=vec64),  # displacements [m] or angles [rad] of the rows, [rows]
        slopes: wp.array(dtype=vec64),  # their slopes [m/s] or [rad/s], [rows]
        cubic: wp.array(dtype=wp.int32, ndim=2),  # 1 for cubic interpolation, else 0, [walls, 2]
        # State in:
        time: wp.array(dtype=wp.float64),  # time [s], [1]
        # State out:
        value_out: wp.array(dtype=vec64, ndim=2),  # displacements [m] and angles [rad], [walls, 2]
        rate_out: wp.array(dtype=vec64, ndim=2),  # their rates [m/s] and [rad/s], [walls, 2]
        second_out: wp.array(dtype=vec64, ndim=2),  # their second derivatives [m/s^2] and [rad/s^2], [walls, 2]
    ):
        """Displacement (column 0) or angle (column 1, in its first component) of a wall, and its two derivatives.

        Harmonic where f > 0, else by the rows `start[wall, 2 k]` to `start[wall, 2 k + 1]` of the table, if any; see
        `warp_mps.core.prescribed_motion`.
        """
        w, k = wp.tid()
        t = time[0]
        value = vec64()
        rate = vec64()
        second = vec64()
        first = start[w, 2 * k]
        last = start[w, 2 * k + 1] - 1
        if frequency[w, k] > wp.float64(0.0):
            value, rate, second = harmonic_motion(t, amplitude[w, k], frequency[w, k], phase[w, k])
        elif last > first:
            value, rate, second = table_motion(t, first, last, times, rows, slopes, cubic[w, k])
        value_out[w, k] = value
        rate_out[w, k] = rate
        second_out[w, k] = second

    @types.kernel(METHOD)
    def place(
        # Model:
        first: wp.int32,  # first particle of this launch
        wall: wp.array(dtype=wp.int32),  # wall of each particle, -1 for none, [n]
        reference: wp.array(dtype=vec64),  # reference positions X [m], [n]
        pivot: wp.array(dtype=vec64),  # pivots [m], [walls]
        axis: wp.array(dtype=wp.vec3d),  # unit axes of rotation [-], [walls]
        # State in:
        value: wp.array(dtype=vec64, ndim=2),  # displacements [m] and angles [rad], [walls, 2]
        rate: wp.array(dtype=vec64, ndim=2),  # their rates [m/s] and [rad/s], [walls, 2]
        second: wp.array(dtype=vec64, ndim=2),  # their second derivatives [m/s^2] and [rad/s^2], [walls, 2]
        # State out:
        x_out: wp.array(dtype=vec),  # positions [m], [n]
        v_out: wp.array(dtype=vec),  # velocities [m/s], [n]
        a_out: wp.array(dtype=vec),  # accelerations [m/s^2], [n]
    ):
        """Positions, velocities and accelerations of the particles that belong to a wall (index at least 0)."""
        i = first + wp.tid()
        w = wall[i]
        if w >= 0:
            u, v, a = rigid_motion(w, reference[i], pivot, axis, value, rate, second)
            x_out[i] = vec(reference[i] + u)
            v_out[i] = vec(v)
            a_out[i] = vec(a)

    @types.kernel(METHOD)
    def move_walls(
        # Model:
        first: wp.int32,  # first particle of this launch
        elastic: wp.int32,  # number e of elastic particles
        wall: wp.array(dtype=wp.int32),  # wall of each particle, -1 for none, [n]
        reference: wp.array(dtype=vec64),  # reference positions X [m], [n]
        pivot: wp.array(dtype=vec64),  # pivots [m], [walls]
        axis: wp.array(dtype=wp.vec3d),  # unit axes of rotation [-], [walls]
        # State in:
        value: wp.array(dtype=vec64, ndim=2),  # displacements [m] and angles [rad], [walls, 2]
        rate: wp.array(dtype=vec64, ndim=2),  # their rates [m/s] and [rad/s], [walls, 2]
        second: wp.array(dtype=vec64, ndim=2),  # their second derivatives [m/s^2] and [rad/s^2], [walls, 2]
        contact: wp.array(dtype=vec),  # contact forces [N], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements [m], [n]
        # State out:
        v_out: wp.array(dtype=vec),  # velocities [m/s], [n]
        a_out: wp.array(dtype=vec),  # accelerations [m/s^2], [n]
        move_out: wp.array(dtype=vec),  # displacements of this step [m], [n - e]
        # State in and out:
        work: wp.array(dtype=wp.float64),  # work of the wall particles so far [J], [n - e]
    ):
        """Move wall particles, which come after the elastic ones, and add the first half of the work of the step.

        A wall does the work dW = -1/2 (f^n + f^(n+1)) . du against the contact forces f on it: the first half here, the
        second in `wall_work`.
        """
        i = first + wp.tid()
        n = i - elastic
        new, v, a = rigid_motion(wall[i], reference[i], pivot, axis, value, rate, second)
        move = vec(new) - u[i]
        u[i] = vec(new)
        v_out[i] = vec(v)
        a_out[i] = vec(a)
        move_out[n] = move
        work[n] = work[n] - wp.float64(0.5) * wp.float64(wp.dot(contact[i], move))

    @types.kernel(METHOD)
    def wall_work(
        # Model:
        first: wp.int32,  # first particle of this launch
        elastic: wp.int32,  # number e of elastic particles
        # State in:
        contact: wp.array(dtype=vec),  # contact forces [N], [n]
        move: wp.array(dtype=vec),  # displacements of this step [m], [n - e]
        # State in and out:
        work: wp.array(dtype=wp.float64),  # work of the wall particles so far [J], [n - e]
    ):
        """Second half of the work of the walls: W -= 1/2 f^(n+1) . du."""
        i = first + wp.tid()
        n = i - elastic
        work[n] = work[n] - wp.float64(0.5) * wp.float64(wp.dot(contact[i], move[n]))

    @types.kernel(METHOD)
    def clear_forces(
        # Model:
        first: wp.int32,  # first particle of this launch
        # State out:
        force_out: wp.array(dtype=vec),  # forces [N], [n]
    ):
        """Set the forces on the walls to 0."""
        force_out[first + wp.tid()] = vec()

    return SimpleNamespace(
        clock=clock, pose=pose, place=place, move_walls=move_walls, wall_work=wall_work, clear_forces=clear_forces
    )

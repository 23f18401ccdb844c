"""What acts on a body from outside: moving supports and forces on a region, and the work that they do."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.prescribed_motion import prescribed_motion_functions
from warp_mps.core.types import NumericTypes

METHOD = "elastic"


@functools.cache
def boundary_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `drive`, `drive_work`, `push` and `push_work`."""
    real, vec = types.real, types.vec
    motions = prescribed_motion_functions(real, vec, types.module(METHOD))
    harmonic_motion, table_motion = motions.harmonic_motion, motions.table_motion

    @types.func(METHOD)
    def harmonic(t: wp.float64, frequency: wp.float64, phase: wp.float64) -> real:
        """sin(2 pi f t + phase), or 1 for f = 0."""
        if frequency == wp.float64(0.0):
            return real(1.0)
        return real(wp.sin(wp.float64(wp.TAU) * frequency * t + phase))

    @types.kernel(METHOD)
    def drive(
        # Model:
        particles: wp.array(dtype=wp.int32),
        axes: vec,
        dt: wp.float64,
        amplitude: vec,
        frequency: wp.float64,
        phase: wp.float64,
        times: wp.array(dtype=wp.float64),
        table: wp.array(dtype=vec),
        slopes: wp.array(dtype=vec),
        mass: wp.array(dtype=real),
        steps: wp.array(dtype=wp.int32),
        # State in:
        force: wp.array(dtype=vec),
        # State in and out:
        u: wp.array(dtype=vec),
        v: wp.array(dtype=vec),
        acceleration_out: wp.array(dtype=vec),
        move_out: wp.array(dtype=vec),
        work: wp.array(dtype=wp.float64),
    ):
        """Place the particles of a moving support: harmonic where f > 0, else by the table.

        Between rows the table is linear, or where it has slopes, cubic.

        The support's work is the gain of kinetic energy, less the work of all other forces: half of the move times the
        last step's force here, the other half in `drive_work`. So it holds where a table makes the velocity jump.
        """
        n = wp.tid()
        i = particles[n]
        t = wp.float64(steps[0]) * dt
        place = vec()
        speed = vec()
        acceleration = vec()
        if frequency > wp.float64(0.0):
            place, speed, acceleration = harmonic_motion(t, amplitude, frequency, phase)
        else:
            last = times.shape[0] - 1
            place, speed, acceleration = table_motion(t, 0, last, times, table, slopes, slopes.shape[0])
        u_i = u[i]
        v_i = v[i]
        a_i = acceleration_out[i]
        move = vec()
        gain = wp.float64(0.0)
        for axis in range(wp.static(types.dimension)):
            if axes[axis] > real(0.0):
                new = wp.float64(speed[axis])
                old = wp.float64(v_i[axis])
                gain += new * new - old * old
                # the drift has moved it on by the last velocity
                move[axis] = place[axis] - (u_i[axis] - real(dt) * v_i[axis])
                u_i[axis] = place[axis]
                v_i[axis] = speed[axis]
                a_i[axis] = acceleration[axis]
        u[i] = u_i
        v[i] = v_i
        acceleration_out[i] = a_i
        # the motion that a run starts with is given, not worked for
        if steps[0] > 0:
            move_out[n] = move
            gained = wp.float64(0.5) * wp.float64(mass[i]) * gain
            work[n] = work[n] + gained - wp.float64(0.5) * wp.float64(wp.dot(force[i], move))

    @types.kernel(METHOD)
    def drive_work(
        # Model:
        particles: wp.array(dtype=wp.int32),
        # State in:
        force: wp.array(dtype=vec),
        move: wp.array(dtype=vec),
        # State in and out:
        work: wp.array(dtype=wp.float64),
    ):
        """Work of a moving support against the new forces over the second half of its move."""
        k = wp.tid()
        work[k] = work[k] - wp.float64(0.5) * wp.float64(wp.dot(force[particles[k]], move[k]))

    @types.kernel(METHOD)
    def push(
        # Model:
        particles: wp.array(dtype=wp.int32),
        dt: wp.float64,
        acceleration: vec,
        frequency: wp.float64,
        phase: wp.float64,
        mass: wp.array(dtype=real),
        steps: wp.array(dtype=wp.int32),
        # State out:
        force_out: wp.array(dtype=vec),
    ):
        """Force of a load, shared in proportion to mass."""
        i = particles[wp.tid()]
        t = wp.float64(steps[0]) * dt
        force_out[i] = force_out[i] + (mass[i] * harmonic(t, frequency, phase)) * acceleration

    @types.kernel(METHOD)
    def push_work(
        # Model:
        particles: wp.array(dtype=wp.int32),
        dt: wp.float64,
        weight: wp.float64,
        acceleration: vec,
        frequency: wp.float64,
        phase: wp.float64,
        mass: wp.array(dtype=real),
        steps: wp.array(dtype=wp.int32),
        # State in:
        v: wp.array(dtype=vec),
        # State in and out:
        power: wp.array(dtype=real),
        work: wp.array(dtype=wp.float64),
    ):
        """Work of a load: force times velocity, the mean of a step's ends; `weight` is dt, or 0 before the first."""
        k = wp.tid()
        i = particles[k]
        t = wp.float64(steps[0]) * dt
        new = mass[i] * harmonic(t, frequency, phase) * wp.dot(acceleration, v[i])
        work[k] = work[k] + wp.float64(0.5) * weight * wp.float64(power[k] + new)
        power[k] = new

    return SimpleNamespace(drive=drive, drive_work=drive_work, push=push, push_work=push_work)

"""Boundary conditions of elastic bodies: moving supports, loads on a region, and the work of both."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.prescribed_motion import prescribed_motion_functions
from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD


@functools.cache
def boundary_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `move_supports`, `support_work`, `add_loads` and `load_work`."""
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
    def move_supports(
        # Model:
        particles: wp.array(dtype=wp.int32),  # particles of the region, [k]
        axes: vec,  # 1 on held axes, else 0
        dt: wp.float64,  # time step [s]
        amplitude: vec,  # amplitudes [m]
        frequency: wp.float64,  # frequency f, 0 for none [Hz]
        phase: wp.float64,  # phase [rad]
        times: wp.array(dtype=wp.float64),  # times of the table [s], [rows]
        table: wp.array(dtype=vec),  # its displacements [m], [rows]
        slopes: wp.array(dtype=vec),  # its slopes [m/s], [rows], or empty if linear
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
        force: wp.array(dtype=vec),  # total forces [N], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        a: wp.array(dtype=vec),  # prescribed accelerations [m/s^2], [n]
        move: wp.array(dtype=vec),  # displacements of this step [m], [k]
        work: wp.array(dtype=wp.float64),  # work so far [J], [k]
    ):
        """Impose the prescribed motion u(t) of a support: harmonic where f > 0, else by the table.

        The motion is that of `warp_mps.core.prescribed_motion`; the table is cubic where it has slopes.

        The work of the support is the gain of kinetic energy less the work of all other forces,

            dW = 1/2 m (v^2 - v_0^2) - 1/2 (f^n + f^(n+1)) . du

        the part with f^n here, that with f^(n+1) in `support_work`. It holds also where the velocity of a table jumps.
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
        a_i = a[i]
        step = vec()
        gain = wp.float64(0.0)
        for axis in range(wp.static(types.dimension)):
            if axes[axis] > real(0.0):
                new = wp.float64(speed[axis])
                old = wp.float64(v_i[axis])
                gain += new * new - old * old
                # the drift has already moved it by dt times the last velocity
                step[axis] = place[axis] - (u_i[axis] - real(dt) * v_i[axis])
                u_i[axis] = place[axis]
                v_i[axis] = speed[axis]
                a_i[axis] = acceleration[axis]
        u[i] = u_i
        v[i] = v_i
        a[i] = a_i
        # the initial velocity is given, and took no work
        if steps[0] > 0:
            move[n] = step
            gained = wp.float64(0.5) * wp.float64(mass[i]) * gain
            work[n] = work[n] + gained - wp.float64(0.5) * wp.float64(wp.dot(force[i], step))

    @types.kernel(METHOD)
    def support_work(
        # Model:
        particles: wp.array(dtype=wp.int32),  # particles of the region, [k]
        # State in:
        force: wp.array(dtype=vec),  # total forces [N], [n]
        move: wp.array(dtype=vec),  # displacements of this step [m], [k]
        # State in and out:
        work: wp.array(dtype=wp.float64),  # work so far [J], [k]
    ):
        """Second half of the work of a moving support: W -= 1/2 f^(n+1) . du."""
        k = wp.tid()
        work[k] = work[k] - wp.float64(0.5) * wp.float64(wp.dot(force[particles[k]], move[k]))

    @types.kernel(METHOD)
    def add_loads(
        # Model:
        particles: wp.array(dtype=wp.int32),  # particles of the region, [k]
        dt: wp.float64,  # time step [s]
        acceleration: vec,  # load per mass [m/s^2]
        frequency: wp.float64,  # frequency f, 0 for none [Hz]
        phase: wp.float64,  # phase [rad]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
        # State in and out:
        force: wp.array(dtype=vec),  # total forces [N], [n]
    ):
        """f_i += m_i a sin(2 pi f t + p), the share of a load in proportion to mass; a alone where f = 0."""
        i = particles[wp.tid()]
        t = wp.float64(steps[0]) * dt
        force[i] = force[i] + (mass[i] * harmonic(t, frequency, phase)) * acceleration

    @types.kernel(METHOD)
    def load_work(
        # Model:
        particles: wp.array(dtype=wp.int32),  # particles of the region, [k]
        dt: wp.float64,  # time step [s]
        weight: wp.float64,  # dt, or 0 at the start [s]
        acceleration: vec,  # load per mass [m/s^2]
        frequency: wp.float64,  # frequency f, 0 for none [Hz]
        phase: wp.float64,  # phase [rad]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State in and out:
        power: wp.array(dtype=real),  # power of the load at the last step [W], [k]
        work: wp.array(dtype=wp.float64),  # work so far [J], [k]
    ):
        """Work of a load, W += dt/2 (P^n + P^(n+1)) with its power P = f . v; `weight` is dt, or 0 at the start."""
        k = wp.tid()
        i = particles[k]
        t = wp.float64(steps[0]) * dt
        new = mass[i] * harmonic(t, frequency, phase) * wp.dot(acceleration, v[i])
        work[k] = work[k] + wp.float64(0.5) * weight * wp.float64(power[k] + new)
        power[k] = new

    return SimpleNamespace(
        move_supports=move_supports, support_work=support_work, add_loads=add_loads, load_work=load_work
    )

"""What acts on a body from outside: moving supports and forces on a region, and the work that they do."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit

METHOD = "elastic"


@functools.cache
def load_kernels(kit: Kit) -> SimpleNamespace:
    """Kernels `drive`, `drive_work`, `push` and `push_work`."""
    real, vec = kit.real, kit.vec

    @kit.func(METHOD)
    def harmonic(t: wp.float64, frequency: wp.float64, phase: wp.float64) -> real:
        """sin(2 pi f t + phase), or 1 for f = 0."""
        if frequency == wp.float64(0.0):
            return real(1.0)
        return real(wp.sin(wp.float64(wp.TAU) * frequency * t + phase))

    @kit.kernel(METHOD)
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
        mass: wp.array(dtype=real),
        steps: wp.array(dtype=wp.int32),
        # State out:
        u: wp.array(dtype=vec),
        v: wp.array(dtype=vec),
        acceleration_out: wp.array(dtype=vec),
        # State in and out:
        work: wp.array(dtype=wp.float64),
    ):
        """Place the particles of a moving support: harmonic where f > 0, else by the table (linear between rows).

        What their kinetic energy changes by is work of the support, also where a table makes the velocity jump.
        """
        n = wp.tid()
        i = particles[n]
        t = wp.float64(steps[0]) * dt
        place = vec()
        speed = vec()
        acceleration = vec()
        if frequency > wp.float64(0.0):
            w = wp.float64(wp.TAU) * frequency
            place = real(wp.sin(w * t + phase) - wp.sin(phase)) * amplitude
            speed = real(w * wp.cos(w * t + phase)) * amplitude
            acceleration = real(-w * w * wp.sin(w * t + phase)) * amplitude
        else:
            last = times.shape[0] - 1
            k = wp.clamp(wp.lower_bound(times, t), 1, last)
            span = times[k] - times[k - 1]
            s = wp.clamp((t - times[k - 1]) / span, wp.float64(0.0), wp.float64(1.0))
            place = table[k - 1] + real(s) * (table[k] - table[k - 1])
            if t >= times[0] and t < times[last]:
                speed = real(wp.float64(1.0) / span) * (table[k] - table[k - 1])
        u_i = u[i]
        v_i = v[i]
        a_i = acceleration_out[i]
        gain = wp.float64(0.0)
        for axis in range(wp.static(kit.dimension)):
            if axes[axis] > real(0.0):
                gain += wp.float64(speed[axis]) * wp.float64(speed[axis]) - wp.float64(v_i[axis]) * wp.float64(
                    v_i[axis]
                )
                u_i[axis] = place[axis]
                v_i[axis] = speed[axis]
                a_i[axis] = acceleration[axis]
        u[i] = u_i
        v[i] = v_i
        acceleration_out[i] = a_i
        # the motion that a run starts with is given, not worked for
        if steps[0] > 0:
            work[n] = work[n] + wp.float64(0.5) * wp.float64(mass[i]) * gain

    @kit.kernel(METHOD)
    def drive_work(
        # Model:
        particles: wp.array(dtype=wp.int32),
        axes: vec,
        dt: real,
        # State in:
        v: wp.array(dtype=vec),
        force: wp.array(dtype=vec),
        # State in and out:
        power: wp.array(dtype=real),
        work: wp.array(dtype=wp.float64),
    ):
        """Work of a moving support against all other forces on its particles, besides what `drive` adds."""
        k = wp.tid()
        i = particles[k]
        new = -wp.dot(wp.cw_mul(axes, force[i]), v[i])
        work[k] = work[k] + wp.float64(real(0.5) * dt * (power[k] + new))
        power[k] = new

    @kit.kernel(METHOD)
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

    @kit.kernel(METHOD)
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

"""Forces of body forces on elastic particles, and their work."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes

METHOD = "elastic_body_force"


@functools.cache
def body_force_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `locate`, `elapsed_time`, `weigh` and `add_work`."""
    real, vec = types.real, types.vec

    @types.kernel(METHOD)
    def locate(
        # Model:
        reference: wp.array(dtype=vec),  # reference positions X [m], [n]
        ahead: real,  # time ahead [s]
        # State in:
        u: wp.array(dtype=vec),  # displacements [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State out:
        x_out: wp.array(dtype=vec),  # positions [m], [n]
    ):
        """Positions x = X + u + h v, h = `ahead` [m]."""
        i = wp.tid()
        x_out[i] = reference[i] + u[i] + ahead * v[i]

    @types.kernel(METHOD)
    def elapsed_time(
        # Model:
        dt: wp.float64,  # time step [s]
        # State in:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
        # State out:
        time_out: wp.array(dtype=wp.float64),  # time [s], [1]
    ):
        """Time after so many steps [s]."""
        time_out[0] = wp.float64(steps[0]) * dt

    @types.kernel(METHOD)
    def weigh(
        # Model:
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        acceleration: wp.array(dtype=vec),  # forces per mass [m/s^2], [n]
        # State in and out:
        total: wp.array(dtype=vec),  # total forces [N], [n]
        # State out:
        force_out: wp.array(dtype=vec),  # body forces [N], [n]
    ):
        """Force f = m a of each particle, added to its total force [N]."""
        i = wp.tid()
        force = mass[i] * acceleration[i]
        force_out[i] = force
        total[i] = total[i] + force

    @types.kernel(METHOD)
    def add_work(
        # Model:
        dt: wp.float64,  # time step [s]
        # State in:
        force: wp.array(dtype=vec),  # body forces [N], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State in and out:
        power: wp.array(dtype=wp.float64),  # power at the last step [W], [n]
        work: wp.array(dtype=wp.float64),  # work so far [J], [n]
    ):
        """Work dW = dt/2 (f_0 . v_0 + f_1 . v_1) of a step, by the powers at its two ends [J]."""
        i = wp.tid()
        new = wp.float64(wp.dot(force[i], v[i]))
        work[i] = work[i] + wp.float64(0.5) * dt * (power[i] + new)
        power[i] = new

    return SimpleNamespace(locate=locate, elapsed_time=elapsed_time, weigh=weigh, add_work=add_work)

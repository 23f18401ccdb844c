"""The length of a step, chosen on the device by the CFL condition, and the clock.

    dt = min(dt_max, C l0 / max |u|),   C the CFL number

shortened so that a whole number of equal steps leads to the target time.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD


@functools.cache
def adaptive_step_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `square_speeds`, `choose_time_step` and `advance_clock`."""
    real, vec = types.real, types.vec

    @types.kernel(METHOD)
    def square_speeds(
        # Model:
        chunk: wp.int32,
        # State in:
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State out:
        fastest_out: wp.array(dtype=real),  # squares of the largest speeds [m^2/s^2], [n / chunk]
    ):
        """Max u . u over each chunk of particles."""
        c = wp.tid()
        value = real(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, u.shape[0])):
            value = wp.max(value, wp.dot(u[i], u[i]))
        fastest_out[c] = value

    @types.kernel(METHOD)
    def choose_time_step(
        # Model:
        limit: wp.float64,
        reach: wp.float64,
        # State in:
        fastest: wp.array(dtype=real),  # squares of the largest speeds of chunks [m^2/s^2], [n / chunk]
        target: wp.array(dtype=wp.float64),  # time that steps go towards [s], [1]
        time: wp.array(dtype=wp.float64),  # time [s], [1]
        # State out:
        dt_out: wp.array(dtype=wp.float64),  # time step [s], [1]
        displacement_out: wp.array(dtype=wp.float64),  # displacement of the fastest particle in the step [m], [1]
        steps_left_out: wp.array(dtype=wp.int32),  # number of steps up to the target, [1]
        end_out: wp.array(dtype=wp.float64),  # time at the end of the step [s], [1]
        middle_out: wp.array(dtype=wp.float64),  # time at its midpoint [s], [1]
    ):
        """Dt = (target - time)/N with N = ceil((target - time) / min(limit, reach / max |u|)).

        The limit is the longest time step dt_max [s], the reach the largest displacement C l0 in a step [m].
        """
        square = real(0.0)
        for c in range(fastest.shape[0]):
            square = wp.max(square, fastest[c])
        longest = wp.min(limit, reach / wp.max(wp.sqrt(wp.float64(square)), wp.float64(1.0e-30)))
        rest = target[0] - time[0]
        steps = wp.max(wp.ceil(rest / longest - wp.float64(1.0e-9)), wp.float64(1.0))
        dt_out[0] = rest / steps
        displacement_out[0] = rest / steps * wp.sqrt(wp.float64(square))
        steps_left_out[0] = wp.int32(wp.min(steps, wp.float64(1.0e9)))
        if steps == wp.float64(1.0):
            end_out[0] = target[0]
        else:
            end_out[0] = time[0] + rest / steps
        middle_out[0] = time[0] + wp.float64(0.5) * dt_out[0]

    @types.kernel(METHOD)
    def advance_clock(
        # State in:
        end: wp.array(dtype=wp.float64),  # time at the end of the step [s], [1]
        # State out:
        time_out: wp.array(dtype=wp.float64),  # time [s], [1]
        # State in and out:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
    ):
        """Time = end, and one step more is done."""
        time_out[0] = end[0]
        steps[0] = steps[0] + 1

    return SimpleNamespace(square_speeds=square_speeds, choose_time_step=choose_time_step, advance_clock=advance_clock)

"""The length of a step, chosen on the device from the speed of the fastest particle (CFL number), and the clock."""

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
    def square_speeds(chunk: wp.int32, u: wp.array(dtype=vec), fastest_out: wp.array(dtype=real)):
        """Square of the largest speed of each chunk of particles."""
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
        fastest: wp.array(dtype=real),
        target: wp.array(dtype=wp.float64),
        time: wp.array(dtype=wp.float64),
        # Out:
        dt_out: wp.array(dtype=wp.float64),
        way_out: wp.array(dtype=wp.float64),
        left_out: wp.array(dtype=wp.int32),
        time_after_out: wp.array(dtype=wp.float64),
    ):
        """The next step, one of equal ones up to the target time, and the way of the fastest particle in it."""
        square = real(0.0)
        for c in range(fastest.shape[0]):
            square = wp.max(square, fastest[c])
        longest = wp.min(limit, reach / wp.max(wp.sqrt(wp.float64(square)), wp.float64(1.0e-30)))
        rest = target[0] - time[0]
        steps = wp.max(wp.ceil(rest / longest - wp.float64(1.0e-9)), wp.float64(1.0))
        dt_out[0] = rest / steps
        way_out[0] = rest / steps * wp.sqrt(wp.float64(square))
        left_out[0] = wp.int32(wp.min(steps, wp.float64(1.0e9)))
        if steps == wp.float64(1.0):
            time_after_out[0] = target[0]
        else:
            time_after_out[0] = time[0] + rest / steps

    @types.kernel(METHOD)
    def advance_clock(
        # State in:
        time_after: wp.array(dtype=wp.float64),
        # State out:
        time_out: wp.array(dtype=wp.float64),
        steps_out: wp.array(dtype=wp.int32),
    ):
        """Count a step."""
        time_out[0] = time_after[0]
        steps_out[0] = steps_out[0] + 1

    return SimpleNamespace(square_speeds=square_speeds, choose_time_step=choose_time_step, advance_clock=advance_clock)

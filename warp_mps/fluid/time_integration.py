"""Time integration: predictor, corrector and the end of a step.

    predictor:  u* = u + dt (nu lap u + g),  x* = x + dt u*
    corrector:  u = u* + du,                 x = x* + dt du     with du = -(dt/rho) grad p

The end of a step adds the velocity changes of collisions and the shifts, and applies the periodic boundaries.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct


@functools.cache
def integration_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `predict`, `correct` and `end_step`."""
    real, vec, d = types.real, types.vec, types.dimension
    Constants = fluid_constants_struct(types)
    vec64 = wp.types.vector(length=d, dtype=wp.float64)

    @types.kernel(METHOD)
    def predict(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),
        acceleration: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
        impulse_out: wp.array(dtype=vec64),
        work_out: wp.array(dtype=wp.float64),
    ):
        """The predictor of the fluid, and the viscous impulse on the walls, with their work."""
        i = wp.tid()
        h = real(dt[0])
        if i < fluid.walls:
            gained = (fluid.mass * dt[0]) * vec64(acceleration[i])
            impulse_out[i] = impulse_out[i] + gained
            work_out[i] = work_out[i] - wp.dot(gained, vec64(u_out[i]))
        elif lost[i] == 0:
            u = u_out[i] + h * (fluid.gravity + acceleration[i])
            u_out[i] = u
            x_out[i] = x_out[i] + h * u

    @types.kernel(METHOD)
    def correct(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),
        du: wp.array(dtype=vec),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
    ):
        """Change the velocities of the fluid, and its positions with them."""
        k = wp.tid()
        i = k + fluid.walls
        u_out[i] = u_out[i] + du[k]
        x_out[i] = x_out[i] + real(dt[0]) * du[k]

    @types.kernel(METHOD)
    def end_step(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),
        du: wp.array(dtype=vec),
        shift: wp.array(dtype=vec),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
        lost_out: wp.array(dtype=wp.int32),
        stale_out: wp.array(dtype=wp.int32),
        fallen_out: wp.array(dtype=wp.float64),
    ):
        """End a step: collisions and shifts, periods, and particles that have left the domain and the lists."""
        k = wp.tid()
        i = k + fluid.walls
        if lost_out[i] == 1:
            return
        u = u_out[i] + du[k]
        x = x_out[i] + real(dt[0]) * du[k] + shift[k]
        for axis in range(wp.static(d)):
            if fluid.period[axis] > real(0.0):
                gone = fluid.period[axis] * wp.floor((x[axis] - fluid.low[axis]) / fluid.period[axis])
                if gone != real(0.0):
                    x[axis] = x[axis] - gone
                    fallen_out[k] = fallen_out[k] + wp.float64(fluid.gravity[axis] * gone)
            elif not (x[axis] >= fluid.low[axis] and x[axis] <= fluid.high[axis]):
                lost_out[i] = 1
        if lost_out[i] == 1:
            u = vec()
            stale_out[0] = 1
        x_out[i] = x
        u_out[i] = u

    return SimpleNamespace(predict=predict, correct=correct, end_step=end_step)

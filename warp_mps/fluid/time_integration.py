"""Time integration: drift, predictor, corrector and the end of a step.

In the conservative scheme, without elastic bodies, forces act at the midpoint x^ of a step, and the particles move by
half a step before and after them (the position form of the Verlet method: Leimkuhler and Reich 2004, section 2.6):

    drift:      x^ = x + dt/2 u
    predictor:  u* = u + dt (nu lap u + g)
    corrector:  u' = u* + du,  x' = x^ + dt/2 u'     with du = -(dt/rho) grad p at x^

For a wave, x'' = -omega^2 x, that is symplectic: it loses no energy, and its period is short by (omega dt)^2/24.

Else the pressure is evaluated at predicted positions x*, for the damping of that: the determinant of such a step is
1 - omega^2 dt^2, and a wave loses 2 pi omega dt of its energy a period.

    predictor:  u* = u + dt (nu lap u + g),  x* = x + dt u*
    corrector:  u' = u* + du,                x' = x* + dt du     with du = -(dt/rho) grad p at x*

The end of a step adds the velocity changes of collisions and the shifts, and applies the periodic boundaries.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Leimkuhler, B. and Reich, S., Simulating Hamiltonian Dynamics (2004), Cambridge University Press.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct


@functools.cache
def integration_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `drift`, `predict`, `correct` and `end_step`."""
    real, vec, d = types.real, types.vec, types.dimension
    Constants = fluid_constants_struct(types)
    vec64 = wp.types.vector(length=d, dtype=wp.float64)

    @types.kernel(METHOD)
    def drift(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State in and out:
        x: wp.array(dtype=vec),  # positions [m], [n]
    ):
        """First half of the move of the fluid, x + dt/2 u."""
        i = wp.tid() + fluid.walls
        x[i] = x[i] + real(0.5) * real(dt[0]) * u[i]

    @types.kernel(METHOD)
    def predict(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        acceleration: wp.array(dtype=vec),  # viscous accelerations nu lap u [m/s^2], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        # State in and out:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        impulse: wp.array(dtype=vec64),  # impulses on walls [N s], in 2-D [N s/m], [w]
        work: wp.array(dtype=wp.float64),  # work of walls on the fluid [J], in 2-D [J/m], [w]
    ):
        """Predictor u* = u + dt (nu lap u + g), and where there is no drift x* = x + dt u*.

        The viscous impulse on a wall particle is m dt nu lap u, and its work on the fluid -impulse . u.
        """
        i = wp.tid()
        h = real(dt[0])
        if i < fluid.walls:
            gained = (fluid.mass * dt[0]) * vec64(acceleration[i])
            impulse[i] = impulse[i] + gained
            work[i] = work[i] - wp.dot(gained, vec64(u[i]))
        elif lost[i] == 0:
            u_i = u[i] + h * (fluid.gravity + acceleration[i])
            u[i] = u_i
            if fluid.midpoint == 0:
                x[i] = x[i] + h * u_i

    @types.kernel(METHOD)
    def correct(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        du: wp.array(dtype=vec),  # changes of velocity by the pressure, -dt grad p / rho [m/s], [m]
        # State in and out:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
    ):
        """Corrector u' = u* + du, x' = x^ + dt/2 u' of the fluid, or x' = x* + dt du."""
        k = wp.tid()
        i = k + fluid.walls
        u_i = u[i] + du[k]
        u[i] = u_i
        if fluid.midpoint == 1:
            x[i] = x[i] + real(0.5) * real(dt[0]) * u_i
        else:
            x[i] = x[i] + real(dt[0]) * du[k]

    @types.kernel(METHOD)
    def end_step(
        # Model:
        fluid: Constants,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        du: wp.array(dtype=vec),  # changes of velocity by collisions [m/s], [m]
        shift: wp.array(dtype=vec),  # shifts [m], [m]
        # State in and out:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        fallen: wp.array(dtype=wp.float64),  # gravity times the periods that particles were wrapped by [m^2/s^2], [m]
        # State out:
        stale_out: wp.array(dtype=wp.int32),  # 1 if a particle has left the domain, else untouched, [1]
    ):
        """End a step: u = u + du, x = x + h du + shift, wrapped into the period L: x = x - L floor((x - low)/L).

        h is the time that the last velocity has moved the particle for: dt/2, or dt where there is no drift.

        A particle that leaves the domain along an axis without a period is lost: it stays where it is, at rest.
        """
        k = wp.tid()
        i = k + fluid.walls
        if lost[i] == 1:
            return
        u_i = u[i] + du[k]
        h = real(dt[0])
        if fluid.midpoint == 1:
            h *= real(0.5)
        x_i = x[i] + h * du[k] + shift[k]
        for axis in range(wp.static(d)):
            if fluid.period[axis] > real(0.0):
                wrapped = fluid.period[axis] * wp.floor((x_i[axis] - fluid.low[axis]) / fluid.period[axis])
                if wrapped != real(0.0):
                    x_i[axis] = x_i[axis] - wrapped
                    fallen[k] = fallen[k] + wp.float64(fluid.gravity[axis] * wrapped)
            elif not (x_i[axis] >= fluid.low[axis] and x_i[axis] <= fluid.high[axis]):
                lost[i] = 1
        if lost[i] == 1:
            u_i = vec()
            stale_out[0] = 1
        x[i] = x_i
        u[i] = u_i

    return SimpleNamespace(drift=drift, predict=predict, correct=correct, end_step=end_step)

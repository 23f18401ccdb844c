"""Body forces on fluid particles: their part of the predictor, of the pressure at walls, and their work.

u* = u + dt (nu lap u + g + f),    p_j - p_i = rho (g + f_j - a_j) . x_ij beyond a wall particle j
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes

METHOD = "fluid_body_force"


@functools.cache
def body_force_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `add_to_velocity`, `add_acceleration`, `subtract_from_walls` and `add_work`."""
    real, vec = types.real, types.vec
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)

    @types.kernel(METHOD)
    def add_to_velocity(
        # Model:
        walls: wp.int32,  # number of wall particles w
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        force: wp.array(dtype=vec),  # body forces per mass [m/s^2], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        # Out:
        u_out: wp.array(dtype=vec),  # velocities with those by body forces [m/s], [n]
    ):
        """Velocities u + dt f of fluid particles, and u of walls [m/s]."""
        i = wp.tid()
        u_i = u[i]
        if i >= walls:
            u_i += real(dt[0]) * force[i]
        u_out[i] = u_i

    @types.kernel(METHOD)
    def add_acceleration(
        # Model:
        walls: wp.int32,  # number of wall particles w
        keep: real,  # 1 to keep the accelerations, 0 to replace them
        mass: wp.float64,  # mass of a particle [kg], in 2-D [kg/m]
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        force: wp.array(dtype=vec),  # body forces per mass [m/s^2], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        # State in and out:
        acceleration: wp.array(dtype=vec),  # accelerations of the predictor [m/s^2], [n]
        impulse: wp.array(dtype=vec64),  # impulses of the body forces so far [N s], [m]
        work: wp.array(dtype=wp.float64),  # work so far [J], [m]
    ):
        """Acceleration `keep` a + f of a fluid particle, its impulse m dt f, and half of the work, dt/2 m f . u."""
        k = wp.tid()
        i = k + walls
        acceleration[i] = keep * acceleration[i] + force[i]
        if lost[i] == 0:
            given = (mass * dt[0]) * vec64(force[i])
            impulse[k] = impulse[k] + given
            work[k] = work[k] + wp.float64(0.5) * wp.dot(given, vec64(u[i]))

    @types.kernel(METHOD)
    def subtract_from_walls(
        # Model:
        moving: wp.array(dtype=wp.int32),  # 1 for particles of moving walls, else 0, [w]
        # State in:
        force: wp.array(dtype=vec),  # body forces per mass [m/s^2], [n]
        # State in and out:
        a: wp.array(dtype=vec),  # accelerations of walls less the body forces [m/s^2], [n]
    ):
        """Subtract the body force from the acceleration of a wall particle, which stands for g - a in all relations.

        Where a wall is at rest, the acceleration is 0 without the force.
        """
        j = wp.tid()
        own = vec()
        if moving[j] == 1:
            own = a[j]
        a[j] = own - force[j]

    @types.kernel(METHOD)
    def add_work(
        # Model:
        walls: wp.int32,  # number of wall particles w
        mass: wp.float64,  # mass of a particle [kg], in 2-D [kg/m]
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        force: wp.array(dtype=vec),  # body forces per mass [m/s^2], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        # State in and out:
        work: wp.array(dtype=wp.float64),  # work so far [J], [m]
    ):
        """The other half of the work, dt/2 m f . u with the velocity at the end of the step [J]."""
        k = wp.tid()
        i = k + walls
        if lost[i] == 0:
            work[k] = work[k] + wp.float64(0.5) * mass * dt[0] * wp.dot(vec64(force[i]), vec64(u[i]))

    return SimpleNamespace(
        add_to_velocity=add_to_velocity,
        add_acceleration=add_acceleration,
        subtract_from_walls=subtract_from_walls,
        add_work=add_work,
    )

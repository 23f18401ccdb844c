"""Explicit viscosity, and no-slip walls.

    a_i = nu lap u_i = nu laplacian sum_j w_ij (u_j - u_i)

Where water does not slip, viscosity sees inside a wall the velocity u_w + (u_w - u), u that of the water about there,
so that the water has the wall's velocity u_w at the wall's face (Adami, Hu & Adams 2012).

References:
    Adami, S., Hu, X. Y. and Adams, N. A., Journal of Computational Physics 231 (2012) 7057.
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.neighbour_search import neighbour_table_struct


@functools.cache
def viscosity_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `ghost_velocity` and `viscous_acceleration`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement, weight = displacement_function(types), weight_function(types)

    @types.kernel(METHOD)
    def ghost_velocity(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        no_slip: wp.array(dtype=wp.int32),  # 1 for fluid particles and no-slip walls, else 0, [n]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        # State out:
        ghost_out: wp.array(dtype=vec),  # velocities of no-slip ghost particles [m/s], [w]
    ):
        """Velocity u_w + (u_w - u) of a no-slip ghost particle, u = sum_i w u_i / sum_i w (Adami, Hu & Adams 2012).

        A free-slip wall particle keeps its own velocity u_w.
        """
        j = wp.tid()
        u_j = u[j]
        total = vec()
        weights = real(0.0)
        if no_slip[j] == 1:
            for m in range(neighbours.count[j]):
                i = neighbours.index[j, m]
                w = real(1 - lost[i]) * weight(wp.length(displacement(x[i], x[j], fluid.period)), fluid.radius)
                total += w * (u_j - u[i])
                weights += w
        if weights > real(0.0):
            u_j += total / weights
        ghost_out[j] = u_j

    @types.kernel(METHOD)
    def viscous_acceleration(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        no_slip: wp.array(dtype=wp.int32),  # 1 for fluid particles and no-slip walls, else 0, [n]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        ghost: wp.array(dtype=vec),  # velocities of no-slip ghost particles [m/s], [w]
        # State out:
        acceleration_out: wp.array(dtype=vec),  # viscous accelerations [m/s^2], [n]
    ):
        """Viscous acceleration nu lap u_i = nu laplacian sum_j w_ij (u_j - u_i) (Koshizuka & Oka 1996).

        It is found for walls and fluid alike. No-slip walls enter with the velocities of their ghost particles;
        free-slip walls do not enter.
        """
        i = wp.tid()
        x_i = x[i]
        u_i = u[i]
        if i < fluid.walls:
            u_i = ghost[i]
        total = vec()
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            if no_slip[i] + no_slip[j] == 2 and lost[j] == 0:
                u_j = u[j]
                if j < fluid.walls:
                    u_j = ghost[j]
                total += weight(wp.length(displacement(x_i, x[j], fluid.period)), fluid.radius) * (u_j - u_i)
        acceleration_out[i] = fluid.viscous_factor * total

    return SimpleNamespace(ghost_velocity=ghost_velocity, viscous_acceleration=viscous_acceleration)

"""Pressure forces of the fluid on the particles of walls, and the pressures there.

    F_w = -V sum_i s_i c (p_i + p_w) x_wi,   c = gradient * g/r_e^2

It is the force of the conservative scheme whatever the scheme (`warp_mps.fluid.gradient`): sums of pressure
differences, by which the others move the fluid, do not hold the level of the pressure.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.gradient import CLOSEST, gradient_kernels
from warp_mps.fluid.neighbour_search import neighbour_table_struct
from warp_mps.fluid.schemes import CONSERVATIVE
from warp_mps.fluid.still_water import still_water_kernels


@functools.cache
def wall_force_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `pressure_wall_impulse` and `wall_pressure`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    displacement, weight = displacement_function(types), weight_function(types)
    still_water, gradient = still_water_kernels(types), gradient_kernels(types)
    pair_weight, wet_share = still_water.pair_weight, still_water.wet_share
    wall_particle_pressure, pair_pressure = gradient.wall_particle_pressure, gradient.pair_pressure

    @types.kernel(METHOD)
    def pressure_wall_impulse(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        a: wp.array(dtype=vec),  # accelerations of walls [m/s^2], [n]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        density_scale: wp.array(dtype=real),  # density scales s [-], [m]
        wall_gradient: wp.array(dtype=vec),  # pressure gradients along walls [Pa/m], [m]
        rest: wp.array(dtype=real),  # share by which the water is at rest [-], [1]
        # State in and out:
        impulse: wp.array(dtype=vec64),  # impulses on walls [N s], in 2-D [N s/m], [w]
        work: wp.array(dtype=wp.float64),  # work of walls on the fluid [J], in 2-D [J/m], [w]
    ):
        """Add the impulse dt V sum_i s_i c (p_i + p_w) x_iw on a wall particle, and the wall's work -impulse . u.

        x_iw points from the fluid particle to the wall particle. In 2-D impulse and work are per metre.
        """
        j = wp.tid()
        x_j = x[j]
        total = vec()
        for m in range(neighbours.count[j]):
            i = neighbours.index[j, m]
            x_ij = displacement(x[i], x_j, fluid.period)
            square = wp.dot(x_ij, x_ij)
            if square < fluid.radius * fluid.radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * fluid.radius)
                c = pair_weight(fluid, rest[0], r)
                p_i = real(p[i - fluid.walls])
                beyond = fluid.density * wp.dot(fluid.gravity - a[j], x_ij)
                p_j = wall_particle_pressure(fluid, j, p_i, beyond)
                c *= wet_share(fluid, rest[0], p_i + beyond)
                pressed = pair_pressure(wp.static(CONSERVATIVE), p_i, p_j, p_i)
                pressed += wp.dot(wall_gradient[i - fluid.walls], x_ij)
                total += (density_scale[i - fluid.walls] * c * pressed) * x_ij
        gained = (dt[0] * wp.float64(fluid.volume)) * vec64(total)
        impulse[j] = impulse[j] + gained
        work[j] = work[j] - wp.dot(gained, vec64(u[j]))

    @types.kernel(METHOD)
    def wall_pressure(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        a: wp.array(dtype=vec),  # accelerations of walls [m/s^2], [n]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        # State out:
        p_out: wp.array(dtype=wp.float64),  # pressures at wall particles [Pa], [w]
    ):
        """Pressure at a wall particle, sum_i w (p_i + rho (g - a_w) . x_iw) / sum_i w over the fluid about it."""
        j = wp.tid()
        x_j = x[j]
        total = real(0.0)
        weights = real(0.0)
        for m in range(neighbours.count[j]):
            i = neighbours.index[j, m]
            x_ij = displacement(x[i], x_j, fluid.period)
            w = weight(wp.length(x_ij), fluid.radius)
            p_w = real(p[i - fluid.walls]) + fluid.density * wp.dot(fluid.gravity - a[j], x_ij)
            if fluid.clip == 1:
                p_w = wp.max(p_w, real(0.0))
            total += w * p_w
            weights += w
        if weights > real(0.0):
            total = total / weights
        p_out[j] = wp.float64(total)

    return SimpleNamespace(pressure_wall_impulse=pressure_wall_impulse, wall_pressure=wall_pressure)

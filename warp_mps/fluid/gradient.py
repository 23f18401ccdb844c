"""Pressure gradient and the forces of fluid particles on each other.

Force per volume on particle i, with c = gradient * g/r_e^2 of each pair (`warp_mps.fluid.operator_constants`):

    conservative:   -sum_j c (s_i + s_j)/2 (p_i + p_j) x_ij   equal and opposite; it keeps particles evenly spaced
    corrected:      -C_i sum_j c (p_j - p_i) x_ij             exact for linear fields, C_i^-1 = sum_j c x_ij x_ij
    koshizuka_oka:  -sum_j c (p_j - p_min) x_ij               p_min the least pressure about i (Koshizuka & Oka 1996)

s_i = d / sum_j c r^2 makes up for particles that do not lie as on a lattice, 1 there; it is bounded, for at the surface
it would count what is not there. The pressure of a wall's particle is that of the fluid particle that looks at it, plus
rho (g - a) . x_ij. In the conservative scheme a flat wall also continues what the slope of the pressure along it
differs by from that of water at rest (`warp_mps.fluid.mirror_planes`), or it would hold the water back.

Where negative pressures are clipped, p_j of a wall is never below 0. The conservative force of a pair with a marker of
an elastic body is that of the pressure halfway, (p_i + p_j)/2, and there this is never below 0: what of a body is above
the water's level does not push. With p_j instead, bodies were found to float 0.07 to 0.12 spacings too high.

In water at rest the pair weight has another radius, and walls above its level do not push
(`warp_mps.fluid.still_water`).

Where both pressures of a pair add up to a pull, which happens only if negative pressures are allowed, the conservative
force takes p_j - p_i (Sun, Colagrossi, Marrone, Antuono & Zhang 2018), for a pull clusters particles.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Sun, P. N., et al., Computer Physics Communications 224 (2018) 63.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.mirror_planes import LEAST_SPREAD, mirror_plane_kernels
from warp_mps.fluid.neighbour_search import neighbour_table_struct
from warp_mps.fluid.pressure.divergence import LEAST_DETERMINANT
from warp_mps.fluid.schemes import CONSERVATIVE, CORRECTED
from warp_mps.fluid.still_water import still_water_kernels

# closest distance that a force sees, in effective radii: what is closer is two particles that collide
CLOSEST = 0.02


@functools.cache
def gradient_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `wall_tangential_gradient`, `pressure_velocity_change`; functions of the pressures that they take."""
    real, vec, mat, d = types.real, types.vec, types.mat, types.dimension
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement = displacement_function(types)
    still_water = still_water_kernels(types)
    pair_weight, wet_share = still_water.pair_weight, still_water.wet_share
    tangential_moment = mirror_plane_kernels(types).tangential_moment

    @types.func(METHOD)
    def wall_particle_pressure(fluid: Constants, j: wp.int32, p_i: real, step: real) -> real:
        """Pressure of a wall particle j as seen from a fluid particle, p_w = p_i + rho (g - a_w) . x_iw [Pa].

        Clipped, it is at least 0, and at least -p_i of a body's marker in the conservative scheme; see the module.
        """
        p_j = p_i + step
        if fluid.clip == 1:
            least = real(0.0)
            if j < fluid.markers and fluid.scheme == wp.static(CONSERVATIVE):
                least = -p_i
            p_j = wp.max(p_j, least)
        return p_j

    @types.func(METHOD)
    def pair_pressure(scheme: wp.int32, p_i: real, p_j: real, p_min: real) -> real:
        """Pressure of a pair's force [Pa]: p_i + p_j, p_j - p_i or p_j - p_min by the scheme; see the module."""
        if scheme == wp.static(CONSERVATIVE):
            if p_i + p_j >= real(0.0):
                return p_i + p_j
            return p_j - p_i
        if scheme == wp.static(CORRECTED):
            return p_j - p_i
        return p_j - p_min

    @types.kernel(METHOD)
    def wall_tangential_gradient(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        a: wp.array(dtype=vec),  # accelerations of walls [m/s^2], [n]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        normal: wp.array(dtype=vec),  # normals into the walls beside particles [-], [m]
        depth: wp.array(dtype=real),  # distances from the faces of these walls, 0 without [m], [m]
        rest: wp.array(dtype=real),  # share by which the water is at rest [-], [1]
        # State out:
        wall_gradient_out: wp.array(dtype=vec),  # pressure gradients along walls [Pa/m], [m]
    ):
        """Pressure gradient along the wall beside a fluid particle, less that of water at rest; 0 without a flat wall.

        (sum_j c (p_j - p_i) x_ij - rho M (sum_w c (g - a_w)) / sum_w c) / m, projected on the wall, over wall particles
        w and fluid particles j; M = sum_j c x_ij x_ij, and m is its mean along the wall.
        """
        k = wp.tid()
        result = vec()
        if depth[k] > real(0.0):
            i = k + fluid.walls
            x_i = x[i]
            moments = mat()
            total = vec()
            pull = vec()
            weights = real(0.0)
            for m in range(neighbours.count[i]):
                j = neighbours.index[i, m]
                x_ij = displacement(x_i, x[j], fluid.period)
                square = wp.dot(x_ij, x_ij)
                if square < fluid.radius * fluid.radius:
                    c = pair_weight(fluid, rest[0], wp.sqrt(square))
                    if j < fluid.walls:
                        pull += c * (fluid.gravity - a[j])
                        weights += c
                    else:
                        # the difference in double precision: that of water at rest has to cancel
                        total += (c * real(p[j - fluid.walls] - p[k])) * x_ij
                        moments += c * wp.outer(x_ij, x_ij)
            n = normal[k]
            own = tangential_moment(moments, n)
            if own > real(LEAST_SPREAD) and weights > real(0.0):
                total = (total - (fluid.density / weights) * (moments * pull)) / own
                result = total - wp.dot(total, n) * n
        wall_gradient_out[k] = result

    @types.kernel(METHOD)
    def pressure_velocity_change(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        x: wp.array(dtype=vec),  # positions [m], [n]
        a: wp.array(dtype=vec),  # accelerations of walls [m/s^2], [n]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        density_scale: wp.array(dtype=real),  # density scales s [-], [m]
        wall_gradient: wp.array(dtype=vec),  # pressure gradients along walls [Pa/m], [m]
        rest: wp.array(dtype=real),  # share by which the water is at rest [-], [1]
        # State out:
        du_out: wp.array(dtype=vec),  # changes of velocity [m/s], [m]
    ):
        """Change of a fluid particle's velocity, du = -dt grad p / rho, by the force of the scheme; see the module."""
        k = wp.tid()
        i = k + fluid.walls
        x_i = x[i]
        p_i = real(p[k])
        s_i = density_scale[k]
        p_min = p_i
        if fluid.scheme > wp.static(CORRECTED):
            for m in range(neighbours.count[i]):
                j = neighbours.index[i, m]
                if j >= fluid.walls and wp.length(displacement(x_i, x[j], fluid.period)) < fluid.radius:
                    p_min = wp.min(p_min, real(p[j - fluid.walls]))
        moments = mat()
        total = vec()
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            x_ij = displacement(x_i, x[j], fluid.period)
            square = wp.dot(x_ij, x_ij)
            if square < fluid.radius * fluid.radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * fluid.radius)
                c = pair_weight(fluid, rest[0], r)
                p_j = real(p[wp.max(j - fluid.walls, 0)])
                s_j = density_scale[wp.max(j - fluid.walls, 0)]
                step = real(0.0)
                if j < fluid.walls:
                    beyond = fluid.density * wp.dot(fluid.gravity - a[j], x_ij)
                    p_j = wall_particle_pressure(fluid, j, p_i, beyond)
                    s_j = s_i
                    step = wp.dot(wall_gradient[k], x_ij)
                    c *= wet_share(fluid, rest[0], p_i + beyond)
                if fluid.scheme == wp.static(CONSERVATIVE):
                    c *= real(0.5) * (s_i + s_j)
                total += (c * (pair_pressure(fluid.scheme, p_i, p_j, p_min) + step)) * x_ij
                if fluid.scheme == wp.static(CORRECTED):
                    moments += c * wp.outer(x_ij, x_ij)
        if fluid.scheme == wp.static(CORRECTED):
            turn = wp.identity(n=wp.static(d), dtype=real)
            if wp.determinant(moments) > real(LEAST_DETERMINANT):
                turn = wp.inverse(moments)
            total = turn * total
        du_out[k] = (-real(dt[0]) / fluid.density) * total

    return SimpleNamespace(
        wall_particle_pressure=wall_particle_pressure,
        pair_pressure=pair_pressure,
        wall_tangential_gradient=wall_tangential_gradient,
        pressure_velocity_change=pressure_velocity_change,
    )

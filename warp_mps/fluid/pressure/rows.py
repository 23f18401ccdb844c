"""The rows of the PPE and its right-hand side.

Row of a fluid particle i, over the fluid particles j, with c_ij = laplacian w_ij (Koshizuka & Oka 1996):

    sum_j c_ij (p_i - p_j) + (b_i + k_i) p_i = rho sum_w c_iw (g - a_w) . (x_iw - tilt_i) + rho s_i + k_i p_i^old

Source: s = (e/tau - div u*)/dt, with the rate of dilatation of `warp_mps.fluid.pressure.divergence` for div u*. The
first term restores the number density, e = n/n0 - 1, slowly: over tau = 2 sqrt(l0/g) at the midpoint of a step, where a
dam break would lose 2 % of its volume with 3 sqrt(l0/g), and over 3 sqrt(l0/g) at predicted positions. An e from 0 to
0.1 l0^2/r_e^2 counts as 0: particles in disorder have that much at the volume of a lattice, and water at rest would
swell by it. The original method has s = e/dt^2 alone. All of it removes the whole error in one step, by velocities of
about e l0/dt that stay: the shorter the steps, the faster they are, and the shorter the next step. That runs away; a
share of 0.2 does not, and errors still decay in some ten steps.

Walls w are not unknowns: the pressure beyond a wall follows from the wall's acceleration a_w, p_w - p_i =
rho (g - a_w) . x_iw. Along a flat wall the conservative scheme adds the water's mirror image
(`warp_mps.fluid.mirror_planes`) to c_ij. Water at rest, whose pressure differs by rho (g - a_w) . x_iw, must not count
a second time: `tilt_i` is the sum of c x_ij over images, divided by the sum of c over the wall's particles.

Free surface: b_i is the part beyond it (`warp_mps.fluid.pressure.density`), and e counts as 0 there.

Damping: conservative forces push a particle by 2 p_i sum_j g x_ij beyond the gradient, which the equation lacks. In
deep water that feeds back on the pressure of the next step and may grow. Half of the true operator never exceeds -lap +
k |sum_j g x_ij|^2 with k = 4. The term k_i (p_i - p_i^old) makes the feedback decay, and is 0 where p is steady.
`DAMPING` is larger, for tanks that are filled too full.

In water at rest b_i and the source beside the surface are those of `warp_mps.fluid.still_water`, and k_i is 0.

References:
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
from warp_mps.fluid.mirror_planes import mirror_plane_kernels
from warp_mps.fluid.neighbour_search import neighbour_table_struct
from warp_mps.fluid.pressure.density import CLOSEST, density_functions
from warp_mps.fluid.pressure.divergence import divergence_functions
from warp_mps.fluid.schemes import CONSERVATIVE, KOSHIZUKA_OKA
from warp_mps.fluid.still_water import still_water_kernels

# errors of the number density count as this one at most: strained lattices and splashes show larger ones
LARGEST_ERROR = 0.02
# excess of the number density of particles in disorder at the volume of a lattice, times (r_e/l0)^2
DISORDER = 0.1
# share of the error of the number density that the original scheme removes in a step
ORIGINAL_SHARE = 0.2
# factor k of the term that damps changes of the pressure of unevenly surrounded particles
DAMPING = 16.0


@functools.cache
def row_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernel `assemble`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement, weight = displacement_function(types), weight_function(types)
    image_distance_squared = mirror_plane_kernels(types).mirror_distance_squared
    density, velocity = density_functions(types), divergence_functions(types)
    DensitySums, VelocitySums = density.DensitySums, velocity.VelocitySums
    add_density_pair, is_free_surface = density.add_density_pair, density.is_free_surface
    beyond_surface, density_scale = density.beyond_surface, density.density_scale
    divergence_weight, dilatation_rate = velocity.divergence_weight, velocity.dilatation_rate
    beyond_level = still_water_kernels(types).beyond_level
    add_fluid_velocity, add_wall_velocity = velocity.add_fluid_velocity, velocity.add_wall_velocity

    @wp.struct
    class WallSums:
        """Sums over the wall particles within r_e, and over mirror images, with c = laplacian w.

        Attributes:
            pressure: sum_w c (g - a_w) . x_iw [1/s^2].
            pull: sum_w c (g - a_w) [1/(m s^2)].
            share: sum_w c [1/m^2].
            lean: Sum of c x_ij over mirror images [1/m].
        """

        pressure: real
        pull: vec
        share: real
        lean: vec

    @types.func(METHOD)
    def add_wall_pair(sums: wp.ref[WallSums], c: real, x_ij: vec, relative_gravity: vec):
        """Add a wall particle at x_ij [m]; the relative gravity is g - a_w [m/s^2]."""
        sums.pressure += c * wp.dot(relative_gravity, x_ij)
        sums.pull += c * relative_gravity
        sums.share += c

    @types.func(METHOD)
    def source(e: real, div: real, dt: real, fluid: Constants) -> real:
        """Source s = (e/tau - div u*)/dt of -lap p, per density [1/s^2]; s = 0.2 e/dt^2 for the original scheme."""
        if fluid.scheme == wp.static(KOSHIZUKA_OKA):
            return real(ORIGINAL_SHARE) * e / (dt * dt)
        slack = real(DISORDER) * (fluid.spacing / fluid.radius) * (fluid.spacing / fluid.radius)
        e = wp.clamp(e - wp.clamp(e, real(0.0), slack), real(-LARGEST_ERROR), real(LARGEST_ERROR))
        return (e / fluid.relaxation_time - div) / dt

    @types.func(METHOD)
    def damping_of(uneven: vec, fluid: Constants) -> real:
        """k_i = DAMPING |gradient sum_j g x_ij/r_e^2|^2 [1/m^2], of the conservative scheme."""
        if fluid.scheme == wp.static(CONSERVATIVE):
            return real(DAMPING) * fluid.gradient * fluid.gradient * wp.dot(uneven, uneven)
        return real(0.0)

    @types.kernel(METHOD)
    def assemble(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        x: wp.array(dtype=vec),  # positions at which the pressure is evaluated [m], [n]
        u: wp.array(dtype=vec),  # predicted velocities, of walls their own [m/s], [n]
        a: wp.array(dtype=vec),  # accelerations of walls [m/s^2], [n]
        p: wp.array(dtype=wp.float64),  # pressures of the last step [Pa], [m]
        normal: wp.array(dtype=vec),  # normals into the walls beside particles [-], [m]
        depth: wp.array(dtype=real),  # distances from the faces of these walls, 0 without [m], [m]
        rest: wp.array(dtype=real),  # share by which the water is at rest [-], [1]
        # State out:
        n_out: wp.array(dtype=real),  # number densities [-], [m]
        density_scale_out: wp.array(dtype=real),  # density scales of the gradient [-], [m]
        first_out: wp.array(dtype=wp.int32),  # first entry of each row, [m]
        count_out: wp.array(dtype=wp.int32),  # number of entries of each row, [m]
        index_out: wp.array(dtype=wp.int32),  # column of each entry, [m room]
        value_out: wp.array(dtype=real),  # entries c_ij, with their sign turned [1/m^2], [m room]
        diagonal_out: wp.array(dtype=real),  # diagonal [1/m^2], [m]
        active_out: wp.array(dtype=wp.int32),  # 1 for each row that is solved, [m]
        rhs_out: wp.array(dtype=wp.float64),  # right-hand side [Pa/m^2], [m]
        surface_out: wp.array(dtype=wp.int32),  # 1 for particles of the free surface, else 0, [m]
        tilt_out: wp.array(dtype=vec),  # offsets of pair vectors to walls [m], [m]
        singular_out: wp.array(dtype=wp.int32),  # 0 if any particle is of the free surface, else untouched, [1]
    ):
        """The row of a fluid particle, sum_j c_ij (p_i - p_j) + (b_i + k_i) p_i, and its right-hand side."""
        k = wp.tid()
        i = k + fluid.walls
        h = real(dt[0])
        x_i = x[i]
        u_i = u[i]
        normal_i = normal[k]
        depth_i = depth[k]
        sums = DensitySums()
        velocities = VelocitySums()
        walls = WallSums()
        start = k * neighbours.index.shape[1]
        entries = wp.int32(0)
        diagonal = real(0.0)
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            x_ij = displacement(x_i, x[j], fluid.period)
            square = wp.dot(x_ij, x_ij)
            if square < fluid.radius * fluid.radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * fluid.spacing)
                w = weight(r, fluid.radius)
                c = fluid.laplacian * w
                m_ij = divergence_weight(x_ij, r, fluid)
                add_density_pair(sums, fluid, x_ij, r, w)
                if j < fluid.walls:
                    relative_gravity = fluid.gravity - a[j]
                    add_wall_pair(walls, c, x_ij, relative_gravity)
                    add_wall_velocity(velocities, m_ij, x_ij, u[j] + h * relative_gravity - u_i)
                else:
                    if depth_i > real(0.0):
                        k_j = j - fluid.walls
                        image = image_distance_squared(square, normal_i, normal[k_j], depth_i, depth[k_j])
                        extra = fluid.laplacian * weight(wp.sqrt(image), fluid.radius)
                        walls.lean += extra * x_ij
                        c += extra
                    add_fluid_velocity(velocities, m_ij, x_ij, u[j] - u_i)
                    index_out[start + entries] = j - fluid.walls
                    value_out[start + entries] = c
                    entries += 1
                    diagonal += c

        e = sums.n / fluid.number_density - real(1.0)
        lack = -e
        surface = is_free_surface(sums.n, sums.neighbours, fluid)
        beyond = real(0.0)
        if surface:
            # a particle without fluid about it, as a lost one, does not set the level of the others' pressure
            if entries > 0:
                singular_out[0] = 0
            beyond = beyond_surface(e, fluid)
            e = real(0.0)
        even = density_scale(sums.moment, fluid)
        if rest[0] > real(0.0):
            part = real(1.0) - rest[0]
            beyond = part * beyond + rest[0] * beyond_level(lack, sums.first, fluid)
            e = wp.max(e, real(0.0)) + part * wp.min(e, real(0.0))
            even = real(1.0) + part * (even - real(1.0))
        damping = (real(1.0) - rest[0]) * damping_of(sums.uneven, fluid)
        tilt = walls.lean / wp.max(walls.share, fluid.laplacian * real(1.0e-6))
        given = fluid.density * (walls.pressure - wp.dot(walls.pull, tilt))
        if not surface or fluid.scheme == wp.static(CONSERVATIVE):
            div = dilatation_rate(velocities, real(fluid.midpoint) * h, fluid.scheme, normal_i, depth_i)
            given += fluid.density * source(e, div, h, fluid)

        n_out[k] = sums.n
        density_scale_out[k] = even
        first_out[k] = start
        count_out[k] = entries
        diagonal_out[k] = diagonal + beyond + damping
        active_out[k] = 1
        rhs_out[k] = wp.float64(given) + wp.float64(damping) * p[k]
        surface_out[k] = wp.int32(surface)
        tilt_out[k] = tilt

    return SimpleNamespace(assemble=assemble)

"""The pressure Poisson equation: its rows, its right-hand side, and the free surface.

    lap p = rho (div u*)/dt - rho e/(tau dt),    div u = tr(C_i sum_j u_ij x_ij/r^3),    C_i^-1 = sum_j x_ij x_ij/r^3

The last term restores the number density, e = (n - n0)/n0, slowly, over tau = 3 sqrt(l0/g). From 0 to 0.1 l0^2/r_e^2 it
counts as none: that much particles in disorder have at the volume of a lattice, and water at rest would swell by it.

The divergence is exact for every linear velocity, however the particles lie. The rate of the number density, C_i = 1
(Khayyer & Gotoh 2009), is not: a lattice that is strained gets denser for it at a constant volume, and a drop that is
drawn out swells by a tenth. But it sees particles that pair, which only the conservative gradient drives apart by
itself: the other schemes keep it, and have no source at the free surface, where half of its pairs are missing.

The original method (Koshizuka & Oka 1996) has rho e/dt^2 alone. All of it mends the whole error in one step, by
velocities of about e l0/dt that stay: the shorter the steps, the faster they are, and the shorter the next step. That
runs away; a share of 0.2 does not, and errors still decay in some ten steps.

Walls are no unknowns: the pressure beyond a wall follows from the wall's acceleration a, p_j - p_i =
rho (g - a) . x_ij, which goes to the right-hand side; u* of a wall is the velocity that this gradient turns into the
wall's own. Along a flat wall the conservative scheme adds the water's mirror image (`warp_mps.fluid.mirror_planes`), in
which water at rest, whose pressure differs by rho (g - a) . x_ij, must not count a second time. With c the coefficients
of the pairs and `tilt_i` the sum of c x_ij over images, divided by the sum of c over the wall's particles, one of these
enters the right-hand side by rho (g - a) . (x_ij - tilt_i).

Conservative forces push a particle by 2 p_i sum_j c x_ij beyond what a gradient would, and the equation does not know.
In deep water that feeds back on the pressure of the next step and may grow. Half of the true operator never exceeds
-lap + k |sum_j c x_ij|^2 with k = 4, so that this term, on the change of p since the last step, makes the feedback
decay, and is gone where p is steady. `DAMPING` is larger, for tanks that are filled too full.

A particle is of the free surface if its number density and its number of neighbours are both low. What its sum of
pressures misses lies beyond the surface, where the pressure is taken to go on linearly through 0, which it has at the
surface itself, half a spacing above the uppermost particles: with the particle's depth s and M the sum of w times the
height above it of what is not there, that adds M/s to the row's diagonal. On a lattice

    M/s = n0 q (b1 + b2 q),   q = 1 - n/n0

with factors b1, b2 (`warp_mps.fluid.operator_constants`) that make a linear pressure exact in the two rows below the
surface; with n0 q (Nair & Tomar 2014) it would be 0 up to a spacing above it. There e, which is negative, does not
count.

References:
    Khayyer, A. and Gotoh, H., Coastal Engineering 56 (2009) 419.
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Nair, P. and Tomar, G., Computers & Fluids 102 (2014) 304.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.mirror_planes import mirror_plane_kernels
from warp_mps.fluid.schemes import CONSERVATIVE, CORRECTED, KOSHIZUKA_OKA

# the free surface: below this share of a full lattice's number density, and of its neighbours
SURFACE_DENSITY, SURFACE_NEIGHBOURS = 0.97, 0.85
# closest distance that the divergence sees, in spacings: what is closer is two particles that collide
CLOSEST = 0.05
# errors of the number density are mended no faster than this one: strained lattices and splashes show larger ones
LARGEST_ERROR = 0.02
# what particles in disorder have too much of number density at the volume of a lattice, times (r_e/l0)^2
DISORDER = 0.1
# share of the error of the number density that the original scheme mends in a step
ORIGINAL_SHARE = 0.2
# factor k of the term that damps changes of the pressure of unevenly surrounded particles
DAMPING = 16.0
# least determinant of a moment matrix, 1 on a lattice, that is inverted: below, the neighbours lie too one-sided
LEAST_DETERMINANT = 0.1
# how far a force is scaled for uneven particles
LARGEST_SCALE = 0.06


@functools.cache
def pressure_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `assemble`, `chunk_minima`, `set_level`."""
    real, vec, mat = types.real, types.vec, types.mat
    displacement, weight = displacement_function(types), weight_function(types)
    planes = mirror_plane_kernels(types)
    mirror_distance_squared, mirror_wall_strain = planes.mirror_distance_squared, planes.mirror_wall_strain

    @types.func(METHOD)
    def gradient_weight(scheme: wp.int32, r: real, radius: real) -> real:
        """The pair weight g/r_e^2 of the gradient; the original one for the original scheme."""
        if scheme > wp.static(CORRECTED):
            inverse = real(1.0) / r
            return weight(r, radius) * inverse * inverse
        # divided by what is the same for all pairs, so that a loop over pairs divides once
        s = real(1.0) - r * (real(1.0) / radius)
        return s * s * s * (real(1.0) / (radius * radius))

    @types.func(METHOD)
    def source(scheme: wp.int32, e: real, slack: real, div: real, dt: real, tau: real) -> real:
        """Source of -lap p, per density."""
        if scheme == wp.static(KOSHIZUKA_OKA):
            return real(ORIGINAL_SHARE) * e / (dt * dt)
        e = wp.clamp(e - wp.clamp(e, real(0.0), slack), real(-LARGEST_ERROR), real(LARGEST_ERROR))
        return (e / tau - div) / dt

    @types.kernel(METHOD)
    def assemble(
        # Model:
        walls: wp.int32,
        scheme: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        n0: real,
        full: real,
        divergence: real,
        laplacian: real,
        gradient: real,
        density: real,
        gravity: vec,
        first: real,
        second: real,
        tau: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        dt: wp.array(dtype=wp.float64),
        x: wp.array(dtype=vec),
        u: wp.array(dtype=vec),
        a: wp.array(dtype=vec),
        p: wp.array(dtype=wp.float64),
        normal: wp.array(dtype=vec),
        depth: wp.array(dtype=real),
        # Out:
        n_out: wp.array(dtype=real),
        scale_out: wp.array(dtype=real),
        first_out: wp.array(dtype=wp.int32),
        count_out: wp.array(dtype=wp.int32),
        index_out: wp.array(dtype=wp.int32),
        value_out: wp.array(dtype=real),
        diagonal_out: wp.array(dtype=real),
        active_out: wp.array(dtype=wp.int32),
        rhs_out: wp.array(dtype=wp.float64),
        surface_out: wp.array(dtype=wp.int32),
        tilt_out: wp.array(dtype=vec),
        singular_out: wp.array(dtype=wp.int32),
    ):
        """The row of a fluid particle, among the fluid particles alone."""
        k = wp.tid()
        i = k + walls
        h = real(dt[0])
        x_i = x[i]
        u_i = u[i]
        start = k * listed.shape[1]
        entries = wp.int32(0)
        near = wp.int32(0)
        n = real(0.0)
        diagonal = real(0.0)
        wall = real(0.0)
        pull = vec()
        share = real(0.0)
        lean = vec()
        normal_i = normal[k]
        depth_i = depth[k]
        moment = real(0.0)
        uneven = vec()
        moments = mat()
        strain = mat()
        wall_reach = vec()
        wall_moments = mat()
        wall_strain = mat()
        for m in range(count[i]):
            j = listed[i, m]
            x_ij = displacement(x_i, x[j], period)
            square = wp.dot(x_ij, x_ij)
            if square < radius * radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * spacing)
                inverse = real(1.0) / r
                arm = (divergence * inverse * inverse * inverse) * x_ij
                w = weight(r, radius)
                c = laplacian * w
                if j < walls:
                    wall += c * wp.dot(gravity - a[j], x_ij)
                    pull += c * (gravity - a[j])
                    share += c
                    wall_reach += arm
                    wall_moments += wp.outer(arm, x_ij)
                    wall_strain += wp.outer(u[j] + h * (gravity - a[j]) - u_i, arm)
                else:
                    if depth_i > real(0.0):
                        image = mirror_distance_squared(square, normal_i, normal[j - walls], depth_i, depth[j - walls])
                        extra = laplacian * weight(wp.sqrt(image), radius)
                        lean += extra * x_ij
                        c += extra
                    moments += wp.outer(arm, x_ij)
                    strain += wp.outer(u[j] - u_i, arm)
                    index_out[start + entries] = j - walls
                    value_out[start + entries] = c
                    entries += 1
                    diagonal += c
                n += w
                near += 1
                g = gradient_weight(scheme, r, radius)
                moment += g * r * r
                uneven += g * x_ij
        if depth_i > real(0.0):
            wall_strain = mirror_wall_strain(strain, moments, wall_strain, wall_moments, wall_reach, normal_i, depth_i)
        moments += wall_moments
        strain += wall_strain
        if scheme == wp.static(CONSERVATIVE) and wp.determinant(moments) > real(LEAST_DETERMINANT):
            strain = strain * wp.inverse(moments)
        e = n / n0 - real(1.0)
        surface = wp.int32(0)
        beyond = real(0.0)
        if n < real(SURFACE_DENSITY) * n0 and real(near) < real(SURFACE_NEIGHBOURS) * full:
            surface = 1
            # what has no fluid about it, as a lost particle, does not tell the others their pressure
            if entries > 0:
                singular_out[0] = 0
            beyond = -laplacian * n0 * e * (first - second * e)
            e = real(0.0)
        n_out[k] = n
        surface_out[k] = surface
        even = real(wp.static(types.dimension)) / wp.max(gradient * moment, real(1.0e-6))
        scale_out[k] = wp.clamp(even, real(1.0 - LARGEST_SCALE), real(1.0 + LARGEST_SCALE))
        first_out[k] = start
        count_out[k] = entries
        damping = real(0.0)
        if scheme == wp.static(CONSERVATIVE):
            damping = real(DAMPING) * gradient * gradient * wp.dot(uneven, uneven)
        diagonal_out[k] = diagonal + beyond + damping
        active_out[k] = 1
        tilt = lean / wp.max(share, laplacian * real(1.0e-6))
        tilt_out[k] = tilt
        given = density * (wall - wp.dot(pull, tilt))
        if surface == 0 or scheme == wp.static(CONSERVATIVE):
            slack = real(DISORDER) * (spacing / radius) * (spacing / radius)
            given += density * source(scheme, e, slack, wp.trace(strain), h, tau)
        rhs_out[k] = wp.float64(given) + wp.float64(damping) * p[k]

    @types.kernel(METHOD)
    def chunk_minima(chunk: wp.int32, p: wp.array(dtype=wp.float64), least_out: wp.array(dtype=wp.float64)):
        """Least pressure of each chunk of particles."""
        c = wp.tid()
        value = p[c * chunk]
        for k in range(c * chunk + 1, wp.min((c + 1) * chunk, p.shape[0])):
            value = wp.min(value, p[k])
        least_out[c] = value

    @types.kernel(METHOD)
    def set_level(
        clip: wp.int32,
        singular: wp.array(dtype=wp.int32),
        least: wp.array(dtype=wp.float64),
        # Out:
        p_out: wp.array(dtype=wp.float64),
    ):
        """Clip negative pressures; in a closed domain, where only differences count, make the least one 0 instead."""
        k = wp.tid()
        if singular[0] == 1:
            floor = least[0]
            for c in range(1, least.shape[0]):
                floor = wp.min(floor, least[c])
            p_out[k] = p_out[k] - floor
        elif clip == 1:
            p_out[k] = wp.max(p_out[k], wp.float64(0.0))

    return SimpleNamespace(
        gradient_weight=gradient_weight, assemble=assemble, chunk_minima=chunk_minima, set_level=set_level
    )

"""Number density and free surface.

    n_i = sum_j w_ij,   e_i = n_i/n0 - 1

A particle is of the free surface if its number density and its number of neighbours are both low. The sum of pressures
in its row lacks the part beyond the surface. There the pressure is taken to continue linearly through 0 at the surface
itself, half a spacing above the uppermost particles. With the particle's depth s, and M the sum of w times the height
above the particle over the missing part, this adds M/s to the row's diagonal. On a lattice

    M/s = n0 q (b1 + b2 q),   q = 1 - n/n0 = -e

with factors b1, b2 (`warp_mps.fluid.operator_constants`) that make a linear pressure exact in the two rows below the
surface. With n0 q (Nair & Tomar 2014) the pressure would be 0 up to a spacing above the surface. The error of the
number density, which is negative there, is not a source of the pressure.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Nair, P. and Tomar, G., Computers & Fluids 102 (2014) 304.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.gradient_weight import gradient_weight_function

# a particle is of the free surface below this share of a full lattice's number density and this one of its neighbours
SURFACE_DENSITY, SURFACE_NEIGHBOURS = 0.97, 0.85
# least distance of a pair [l0] in number density and divergence: particles that are closer collide
CLOSEST = 0.05
# largest change of the density scale that makes up for uneven particles
LARGEST_SCALE = 0.06


@functools.cache
def density_functions(types: NumericTypes) -> SimpleNamespace:
    """Struct `DensitySums`; functions `add_density_pair`, `is_free_surface`, `beyond_surface`, `density_scale`."""
    real, vec, d = types.real, types.vec, types.dimension
    Constants = fluid_constants_struct(types)
    gradient_weight = gradient_weight_function(types)

    @wp.struct
    class DensitySums:
        """Sums over the neighbours of a particle within r_e.

        Attributes:
            n: Number density sum_j w [-].
            neighbours: Number of neighbours [-].
            first: First moment sum_j w x_ij [m], 0 on a lattice.
            moment: Second moment of the gradient's weights sum_j g r^2/r_e^2 [-].
            uneven: First moment of the gradient's weights sum_j g x_ij/r_e^2 [1/m], 0 on a lattice.
        """

        n: real
        neighbours: wp.int32
        first: vec
        moment: real
        uneven: vec

    @types.func(METHOD)
    def add_density_pair(sums: wp.ref[DensitySums], fluid: Constants, x_ij: vec, r: real, w: real):
        """Add a neighbour at x_ij [m], at a distance r [m] with the weight w [-]."""
        g = gradient_weight(fluid.scheme, r, fluid.radius)
        sums.n += w
        sums.neighbours += 1
        sums.first += w * x_ij
        sums.moment += g * r * r
        sums.uneven += g * x_ij

    @types.func(METHOD)
    def is_free_surface(n: real, neighbours: wp.int32, fluid: Constants) -> wp.bool:
        """Whether n < 0.97 n0 and the particle has less than 0.85 of a full lattice's neighbours."""
        return (
            n < real(SURFACE_DENSITY) * fluid.number_density
            and real(neighbours) < real(SURFACE_NEIGHBOURS) * fluid.lattice_neighbours
        )

    @types.func(METHOD)
    def beyond_surface(e: real, fluid: Constants) -> real:
        """The part beyond the free surface on the row's diagonal, laplacian n0 q (b1 + b2 q) with q = -e [1/m^2]."""
        return -fluid.laplacian * fluid.number_density * e * (fluid.beyond_first - fluid.beyond_second * e)

    @types.func(METHOD)
    def density_scale(moment: real, fluid: Constants) -> real:
        """S = d / (gradient sum_j g r^2/r_e^2) [-], 1 on a lattice, bounded; see `warp_mps.fluid.gradient`."""
        even = real(wp.static(d)) / wp.max(fluid.gradient * moment, real(1.0e-6))
        return wp.clamp(even, real(1.0 - LARGEST_SCALE), real(1.0 + LARGEST_SCALE))

    return SimpleNamespace(
        DensitySums=DensitySums,
        add_density_pair=add_density_pair,
        is_free_surface=is_free_surface,
        beyond_surface=beyond_surface,
        density_scale=density_scale,
    )

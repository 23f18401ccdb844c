"""Particle shifting, which keeps particles evenly spaced.

Where pressures may be negative, or gradients are not repulsive, particles are shifted against the gradient of their
concentration (Lind, Xu, Stansby & Rogers 2012), away from the free surface. Where streams part, a lattice is drawn out
to rows with voids between them: shifts have to be as large as the strain of a step, or the voids grow.

References:
    Lind, S. J., Xu, R., Stansby, P. K. and Rogers, B. D., Journal of Computational Physics 231 (2012) 1499.
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

# closest distance that a shift sees [l0]
CLOSEST = 0.05
# shift per gradient of the concentration and way of the fastest particle in a step, and the largest shift [l0]
SHIFT, LARGEST_SHIFT = 10.0, 0.2


@functools.cache
def shifting_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `shift_particles`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement, weight = displacement_function(types), weight_function(types)

    @types.kernel(METHOD)
    def shift_particles(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        farthest: wp.array(dtype=wp.float64),  # displacement of the fastest particle in the step [m], [1]
        surface: wp.array(dtype=wp.int32),  # 1 for particles of the free surface, else 0, [m]
        # State out:
        shift_out: wp.array(dtype=vec),  # shifts [m], [m]
    ):
        """Shift of a fluid particle, dx_i = -SHIFT |u|_max dt sum_j (w/n0) x_ij/r, at most `LARGEST_SHIFT`.

        0 for particles of the free surface and for their neighbours (Lind, Xu, Stansby & Rogers 2012).
        """
        k = wp.tid()
        i = k + fluid.walls
        x_i = x[i]
        slope = vec()
        inside = surface[k] == 0
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            x_ij = displacement(x_i, x[j], fluid.period)
            square = wp.dot(x_ij, x_ij)
            if square < fluid.radius * fluid.radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * fluid.spacing)
                w = weight(r, fluid.radius) / r
                slope += (w / fluid.number_density) * x_ij
                if j >= fluid.walls:
                    inside = inside and surface[j - fluid.walls] == 0
        shift = vec()
        if inside:
            shift = (real(-SHIFT) * real(farthest[0])) * slope
            length = wp.length(shift)
            if length > real(LARGEST_SHIFT) * fluid.spacing:
                shift = (real(LARGEST_SHIFT) * fluid.spacing / length) * shift
        shift_out[k] = shift

    return SimpleNamespace(shift_particles=shift_particles)

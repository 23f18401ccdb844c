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

# closest distance that a shift sees [l0]
CLOSEST = 0.05
# shift per gradient of the concentration and way of the fastest particle in a step, and the largest shift [l0]
SHIFT, LARGEST_SHIFT = 10.0, 0.2


@functools.cache
def shifting_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `shift_particles`."""
    real, vec = types.real, types.vec
    displacement, weight = displacement_function(types), weight_function(types)

    @types.kernel(METHOD)
    def shift_particles(
        # Model:
        walls: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        n0: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        way: wp.array(dtype=wp.float64),
        surface: wp.array(dtype=wp.int32),
        # Out:
        shift_out: wp.array(dtype=vec),
    ):
        """Shift of a fluid particle."""
        k = wp.tid()
        i = k + walls
        x_i = x[i]
        slope = vec()
        inside = surface[k] == 0
        for m in range(count[i]):
            j = listed[i, m]
            x_ij = displacement(x_i, x[j], period)
            square = wp.dot(x_ij, x_ij)
            if square < radius * radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * spacing)
                w = weight(r, radius) / r
                slope += (w / n0) * x_ij
                if j >= walls:
                    inside = inside and surface[j - walls] == 0
        shift = vec()
        if inside:
            shift = (real(-SHIFT) * real(way[0])) * slope
            length = wp.length(shift)
            if length > real(LARGEST_SHIFT) * spacing:
                shift = (real(LARGEST_SHIFT) * spacing / length) * shift
        shift_out[k] = shift

    return SimpleNamespace(shift_particles=shift_particles)

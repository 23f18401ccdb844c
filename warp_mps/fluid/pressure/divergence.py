"""Divergence of the predicted velocity.

    div u = tr(G),   G = L C,   L = sum_j u_ij (x) m_ij,   C^-1 = sum_j x_ij (x) m_ij,   m_ij = divergence x_ij/r^3

It is exact for every linear velocity, however the particles lie. The rate of the number density, C = 1 (Khayyer & Gotoh
2009), is not: a lattice that is strained gets denser by it at a constant volume, and a drop that is drawn out swells by
a tenth. But that rate sees particles that pair, which only the conservative gradient drives apart by itself. The other
schemes keep it, and have no source at the free surface, where half of the pairs are missing.

The velocity of a wall particle is the one that its pressure gradient turns into the wall's own, u_j + dt (g - a_j). A
flat wall also continues the velocity along it; see `warp_mps.fluid.mirror_planes`.

A velocity that moves the particles on for a time h changes volumes by det(1 + h G), not by h tr(G): water that is free
of divergence where it starts gets denser by h |second invariant| where it is strained, and expands where it turns. So

    rate of dilatation = tr(G) + h (second invariant of the deviator of G),   -tr(G' G')/2 with G' = G - tr(G)/d 1

to second order in h, of the predicted velocity, whose deviator is that of the velocity at the end up to O(h). At
predicted positions h = 0.

References:
    Khayyer, A. and Gotoh, H., Coastal Engineering 56 (2009) 419.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.mirror_planes import mirror_plane_kernels
from warp_mps.fluid.schemes import CONSERVATIVE

# least determinant of a moment matrix, 1 on a lattice, that is inverted: below, the neighbours lie too one-sided
LEAST_DETERMINANT = 0.1


@functools.cache
def divergence_functions(types: NumericTypes) -> SimpleNamespace:
    """Struct `VelocitySums`; functions `divergence_weight`, `add_fluid_velocity`, `add_wall_velocity` and the rate."""
    real, vec, mat, d = types.real, types.vec, types.mat, types.dimension
    Constants = fluid_constants_struct(types)
    mirror_wall_strain = mirror_plane_kernels(types).mirror_wall_strain

    @wp.struct
    class VelocitySums:
        """Sums over the neighbours of a particle within r_e, apart over fluid and wall particles.

        Attributes:
            moments: sum_j m_ij (x) x_ij over fluid particles [-].
            strain: sum_j u_ij (x) m_ij over fluid particles [1/s].
            wall_reach: sum_j m_ij over wall particles [1/m].
            wall_moments: sum_j m_ij (x) x_ij over wall particles [-].
            wall_strain: sum_j u_ij (x) m_ij over wall particles [1/s].
        """

        moments: mat
        strain: mat
        wall_reach: vec
        wall_moments: mat
        wall_strain: mat

    @types.func(METHOD)
    def divergence_weight(x_ij: vec, r: real, fluid: Constants) -> vec:
        """m_ij = divergence x_ij/r^3 [1/m]."""
        inverse = real(1.0) / r
        return (fluid.divergence * inverse * inverse * inverse) * x_ij

    @types.func(METHOD)
    def add_fluid_velocity(sums: wp.ref[VelocitySums], m_ij: vec, x_ij: vec, u_ij: vec):
        """Add a fluid particle at x_ij [m] that moves at u_ij [m/s] relative to the particle."""
        sums.moments += wp.outer(m_ij, x_ij)
        sums.strain += wp.outer(u_ij, m_ij)

    @types.func(METHOD)
    def add_wall_velocity(sums: wp.ref[VelocitySums], m_ij: vec, x_ij: vec, u_ij: vec):
        """Add a wall particle at x_ij [m] that moves at u_ij [m/s] relative to the particle."""
        sums.wall_reach += m_ij
        sums.wall_moments += wp.outer(m_ij, x_ij)
        sums.wall_strain += wp.outer(u_ij, m_ij)

    @types.func(METHOD)
    def dilatation_rate(sums: VelocitySums, h: real, scheme: wp.int32, normal: vec, depth: real) -> real:
        """Rate of dilatation over a time h [1/s], with C = 1 but for the conservative scheme; see the module.

        Args:
            sums: Sums over the neighbours.
            h: Time that the velocity moves the particles for from here on [s].
            scheme: Discretization.
            normal: Normal into the wall whose face the particle is beside [-].
            depth: Distance from that face [m], 0 if there is none.
        """
        wall_strain = sums.wall_strain
        if depth > real(0.0):
            wall_strain = mirror_wall_strain(
                sums.strain, sums.moments, wall_strain, sums.wall_moments, sums.wall_reach, normal, depth
            )
        moments = sums.moments + sums.wall_moments
        strain = sums.strain + wall_strain
        if scheme == wp.static(CONSERVATIVE) and wp.determinant(moments) > real(LEAST_DETERMINANT):
            strain = strain * wp.inverse(moments)
        div = wp.trace(strain)
        deviator = strain - (div / real(wp.static(d))) * wp.identity(n=wp.static(d), dtype=real)
        return div - real(0.5) * h * wp.trace(deviator * deviator)

    return SimpleNamespace(
        VelocitySums=VelocitySums,
        divergence_weight=divergence_weight,
        add_fluid_velocity=add_fluid_velocity,
        add_wall_velocity=add_wall_velocity,
        dilatation_rate=dilatation_rate,
    )

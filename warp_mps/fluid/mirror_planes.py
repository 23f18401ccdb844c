"""The faces of walls, in which the water beside them is mirrored.

A wall's particles have neither a pressure nor a velocity along the wall. What they add to the sums of a fluid particle
is right across the wall, where the wall's acceleration says how the pressure goes on, but along it they add nothing:
in the row beside a wall a quarter of the divergence, the Laplacian and the pressure force along it is missing, and
water sets off along a floor with three quarters of its acceleration. Where the wall is flat as far as a particle sees
it, with its face at a distance s and the normal n into the wall, the conservative scheme makes up for it:

    Laplacian:   a neighbour j is also seen in the mirror, at sqrt(r^2 + 4 s_i s_j). The two add to the pair's
                 coefficient, which stays symmetric, for the pressure less that of water at rest beside this wall:
                 that one goes on beyond the wall by itself
    force:       the pressure goes on along the wall as it does in the water (`warp_mps.fluid.gradient`)
    divergence:  so does the velocity along the wall; that across is the wall's at its face, half a spacing before its
                 first particles

At corners, edges and gaps the face is not known, and nothing is added. Mirrored particles are those of e.g. Morris, Fox
and Zhu, made by the fluid's own pairs.

References:
    Morris, J. P., Fox, P. J. and Zhu, Y., Journal of Computational Physics 136 (1997) 214.
"""

import functools
import math
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.neighbour_search import neighbour_table_struct

# in spacings: how far a wall's particles may lie before its face, and the least distance from it that is believed
FLATNESS, LEAST_DEPTH = 0.3, 0.25
# share of what would be seen of an endless face that must be there, give or take a particle of a lattice: beside an
# edge the face is guessed wrong
FULLNESS = {2: 0.8, 3: 0.65}
# cosine of the angle of two faces that are taken for the same
SAME_FACE = 0.5
# how much more than a difference to the wall's particles one to its face may count
LARGEST_STRETCH = 3.0
# part of a lattice's spread along the wall that the water's own particles must have, to tell how it goes on
LEAST_SPREAD = 0.1


@functools.cache
def mirror_plane_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernel `find_mirror_planes`; functions `mirror_distance_squared`, `tangential_moment`, `mirror_wall_strain`."""
    real, vec, mat, d = types.real, types.vec, types.mat, types.dimension
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement = displacement_function(types)

    @types.func(METHOD)
    def mirror_distance_squared(square: real, normal_i: vec, normal_j: vec, depth_i: real, depth_j: real) -> real:
        """Square r^2 + 4 s_i s_j of the distance to the mirror image of a neighbour [m^2]; infinite if it has none."""
        if depth_j <= real(0.0) or wp.dot(normal_i, normal_j) < real(SAME_FACE):
            return real(wp.inf)
        return square + real(4.0) * depth_i * depth_j

    @types.func(METHOD)
    def tangential_moment(moments: mat, normal: vec) -> real:
        """Mean second moment along a face, (tr M - n . M n)/(d - 1)."""
        return (wp.trace(moments) - wp.dot(normal, moments * normal)) / real(wp.static(d - 1))

    @types.func(METHOD)
    def mirror_wall_strain(
        strain: mat, moments: mat, wall_strain: mat, wall_moments: mat, reach: vec, normal: vec, depth: real
    ) -> mat:
        """Sum of u_ij (x) m_ij over a flat wall: along it as over the fluid, across it with the wall's own at its face.

        Args:
            strain: Sum over the water's particles.
            moments: Their sum of m_ij (x) x_ij [-].
            wall_strain: Sum over the wall's particles.
            wall_moments: Their sum of m_ij (x) x_ij [-].
            reach: Their sum of m_ij [1/m].
            normal: Normal into the wall.
            depth: Distance from its face.
        """
        across = wp.outer(normal, normal)
        lever = wp.max(depth * wp.dot(reach, normal), real(1.0e-6) * wp.trace(wall_moments))
        stretch = wp.dot(normal, wall_moments * normal) / lever
        stretch = wp.clamp(stretch, real(1.0), real(LARGEST_STRETCH))
        result = wall_strain + (stretch - real(1.0)) * (across * wall_strain)
        own = tangential_moment(moments, normal)
        if own > real(LEAST_SPREAD):
            along = wp.identity(n=wp.static(d), dtype=real) - across
            result += (tangential_moment(wall_moments, normal) / own) * (along * strain * along) - along * wall_strain
        return result

    @types.kernel(METHOD)
    def find_mirror_planes(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        # State out:
        normal_out: wp.array(dtype=vec),  # normals into the walls beside fluid particles [-], [m]
        depth_out: wp.array(dtype=real),  # distances from the faces of these walls, 0 where not flat [m], [m]
    ):
        """Normal of the wall beside a fluid particle, and the distance from its face; 0 where it is not flat.

        n = sum_w (r_e - r) x_iw, normalized; the face lies half a spacing before the wall's closest particle along n.
        """
        k = wp.tid()
        i = k + fluid.walls
        x_i = x[i]
        total = vec()
        closest = vec()
        least = fluid.radius
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            if j < fluid.walls:
                x_ij = displacement(x_i, x[j], fluid.period)
                r = wp.length(x_ij)
                if r < fluid.radius:
                    total += (fluid.radius - r) * x_ij
                    if r < least:
                        least = r
                        closest = x_ij
        depth = real(0.0)
        normal = vec()
        if least < fluid.radius:
            normal = wp.normalize(total)
            face = wp.dot(closest, normal)
            depth = wp.max(face - real(0.5) * fluid.spacing, real(LEAST_DEPTH) * fluid.spacing)
            first = wp.int32(0)
            for m in range(neighbours.count[i]):
                j = neighbours.index[i, m]
                if j < fluid.walls:
                    x_ij = displacement(x_i, x[j], fluid.period)
                    if wp.length(x_ij) < fluid.radius:
                        above = wp.dot(x_ij, normal) - face
                        if above < -real(FLATNESS) * fluid.spacing:
                            depth = real(0.0)
                        elif above < real(0.5) * fluid.spacing:
                            first += 1
            # what of the face is within reach: a line, or a disc
            seen = real(2.0) * wp.sqrt(wp.max(fluid.radius * fluid.radius - face * face, real(0.0))) / fluid.spacing
            if wp.static(d) == 3:
                seen *= real(0.25 * math.pi) * seen
            # between two walls the one takes away the normal of the other
            if face < real(FLATNESS) * fluid.spacing or real(first) < real(wp.static(FULLNESS[d])) * seen:
                depth = real(0.0)
        normal_out[k] = normal
        depth_out[k] = depth

    return SimpleNamespace(
        find_mirror_planes=find_mirror_planes,
        mirror_distance_squared=mirror_distance_squared,
        tangential_moment=tangential_moment,
        mirror_wall_strain=mirror_wall_strain,
    )

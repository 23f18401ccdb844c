"""Collisions of fluid particles with each other and with walls.

Two particles closer than `COLLISION` that approach each other collide, which the pressure alone does not prevent in
violent flow (Koshizuka & Oka 1996). Collisions take energy, and are frequent in flows that shear; particles that shifts
or repulsive gradients keep apart only collide below `KEPT_APART`, but with walls, between whose particles they would
slip through.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.neighbour_search import neighbour_table_struct

# distances below which particles collide [l0], the second of what is kept apart otherwise; coefficient of restitution
COLLISION, KEPT_APART, RESTITUTION = 0.8, 0.5, 0.2


@functools.cache
def collision_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `collide` and `collide_walls`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    displacement = displacement_function(types)

    @types.func(METHOD)
    def collision_change(x_ij: vec, u_ij: vec, reach: real) -> vec:
        """Change of the velocity of i [m/s], (1 + e) min(u_ij . n, 0) n, as if j were fixed; 0 beyond the reach [m]."""
        square = wp.dot(x_ij, x_ij)
        if square >= reach * reach or square == real(0.0):
            return vec()
        r = wp.sqrt(square)
        approach = wp.min(wp.dot(u_ij, x_ij) / r, real(0.0))
        return (real(wp.static(1.0 + RESTITUTION)) * approach / r) * x_ij

    @types.func(METHOD)
    def pair_collision_distance(shift_i: vec, shift_j: vec, reach: real, spacing: real) -> real:
        """Distance below which two particles collide [m]: the reach, or less where both are shifted."""
        if wp.dot(shift_i, shift_i) * wp.dot(shift_j, shift_j) > real(0.0):
            return real(KEPT_APART) * spacing
        return reach

    @types.kernel(METHOD)
    def collide(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        collision_share: wp.array(dtype=real),  # shares of collisions with walls that the fluid takes [-], [w]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        shift: wp.array(dtype=vec),  # shifts [m], [m]
        # State out:
        du_out: wp.array(dtype=vec),  # changes of velocity [m/s], [m]
    ):
        """Change of a fluid particle's velocity by collisions, du_i = sum_j m_ij (1 + e) min(u_ij . n, 0) n.

        n = x_ij/r is the direction of the pair, e the coefficient of restitution; m_ij is 1/2 between fluid particles,
        and the fluid's share of a collision with a wall.
        """
        k = wp.tid()
        i = k + fluid.walls
        x_i = x[i]
        u_i = u[i]
        du = vec()
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            x_ij = displacement(x_i, x[j], fluid.period)
            if j < fluid.walls:
                du += collision_share[j] * collision_change(x_ij, u[j] - u_i, real(COLLISION) * fluid.spacing)
            else:
                du += real(0.5) * collision_change(
                    x_ij,
                    u[j] - u_i,
                    pair_collision_distance(shift[k], shift[j - fluid.walls], fluid.collision_distance, fluid.spacing),
                )
        du_out[k] = du

    @types.kernel(METHOD)
    def collide_walls(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        collision_share: wp.array(dtype=real),  # shares of collisions with walls that the fluid takes [-], [w]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State in and out:
        impulse: wp.array(dtype=vec64),  # impulses on walls [N s], in 2-D [N s/m], [w]
        work: wp.array(dtype=wp.float64),  # work of walls on the fluid [J], in 2-D [J/m], [w]
    ):
        """Add the impulses -m du of collisions on a wall particle, and the work of the wall."""
        j = wp.tid()
        total = vec()
        for m in range(neighbours.count[j]):
            i = neighbours.index[j, m]
            total += collision_change(
                displacement(x[i], x[j], fluid.period), u[j] - u[i], real(COLLISION) * fluid.spacing
            )
        gained = -wp.float64(real(fluid.mass)) * wp.float64(collision_share[j]) * vec64(total)
        impulse[j] = impulse[j] + gained
        work[j] = work[j] - wp.dot(gained, vec64(u[j]))

    return SimpleNamespace(collide=collide, collide_walls=collide_walls)

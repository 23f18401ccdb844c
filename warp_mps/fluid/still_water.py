"""Water at rest: what keeps it there.

The sums of the operators are balanced for water at rest only in the middle of a lattice, and the lattice itself is
unstable: under the pair weight (1 - r/r_e)^3 with r_e = 3.1 l0 a uniform pressure shears a square lattice and a
hexagonal one apart. Particles then go round for ever, at about 0.03 sqrt(g l0), and move what floats among them. While
no particle is faster than a quarter of that, the conservative scheme therefore takes other sums, by the share

    rest = clamp(2 - |u|_max / (SPEED sqrt(g l0)), 0, 1)

which is 0 in water that moves; flows so slow are below what the particles resolve. It is also 0 where particles are
closer than `CLOSEST`, for they are about to move apart, and where more is missing beside a particle than above it, as
at the face of a column that is about to fall.

    force:    the pair weight has the radius `RADIUS`. For 1.8 <= r_e/l0 <= 2.05 (in 3-D 2.0 to 2.1) every shear of a
              square (cubic) lattice is stable, and below 2 no pair reaches across a free surface that carries a force
              in water at rest: pairs of the pressure 0 halfway are all that is missing there
    walls:    what of them is above the water's level, p_w < 0, is dry and does not push, as there is no water that
              would push from the other side
    density:  the density scale is 1. A lack of particles beside the surface is no sink
    damping:  none, which would take the pressure of the first steps for one that changes, and let the water fall
    PPE:      the part beyond the surface on the row's diagonal is M/s with the true moment M of what is missing,
              M = sum_j w x_ij . g/|g| over water and walls, for walls fill a part of what is beyond. The mean height
              M/(n0 q) of what is missing gives the depth s, 0.5 and 1.5 l0 in the upper two rows, whatever the walls

The lattice is an elastic solid then, of a small shear modulus: it must not be there when water flows. A standing wave
of 20 particles per depth would lose four times as much.
"""

import functools
import math
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight as lattice_weight
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.gradient_weight import gradient_weight_function
from warp_mps.fluid.neighbour_search import neighbour_table_struct
from warp_mps.fluid.schemes import CONSERVATIVE

# radius of the force's pair weight in water at rest [l0]
RADIUS = 2.0
# speed of the fastest particle up to which water is at rest [sqrt(g l0)]; at twice that it is not
SPEED = 0.008
# distance below which particles are about to move apart [l0]
CLOSEST = 0.9
# moment of what is missing, per n0 l0, from which the particle is beside a free surface [-]; twice that at full share
LEAST_MOMENT = 0.02
# depths of a particle beside the surface [l0]
SHALLOWEST, DEEPEST = 0.5, 2.5


def missing_heights(dimension: int, reach: float) -> tuple[float, float]:
    """Mean heights M/(n0 q) [l0] of what is missing above the upper two rows of a lattice, the second over the first.

    Args:
        dimension: 2 or 3.
        reach: Effective radius [l0].
    """
    line = np.arange(-math.ceil(reach), math.ceil(reach) + 1)
    x = np.stack(np.meshgrid(*[line] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    r = np.linalg.norm(x, axis=1)
    near = (r > 0.0) & (r < reach)
    height, w = x[near, 1], lattice_weight(r[near], reach)
    means = [float(w[height >= row] @ height[height >= row] / w[height >= row].sum()) for row in (1, 2) if reach > row]
    return means[0], (means[1] if len(means) > 1 else means[0] + 1.0) - means[0]


@functools.cache
def still_water_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels that find the share of rest; functions `pair_weight`, `wet_share` and `beyond_level`."""
    real, vec = types.real, types.vec
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement, weight = displacement_function(types), weight_function(types)
    gradient_weight = gradient_weight_function(types)

    @types.func(METHOD)
    def pair_weight(fluid: Constants, rest: real, r: real) -> real:
        """Pair weight c of the pressure force [1/m^2], with its factor, at a distance r < r_e [m]."""
        c = fluid.gradient * gradient_weight(fluid.scheme, r, fluid.radius)
        if rest > real(0.0):
            c *= real(1.0) - rest
            if r < fluid.still_radius:
                c += rest * fluid.still_gradient * gradient_weight(wp.static(CONSERVATIVE), r, fluid.still_radius)
        return c

    @types.func(METHOD)
    def wet_share(fluid: Constants, rest: real, p_w: real) -> real:
        """Share of a wall particle's force that is not dry [-], of its pressure before it is clipped [Pa]."""
        if rest > real(0.0):
            return real(1.0) - rest * (real(1.0) - wp.clamp(real(0.5) + p_w / fluid.head, real(0.0), real(1.0)))
        return real(1.0)

    @types.func(METHOD)
    def beyond_level(q: real, first: vec, fluid: Constants) -> real:
        """The part beyond the level of water at rest on the row's diagonal, laplacian M/s [1/m^2].

        Args:
            q: What is missing of the number density, 1 - n/n0 [-].
            first: First moment sum_j w x_ij [m].
            fluid: Constants.
        """
        moment = wp.dot(first, fluid.gravity) / (wp.length(fluid.gravity) * fluid.number_density * fluid.spacing)
        share = wp.clamp(moment / real(LEAST_MOMENT) - real(1.0), real(0.0), real(1.0))
        if q <= real(0.0) or share == real(0.0):
            return real(0.0)
        s = real(SHALLOWEST) + (moment / q - fluid.missing_first) / fluid.missing_second
        s = wp.clamp(s, real(SHALLOWEST), real(DEEPEST))
        return share * fluid.laplacian * fluid.number_density * moment / s

    @types.kernel(METHOD)
    def chunk_speeds(
        # Model:
        fluid: Constants,
        chunk: wp.int32,
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        u: wp.array(dtype=vec),  # predicted velocities [m/s], [n]
        # State out:
        fastest_out: wp.array(dtype=real),  # largest squares of speeds [m^2/s^2], [m / chunk]
    ):
        """Largest |u* - dt g|^2 over each chunk of fluid particles: their speeds before gravity is added."""
        c = wp.tid()
        fall = real(dt[0]) * fluid.gravity
        value = real(0.0)
        for i in range(fluid.walls + c * chunk, wp.min(fluid.walls + (c + 1) * chunk, u.shape[0])):
            value = wp.max(value, wp.length_sq(u[i] - fall))
        fastest_out[c] = value

    @types.kernel(METHOD)
    def find_rest(
        # Model:
        fluid: Constants,
        # State in:
        fastest: wp.array(dtype=real),  # largest squares of speeds [m^2/s^2], [m / chunk]
        # State out:
        rest_out: wp.array(dtype=real),  # share by which the water is slow [-], [1]
        settled_out: wp.array(dtype=wp.int32),  # 1, [1]
    ):
        """Rest = clamp(2 - |u|_max / (SPEED sqrt(g l0)), 0, 1)."""
        value = real(0.0)
        for c in range(fastest.shape[0]):
            value = wp.max(value, fastest[c])
        slow = real(SPEED) * wp.sqrt(wp.length(fluid.gravity) * fluid.spacing)
        settled_out[0] = 1
        rest_out[0] = wp.clamp(real(2.0) - wp.sqrt(value) / slow, real(0.0), real(1.0))

    @types.kernel(METHOD)
    def find_unsettled(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        # State in:
        x: wp.array(dtype=vec),  # predicted positions [m], [n]
        rest: wp.array(dtype=real),  # share by which the water is slow [-], [1]
        # State out:
        settled_out: wp.array(dtype=wp.int32),  # 0 if a particle is about to move, else untouched, [1]
    ):
        """Whether a particle is too close to another one, or more is missing beside than above it."""
        if rest[0] == real(0.0):
            return
        i = wp.tid() + fluid.walls
        x_i = x[i]
        first = vec()
        for m in range(neighbours.count[i]):
            x_ij = displacement(x_i, x[neighbours.index[i, m]], fluid.period)
            r = wp.length(x_ij)
            if r < fluid.radius:
                if r < real(CLOSEST) * fluid.spacing:
                    settled_out[0] = 0
                    return
                first += weight(r, fluid.radius) * x_ij
        down = wp.normalize(fluid.gravity)
        above = wp.dot(first, down)
        beside = wp.length(first - above * down)
        if beside > above + real(LEAST_MOMENT) * fluid.number_density * fluid.spacing:
            settled_out[0] = 0

    @types.kernel(METHOD)
    def settle(
        # State in:
        settled: wp.array(dtype=wp.int32),  # 0 if a particle is about to move, else 1, [1]
        # State in and out:
        rest: wp.array(dtype=real),  # share by which the water is at rest [-], [1]
    ):
        """Share of 0 if a particle is about to move."""
        rest[0] = rest[0] * real(settled[0])

    return SimpleNamespace(
        find_unsettled=find_unsettled,
        settle=settle,
        pair_weight=pair_weight,
        wet_share=wet_share,
        beyond_level=beyond_level,
        chunk_speeds=chunk_speeds,
        find_rest=find_rest,
    )

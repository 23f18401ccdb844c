"""Kernels of the Robin term in the pressure Poisson equation.

The fluid sees a body as a wall of markers j (`warp_mps.coupling.interface`). The pressure Poisson equation sees a
marker by its acceleration a_j alone (`warp_mps.fluid.pressure.rows`): the right-hand side of a fluid particle i holds

    -rho sum_j a_j . k_ij,    k_ij = c (x_ij - tilt_i),  c = laplacian w(r_ij)

where tilt_i is 0 away from flat faces. How a_j answers to pressures p is approximated by a mobility b_j, acceleration
per force, and the forces

    F_j(p) = V sum_l p_l k_lj

of the fluid particles l about the marker, which in a half-space are those of `warp_mps.fluid.gradient`. With
a_j + b_j (F_j(p) - F0_j) in the place of a_j, F0 the linearization point, the matrix gets

    rho V sum_j b_j k_ij . sum_l k_lj p_l

which is symmetric and positive. Where F(p) = F0, to which the passes of a step converge, the term is gone: it is a
Robin condition at the interface (Badia, Nobile and Vergara 2008).

References:
    Badia, S., Nobile, F. and Vergara, C., Journal of Computational Physics 227 (2008) 7027.
"""

import functools
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_mps.core.linear.kernels import RESTART
from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid.pressure.density import CLOSEST

METHOD = "coupling"


@functools.cache
def robin_constants(types: NumericTypes) -> Any:
    """The struct of the constants of the Robin term."""
    real, vec = types.real, types.vec

    @wp.struct
    class RobinConstants:
        walls: wp.int32  # number of wall particles, of which the markers are the first
        markers: wp.int32  # number of markers e
        period: vec  # period along each axis [m], 0 where there is none
        radius: real  # effective radius r_e [m]
        spacing: real  # particle spacing l0 [m]
        laplacian: real  # factor of the Laplacian [1/m^2]
        density: real  # rho [kg/m^3]
        volume: real  # volume V of a fluid particle [m^d]

    return RobinConstants


@functools.cache
def robin_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `mark_wet`, `add_diagonal`, `approximate_forces`, `offset_accelerations`, `add_rhs` and `add_product`."""
    real, vec, constants_type = types.real, types.vec, robin_constants(types)
    displacement, weight = displacement_function(types), weight_function(types)

    @types.func(METHOD)
    def pair_vector(constants: constants_type, x_i: vec, x_j: vec, tilt: vec) -> vec:
        """k_ij = c (x_ij - tilt_i) of a fluid particle i and a marker j [1/m], 0 beyond the effective radius."""
        x_ij = displacement(x_i, x_j, constants.period)
        square = wp.dot(x_ij, x_ij)
        if square >= constants.radius * constants.radius:
            return vec()
        r = wp.max(wp.sqrt(square), real(CLOSEST) * constants.spacing)
        return (constants.laplacian * weight(r, constants.radius)) * (x_ij - tilt)

    @types.kernel(METHOD)
    def mark_wet(
        # Model:
        constants: constants_type,  # constants of the run
        listed: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        # Out:
        wet_out: wp.array(dtype=wp.int32),  # 1 for fluid particles near a marker, else 0, [m]
    ):
        """Whether a fluid particle has a marker among its neighbours: the others are passed over in every product."""
        k = wp.tid()
        i = k + constants.walls
        found = wp.int32(0)
        for m in range(count[i]):
            if listed[i, m] < constants.markers:
                found = 1
        wet_out[k] = found

    @types.kernel(METHOD)
    def add_diagonal(
        # Model:
        constants: constants_type,  # constants of the run
        listed: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        wet: wp.array(dtype=wp.int32),  # 1 for fluid particles near a marker, else 0, [m]
        mobility: wp.array(dtype=real),  # mobilities b_j [1/kg], [e]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        tilt: wp.array(dtype=vec),  # offsets of pair vectors to walls [m], [m]
        # State in and out:
        diagonal: wp.array(dtype=real),  # diagonal of the matrix [1/m^2], [m]
        # Out:
        added_out: wp.array(dtype=real),  # the Robin term's part of the diagonal [1/m^2], [m]
    ):
        """Add rho V sum_j b_j k_ij . k_ij to the diagonal of the matrix."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + constants.walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < constants.markers:
                k_ij = pair_vector(constants, x_i, x[j], tilt[k])
                total += mobility[j] * wp.dot(k_ij, k_ij)
        added_out[k] = constants.density * constants.volume * total
        diagonal[k] = diagonal[k] + constants.density * constants.volume * total

    @types.kernel(METHOD)
    def approximate_forces(
        # Model:
        constants: constants_type,  # constants of the run
        listed: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        # State in:
        control: wp.array(dtype=wp.int32),  # state of the solver, see `warp_mps.core.linear.kernels`
        x: wp.array(dtype=vec),  # positions [m], [n]
        tilt: wp.array(dtype=vec),  # offsets of pair vectors to walls [m], [m]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        direction: wp.array(dtype=wp.float64),  # search direction [Pa], [m]
        # Out:
        force_out: wp.array(dtype=vec),  # forces F_j on the markers [N], [e]
    ):
        """Forces F_j = V sum_l p_l k_lj: of pressures p in a fresh pass of the solver, else of a search direction."""
        j = wp.tid()
        x_j = x[j]
        total = vec()
        for m in range(count[j]):
            i = listed[j, m]
            value = direction[i - constants.walls]
            if control[RESTART] != 0:
                value = p[i - constants.walls]
            total += real(value) * pair_vector(constants, x[i], x_j, tilt[i - constants.walls])
        force_out[j] = constants.volume * total

    @types.kernel(METHOD)
    def offset_accelerations(
        # State in:
        mobility: wp.array(dtype=real),  # mobilities b_j [1/kg], [e]
        linearization: wp.array(dtype=vec),  # forces F0_j of the linearization point [N], [e]
        a: wp.array(dtype=vec),  # accelerations of the markers [m/s^2], [e]
        # Out:
        offset_out: wp.array(dtype=vec),  # b_j F0_j - a_j [m/s^2], [e]
    ):
        """b_j F0_j - a_j: the constant part of the accelerations a_j + b_j (F_j(p) - F0_j), with its sign turned."""
        j = wp.tid()
        offset_out[j] = mobility[j] * linearization[j] - a[j]

    @types.kernel(METHOD)
    def add_rhs(
        # Model:
        constants: constants_type,  # constants of the run
        listed: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        wet: wp.array(dtype=wp.int32),  # 1 for fluid particles near a marker, else 0, [m]
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        tilt: wp.array(dtype=vec),  # offsets of pair vectors to walls [m], [m]
        offset: wp.array(dtype=vec),  # b_j F0_j - a_j [m/s^2], [e]
        # State in and out:
        rhs: wp.array(dtype=wp.float64),  # right-hand side [Pa/m^2], [m]
    ):
        """Add rho sum_j k_ij . (b_j F0_j - a_j) to the right-hand side."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + constants.walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < constants.markers:
                total += wp.dot(pair_vector(constants, x_i, x[j], tilt[k]), offset[j])
        rhs[k] = rhs[k] + wp.float64(constants.density * total)

    @types.kernel(METHOD)
    def add_product(
        # Model:
        constants: constants_type,  # constants of the run
        listed: wp.array(dtype=wp.int32, ndim=2),  # neighbours of each particle, [n, room]
        count: wp.array(dtype=wp.int32),  # number of neighbours of each particle, [n]
        wet: wp.array(dtype=wp.int32),  # 1 for fluid particles near a marker, else 0, [m]
        added: wp.array(dtype=real),  # the Robin term's part of the diagonal [1/m^2], [m]
        mobility: wp.array(dtype=real),  # mobilities b_j [1/kg], [e]
        # State in:
        control: wp.array(dtype=wp.int32),  # state of the solver, see `warp_mps.core.linear.kernels`
        x: wp.array(dtype=vec),  # positions [m], [n]
        tilt: wp.array(dtype=vec),  # offsets of pair vectors to walls [m], [m]
        force: wp.array(dtype=vec),  # forces F_j on the markers [N], [e]
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        direction: wp.array(dtype=wp.float64),  # search direction [Pa], [m]
        # State in and out:
        q: wp.array(dtype=wp.float64),  # product with the matrix [Pa/m^2], [m]
    ):
        """Add rho sum_j b_j k_ij . F_j to a product with the matrix, less the part that its diagonal holds already."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + constants.walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < constants.markers:
                total += mobility[j] * wp.dot(pair_vector(constants, x_i, x[j], tilt[k]), force[j])
        value = direction[k]
        if control[RESTART] != 0:
            value = p[k]
        q[k] = q[k] + wp.float64(constants.density * total) - wp.float64(added[k]) * value

    return SimpleNamespace(
        mark_wet=mark_wet,
        add_diagonal=add_diagonal,
        approximate_forces=approximate_forces,
        offset_accelerations=offset_accelerations,
        add_rhs=add_rhs,
        add_product=add_product,
    )

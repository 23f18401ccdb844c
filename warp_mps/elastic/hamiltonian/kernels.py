"""The accurate elastic model: Hamiltonian MPS, with a control of its zero-energy modes.

Each particle has the deformation gradient that fits its neighbours best, in the displacement u = x - X,

    F_i = I + H_i,   H_i = [sum_j omega_ij u_ij (x) X_ij] A_i^-1,   A_i = sum_j omega_ij X_ij (x) X_ij

and the bodies the energy

    W = sum_i V_i psi(F_i) + sum_i sum_j 1/2 kappa_i omega_ij |e_ij|^2,   e_ij = x_ij - F_i X_ij = u_ij - H_i X_ij

whose second sum controls the zero-energy modes, which F_i does not contain (hourglass control, Kondo et al.). Its exact
gradient is a plain pair force, since sum_j omega_ij e_ij (x) X_ij = 0 when the same weights stand in both:

    f_i = sum_j omega_ij [(B_i + B_j) X_ij + (kappa_i + kappa_j) u_ij],   B_i = V_i P_i A_i^-1 - kappa_i H_i

Momentum and energy are kept, and angular momentum because W does not change under rotations. The weights are
omega_ij = w_ij / |X_ij|^2, with w of eq. 5, and kappa_i = control V_i 2 mu d / n_i, n_i = sum_j w_ij. References give
omega = w; w/|X|^2 was found to need fewer neighbours for the same accuracy. Where a neighbourhood is strongly
compressed, kappa_i grows (`warp_mps.elastic.hamiltonian.control`): kappa_i g(J_i) stands for it in both sums, and P_i
gets the derivative of g. Close to nu = 1/2 a part of lambda acts on the mean dilatation of the neighbours
(`warp_mps.elastic.hamiltonian.dilatation_kernels`); here, lambda is the rest.

References:
    Suzuki, Y. and Koshizuka, S., Int. J. Numer. Meth. Engng 74 (2008) 1344.
    Kondo, M., Suzuki, Y. and Koshizuka, S., Int. J. Numer. Meth. Engng 81 (2010) 1514.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes, numeric_types
from warp_mps.core.weights import weight_function
from warp_mps.elastic import METHOD
from warp_mps.elastic.hamiltonian.control import FIRM_BELOW, control_funcs
from warp_mps.elastic.hamiltonian.pair_sums import pair_sums
from warp_mps.elastic.materials.laws import law_funcs
from warp_mps.elastic.materials.volume import volume_funcs

# det(d A_i / n_i) of a particle is 1 inside a lattice, about 0.4 in a corner, and 0 in a row of particles: up to this,
# it has no gradient
FLAT = 1e-6


@functools.cache
def hamiltonian_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `shapes`, `stress`, `force` and `energy` of the model.

    `first` shifts the particle index, so that several threads can share the particles.
    """
    real, vec, mat = types.real, types.vec, types.mat
    laws = law_funcs(types)
    sums = pair_sums(types)
    pair_moment, pair_squares, pair_force = sums.moment, sums.squares, sums.force
    law_stress, energy_density = laws.stress, laws.energy_density
    volumes, control = volume_funcs(types), control_funcs(types)
    law_dilatation, cofactor = volumes.dilatation, volumes.cofactor
    growth, growth_slope = control.growth, control.growth_slope
    # the constants of a pair are formed in double precision whatever the run's: X_ij is a small difference
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    mps_weight = weight_function(numeric_types(types.dimension, "float64"))
    mat64 = wp.types.matrix(shape=(types.dimension, types.dimension), dtype=wp.float64)

    @types.kernel(METHOD)
    def shapes(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        reference: wp.array(dtype=vec64),  # reference positions X_i [m], [n]
        radius: wp.array(dtype=wp.float64),  # effective radii r_e [m], [n]
        # Model out:
        bond_out: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight_out: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape_out: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        density_out: wp.array(dtype=wp.float64),  # number densities n_i [-], [n]
        condition_out: wp.array(dtype=wp.float64),  # det(d A_i / n_i) [-], [n]
    ):
        """X_ij and omega_ij of every pair, A_i^-1 and n_i, and det(d A_i / n_i), which is 0 in a flat neighbourhood."""
        i = wp.tid()
        n = wp.float64(0.0)
        shape = mat64()
        for k in range(start[i], start[i + 1]):
            x = reference[index[k]] - reference[i]
            r = wp.length(x)
            w = mps_weight(r, radius[i])
            omega = w / (r * r)
            n += w
            shape += omega * wp.outer(x, x)
            bond_out[k] = vec(x)
            weight_out[k] = real(omega)
        d = wp.float64(wp.static(float(types.dimension)))
        condition = wp.float64(0.0)
        if n > wp.float64(0.0):
            condition = wp.determinant((d / n) * shape)
        if condition > wp.float64(FLAT):
            inverse_shape_out[i] = mat(wp.inverse(shape))
        density_out[i] = n
        condition_out[i] = condition

    @types.kernel(METHOD)
    def stress(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        kappa: wp.array(dtype=real),  # stiffness kappa_i of the hourglass control [N m], [n]
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        averaged: wp.int32,  # 1 where mean dilatations act, else 0
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        # State out:
        gradient_out: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        dilatation_out: wp.array(dtype=real),  # dilatations, if averaged [-], [n]
        resistance_out: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        pull_out: wp.array(dtype=mat),  # B_i, but for the mean dilatation [N m], [n]
        # State in and out:
        inverted: wp.array(dtype=wp.int32),  # 1 where J_i has been 0 or less, [n]
    ):
        """Displacement gradient H_i and B_i = V_i P_i A_i^-1 - kappa_i g(J_i) H_i; notes J_i <= 0."""
        i = first + wp.tid()
        total = pair_moment(i, start, index, bond, weight, u)
        inverse = inverse_shape[i]
        h = total * inverse
        gradient_out[i] = h
        if averaged == 1:
            dilatation_out[i] = law_dilatation(law[i], h)
        p = law_stress(law[i], h, lame[i], mu[i], plane_stress)
        resistance = kappa[i]
        f = h + wp.identity(n=wp.static(types.dimension), dtype=real)
        j = wp.determinant(f)
        if j < real(FIRM_BELOW):
            squares = pair_squares(i, start, index, bond, weight, u, h)
            p += (real(0.5) * kappa[i] / volume[i] * growth_slope(j) * squares) * cofactor(f)
            resistance = kappa[i] * growth(j)
            if j <= real(0.0):
                inverted[i] = 1
        resistance_out[i] = resistance
        pull_out[i] = volume[i] * p * inverse - resistance * h

    @types.kernel(METHOD)
    def force(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        resistance: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        pull: wp.array(dtype=mat),  # B_i [N m], [n]
        # State out:
        force_out: wp.array(dtype=vec),  # forces [N], [n]
    ):
        """Force f_i = sum_j omega_ij [(B_i + B_j) X_ij + (kappa_i g_i + kappa_j g_j) u_ij]."""
        i = first + wp.tid()
        force_out[i] = pair_force(i, start, index, bond, weight, resistance, u, pull)

    @types.kernel(METHOD)
    def energy(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        mean_lame: wp.array(dtype=real),  # part of lambda on the mean dilatation [Pa], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        resistance: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        mean: wp.array(dtype=real),  # mean dilatations [-], [n]
        # State out:
        energy_out: wp.array(dtype=real),  # energies [J], [n]
    ):
        """Elastic energy V_i psi(F_i) + sum_j 1/2 kappa_i g(J_i) omega_ij |e_ij|^2 of each particle."""
        i = wp.tid()
        h = gradient[i]
        squares = pair_squares(i, start, index, bond, weight, u, h)
        density = energy_density(law[i], h, lame[i], mu[i], plane_stress)
        density += real(0.5) * mean_lame[i] * mean[i] * mean[i]
        energy_out[i] = volume[i] * density + real(0.5) * resistance[i] * squares

    return SimpleNamespace(shapes=shapes, stress=stress, force=force, energy=energy)

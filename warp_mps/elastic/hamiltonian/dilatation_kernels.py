"""Mean dilatation: the cure of volumetric locking, by which thin bodies stay soft in bending as nu approaches 1/2.

Bending strains a body across itself as nu/(1 - nu) times along itself, with opposite signs on its two sides. A few
particles across have too few gradients for this: lambda, which resists every change of volume of every particle, then
holds them straight (four rows at nu = 0.49 bend by 0.80 of what they should). The part lambda' of lambda beyond 4 mu
therefore acts on the mean dilatation of the neighbours of a particle's own material, itself left out:

    W' = sum_i V_i lambda'_i / 2 theta_i^2,   theta_i = sum_j g_ij D_j

with the dilatation D of the law, tr(E) or ln J. The weights g_ij = r_i w_ij r_j are symmetric, and the factors r make
each of their sums 1 (the balance of Sinkhorn and Knopp). So a uniform deformation has the energy of the law and its
stress, at surfaces as well, no mean is larger than what it is a mean of, and the stress of the energy has the same
means: its force is the gradient of the energy with

    P_i += q_i dD_i/dF_i,   q_i = lambda'_i sum_j g_ij theta_j

The tangent has the same two sums over the changes of D and theta, and the damping over their rates.

References:
    Nagtegaal, J. C., Parks, D. M. and Rice, J. R., Comput. Meth. Appl. Mech. Engng 4 (1974) 153 (mean dilatation).
    Bonet, J. and Burton, A. J., Commun. Numer. Meth. Engng 14 (1998) 437 (the mean over a neighbourhood of nodes).
    Sinkhorn, R. and Knopp, P., Pacific J. Math. 21 (1967) 343.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.materials.volume import volume_funcs


@functools.cache
def dilatation_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `row_sums`, `largest_sums`, `average` and `gather`."""
    real, vec, mat = types.real, types.vec, types.mat
    dilatation_slope = volume_funcs(types).dilatation_slope

    @types.func(METHOD)
    def neighbour_sum(
        i: wp.int32,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        group: wp.array(dtype=wp.int32),
        scale: wp.array(dtype=real),
        values: wp.array(dtype=real),
    ) -> real:
        """Sum of r_i w_ij r_j times the values of the neighbours of the same group."""
        total = real(0.0)
        for k in range(start[i], start[i + 1]):
            j = index[k]
            if group[j] == group[i]:
                total += weight[k] * wp.dot(bond[k], bond[k]) * scale[j] * values[j]
        return scale[i] * total

    @types.kernel(METHOD)
    def row_sums(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        group: wp.array(dtype=wp.int32),  # number of the material and spacing; -1 where lambda' is 0, [n]
        scale: wp.array(dtype=real),  # factors r_i [-], [n]
        ones: wp.array(dtype=real),  # 1 for every particle, [n]
        # Model out:
        sum_out: wp.array(dtype=real),  # sums of g_ij over j [-], [n]
    ):
        """Sum of the weights g_ij of a particle; 0 where lambda' is 0."""
        i = wp.tid()
        total = real(0.0)
        if group[i] >= 0:
            total = neighbour_sum(i, start, index, bond, weight, group, scale, ones)
        sum_out[i] = total

    @types.kernel(METHOD)
    def largest_sums(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        group: wp.array(dtype=wp.int32),  # number of the material and spacing; -1 where lambda' is 0, [n]
        sums: wp.array(dtype=real),  # sums of g_ij over j [-], [n]
        # Model out:
        largest_out: wp.array(dtype=real),  # largest of the particle, its neighbours and 1 [-], [n]
    ):
        """Largest sum of weights in a neighbourhood, at least 1."""
        i = wp.tid()
        largest = wp.max(sums[i], real(1.0))
        for k in range(start[i], start[i + 1]):
            if group[index[k]] == group[i]:
                largest = wp.max(largest, sums[index[k]])
        largest_out[i] = largest

    @types.func(METHOD)
    def mean_of(
        i: wp.int32,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        group: wp.array(dtype=wp.int32),
        scale: wp.array(dtype=real),
        own: wp.array(dtype=real),
        values: wp.array(dtype=real),
    ) -> real:
        """Mean of values with the weights g_ij; 0 where lambda' is 0."""
        if group[i] < 0:
            return real(0.0)
        return own[i] * values[i] + neighbour_sum(i, start, index, bond, weight, group, scale, values)

    @types.kernel(METHOD)
    def average(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        group: wp.array(dtype=wp.int32),  # number of the material and spacing; -1 where lambda' is 0, [n]
        scale: wp.array(dtype=real),  # factors r_i [-], [n]
        own: wp.array(dtype=real),  # g_ii, what the other weights lack of 1 [-], [n]
        # State in:
        values: wp.array(dtype=real),  # dilatations D_i, or their changes or rates, [n]
        # State out:
        mean_out: wp.array(dtype=real),  # their means theta_i, [n]
    ):
        """Mean dilatation of each particle."""
        i = first + wp.tid()
        mean_out[i] = mean_of(i, start, index, bond, weight, group, scale, own, values)

    @types.kernel(METHOD)
    def gather(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        group: wp.array(dtype=wp.int32),  # number of the material and spacing; -1 where lambda' is 0, [n]
        scale: wp.array(dtype=real),  # factors r_i [-], [n]
        own: wp.array(dtype=real),  # g_ii, what the other weights lack of 1 [-], [n]
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        modulus: wp.array(dtype=real),  # lambda'_i [Pa], or tau lambda'_i [Pa s], [n]
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        mean: wp.array(dtype=real),  # means theta_i, [n]
        # State out:
        stress_out: wp.array(dtype=real),  # Kirchhoff stress q_i of the mean dilatations [Pa], [n]
        # State in and out:
        pull: wp.array(dtype=mat),  # B_i [N m], [n]
    ):
        """Kirchhoff stress q_i of the mean dilatations, and its share V_i q_i dD_i/dF_i A_i^-1 in B_i.

        A group has one lambda' and one V.
        """
        i = first + wp.tid()
        q = modulus[i] * mean_of(i, start, index, bond, weight, group, scale, own, mean)
        stress_out[i] = q
        if q != real(0.0):
            pull[i] = pull[i] + (volume[i] * q) * (dilatation_slope(law[i], gradient[i]) * inverse_shape[i])

    return SimpleNamespace(row_sums=row_sums, largest_sums=largest_sums, average=average, gather=gather)

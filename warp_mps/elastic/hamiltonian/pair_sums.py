"""The sums over pairs that Hamiltonian MPS is made of: a field's first moment, what is beyond it, and the pair forces.

With the notation of `warp_mps.elastic.hamiltonian.kernels`: the forces of the model, those of its damping and the
product of its tangent are the same sums, over displacements, velocities or a change of displacements.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD


@functools.cache
def pair_sums(types: NumericTypes) -> SimpleNamespace:
    """Device functions `moment`, `squares` and `force`."""
    real, vec, mat = types.real, types.vec, types.mat

    @types.func(METHOD)
    def moment(
        i: wp.int32,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        u: wp.array(dtype=vec),
    ) -> mat:
        """sum_j omega_ij u_ij (x) X_ij, which times A_i^-1 is the gradient of u."""
        u_i = u[i]
        total = mat()
        for k in range(start[i], start[i + 1]):
            total += wp.outer(weight[k] * (u[index[k]] - u_i), bond[k])
        return total

    @types.func(METHOD)
    def squares(
        i: wp.int32,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        u: wp.array(dtype=vec),
        h: mat,
    ) -> real:
        """sum_j omega_ij |e_ij|^2, e_ij = u_ij - H_i X_ij, what the gradient of u does not contain."""
        total = real(0.0)
        for k in range(start[i], start[i + 1]):
            e = u[index[k]] - u[i] - h * bond[k]
            total += weight[k] * wp.dot(e, e)
        return total

    @types.func(METHOD)
    def force(
        i: wp.int32,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        kappa: wp.array(dtype=real),
        u: wp.array(dtype=vec),
        pull: wp.array(dtype=mat),
    ) -> vec:
        """sum_j omega_ij [(B_i + B_j) X_ij + (kappa_i + kappa_j) u_ij]."""
        u_i = u[i]
        pull_i = pull[i]
        kappa_i = kappa[i]
        total = vec()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            total += weight[k] * ((pull_i + pull[j]) * bond[k] + (kappa_i + kappa[j]) * (u[j] - u_i))
        return total

    return SimpleNamespace(moment=moment, squares=squares, force=force)

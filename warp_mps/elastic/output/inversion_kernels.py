"""Kernels that find neighbourhoods which are turned inside out, where the equations no longer describe a body."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD


@functools.cache
def inversion_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `inversions` and `tangles`."""
    real, vec, mat = types.real, types.vec, types.mat

    @types.kernel(METHOD)
    def inversions(
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        # State in and out:
        inverted: wp.array(dtype=wp.int32),  # 1 where J_i is or has been 0 or less, [n]
    ):
        """Note J_i <= 0."""
        i = wp.tid()
        if wp.determinant(gradient[i] + wp.identity(n=wp.static(types.dimension), dtype=real)) <= real(0.0):
            inverted[i] = 1

    @types.kernel(METHOD)
    def tangles(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        # State in and out:
        tangled: wp.array(dtype=wp.int32),  # 1 where a neighbour is on the wrong side, [n]
    ):
        """Note a neighbour that lies opposite to where F_i has it, x_ij . F_i X_ij <= 0: the lattice has folded."""
        i = wp.tid()
        h = gradient[i]
        for k in range(start[i], start[i + 1]):
            wanted = bond[k] + h * bond[k]
            if wp.dot(bond[k] + (u[index[k]] - u[i]), wanted) <= real(0.0):
                tangled[i] = 1

    return SimpleNamespace(inversions=inversions, tangles=tangles)

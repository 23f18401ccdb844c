"""Displacements in space that is periodic along some of its axes."""

import functools
from typing import Any

import warp as wp

from warp_mps.core.types import NumericTypes


@functools.cache
def displacement_function(types: NumericTypes) -> Any:
    """The minimum-image displacement x_ij, as a Warp function `displacement(x_i, x_j, period)` of vectors."""
    real, vec, d = types.real, types.vec, types.dimension

    @types.func("periodic")
    def displacement(x_i: vec, x_j: vec, period: vec) -> vec:
        """x_ij = x_j - x_i [m], the shortest along axes with a period above 0: x_ij - L round(x_ij / L)."""
        x = x_j - x_i
        for axis in range(wp.static(d)):
            if period[axis] > real(0.0):
                x[axis] = x[axis] - period[axis] * wp.round(x[axis] / period[axis])
        return x

    return displacement

"""The pair weight of the pressure gradient.

    g(r) / r_e^2,   g = (1 - r/r_e)^3   (Wendland 1995), of the conservative and the corrected scheme
    w(r) / r^2,     w = r_e/r - 1       (Koshizuka & Oka 1996), of the original scheme

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Wendland, H., Advances in Computational Mathematics 4 (1995) 389.
"""

import functools
from typing import Any

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.schemes import CORRECTED


@functools.cache
def gradient_weight_function(types: NumericTypes) -> Any:
    """The pair weight of a scheme's gradient, as a Warp function `gradient_weight(scheme, r, radius)`."""
    real = types.real
    weight = weight_function(types)

    @types.func(METHOD)
    def gradient_weight(scheme: wp.int32, r: real, radius: real) -> real:
        """Pair weight [1/m^2] of the gradient at a distance r < r_e [m]."""
        if scheme > wp.static(CORRECTED):
            inverse = real(1.0) / r
            return weight(r, radius) * inverse * inverse
        # divided by what is the same for all pairs, so that a loop over pairs divides once
        s = real(1.0) - r * (real(1.0) / radius)
        return s * s * s * (real(1.0) / (radius * radius))

    return gradient_weight

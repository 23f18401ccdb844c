"""Measures of the change of volume of a displacement gradient H = F - I: J, its logarithm, and the laws' dilatations.

The dilatation of a law is what lambda acts on: tr(E) of the linear law, ln J of the neo-Hookean one.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD

# terms of the series: enough for double precision up to 0.3
TERMS = 12


@functools.cache
def volume_funcs(types: NumericTypes) -> SimpleNamespace:
    """Device functions.

    `volume_beyond_trace`, `log_defect`, `log_volume`; `dilatation`, its derivative `dilatation_slope` and the change of
    that, `dilatation_slope_change`; `cofactor` and `cofactor_change`.
    """
    real, mat = types.real, types.mat
    one, half, two = real(1.0), real(0.5), real(2.0)

    @types.func(METHOD)
    def volume_beyond_trace(h: mat) -> real:
        """det(I + H) - 1 - tr H, without the cancellation."""
        minors = half * (wp.trace(h) * wp.trace(h) - wp.trace(h * h))
        if wp.static(types.dimension == 2):
            return minors
        return minors + wp.determinant(h)

    @types.func(METHOD)
    def log_defect(x: real) -> real:
        """X - ln(1 + x), of second order in x: with z = x/(2 + x), x z - 2 (z^3/3 + z^5/5 + ...)."""
        if wp.abs(x) > real(0.3):
            return x - wp.log(one + x)
        z = x / (two + x)
        total = real(0.0)
        for k in range(TERMS):
            total = total * z * z + two / real(2 * TERMS + 1 - 2 * k)
        return z * (x - z * z * total)

    @types.func(METHOD)
    def log_volume(h: mat) -> real:
        """Logarithm of J."""
        growth = wp.trace(h) + volume_beyond_trace(h)
        return growth - log_defect(growth)

    @types.func(METHOD)
    def dilatation(law: wp.int32, h: mat) -> real:
        """tr(E) of the linear law, ln J of the other."""
        if law == 0:
            return wp.trace(h) + half * wp.ddot(h, h)
        return log_volume(h)

    @types.func(METHOD)
    def dilatation_slope(law: wp.int32, h: mat) -> mat:
        """Derivative of the dilatation by F: F of the linear law, F^-T of the other."""
        f = h + wp.identity(n=wp.static(types.dimension), dtype=real)
        if law == 0:
            return f
        return wp.transpose(wp.inverse(f))

    @types.func(METHOD)
    def dilatation_slope_change(law: wp.int32, h: mat, change: mat) -> mat:
        """Change of that derivative along a change dH of H: dH, and -F^-T dH^T F^-T."""
        if law == 0:
            return change
        g = dilatation_slope(law, h)
        return -(g * wp.transpose(change) * g)

    @types.func(METHOD)
    def polar_cofactor(f: mat, g: mat) -> mat:
        """Bilinear form whose values for f = g are twice the cofactor of a 3 x 3 matrix."""
        minors = mat()
        for row in range(wp.static(types.dimension)):
            for column in range(wp.static(types.dimension)):
                r, s = (row + 1) % 3, (row + 2) % 3
                c, e = (column + 1) % 3, (column + 2) % 3
                minors[row, column] = f[r, c] * g[s, e] - f[r, e] * g[s, c] + g[r, c] * f[s, e] - g[r, e] * f[s, c]
        return minors

    @types.func(METHOD)
    def cofactor(f: mat) -> mat:
        """Derivative of J by F, which is J F^-T and finite where J is 0."""
        if wp.static(types.dimension == 2):
            return wp.trace(f) * wp.identity(n=wp.static(types.dimension), dtype=real) - wp.transpose(f)
        return half * polar_cofactor(f, f)

    @types.func(METHOD)
    def cofactor_change(f: mat, change: mat) -> mat:
        """Derivative of the cofactor along a change of F; the cofactor is linear in 2-D, quadratic in 3-D."""
        if wp.static(types.dimension == 2):
            return cofactor(change)
        return polar_cofactor(f, change)

    made = (
        *(volume_beyond_trace, log_defect, log_volume),
        *(dilatation, dilatation_slope, dilatation_slope_change, cofactor, cofactor_change),
    )
    return SimpleNamespace(**{func.func.__name__: func for func in made})

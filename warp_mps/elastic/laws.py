"""Constitutive laws: the first Piola-Kirchhoff stress and the energy of a displacement gradient.

With H = F - I, so that small strains keep their digits; E = (H + H^T + H^T H)/2, C = F^T F, J = det F.

- ``st_venant_kirchhoff``: W = mu E:E + lambda/2 tr(E)^2, P = F S, S = 2 mu E + lambda tr(E) I. Linear in E: the law
  that particle benchmarks use. It softens in strong compression.
- ``neo_hookean``: W = mu/2 (tr C - d - 2 ln J) + lambda/2 (ln J)^2, P = (mu (F F^T - I) + lambda ln J I) F^-T. For
  strains of some tens of per cent and more.

In plane stress lambda is that of eq. 3 for the first law, which makes it the plane-stress law of the same material. The
neo-Hookean law finds the stretch across the plane that leaves no stress there, with the material's own lambda.

References:
    Bonet, J. and Wood, R. D., Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., sections 6.4.2-6.4.3.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit

METHOD = "elastic"
# Newton steps for the stretch across the plane; the equation is nearly linear in its logarithm
NEWTON_STEPS = 6


@functools.cache
def law_funcs(kit: Kit) -> SimpleNamespace:
    """Device functions `stress` and `energy_density`, which switch between the laws by number."""
    real, mat = kit.real, kit.mat
    one, half, two = real(1.0), real(0.5), real(2.0)

    @kit.func(METHOD)
    def volume_ratio_less_one(h: mat) -> real:
        """det(I + H) - 1, without the cancellation."""
        minors = half * (wp.trace(h) * wp.trace(h) - wp.trace(h * h))
        if wp.static(kit.dimension == 2):
            return wp.trace(h) + minors
        return wp.trace(h) + minors + wp.determinant(h)

    @kit.func(METHOD)
    def log_one_plus(x: real) -> real:
        """ln(1 + x), by its series where the sum would lose the digits of x."""
        if wp.abs(x) < real(1.0e-3):
            return x * (one - x * (half - x * (real(1.0 / 3.0) - x * (real(0.25) - x * real(0.2)))))
        return wp.log(one + x)

    @kit.func(METHOD)
    def across(log_j: real, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Logarithm of the stretch across the plane: mu (exp(2 s) - 1) + lambda (ln J + s) = 0; 0 in plane strain."""
        s = real(0.0)
        if plane_stress == 1:
            for _ in range(NEWTON_STEPS):
                grown = wp.exp(two * s)
                s -= (mu * (grown - one) + lame * (log_j + s)) / (two * mu * grown + lame)
        return s

    @kit.func(METHOD)
    def stress(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> mat:
        """First Piola-Kirchhoff stress P of H."""
        f = h + wp.identity(n=wp.static(kit.dimension), dtype=real)
        if law == 0:
            e = half * (h + wp.transpose(h) + wp.transpose(h) * h)
            s = two * mu * e + lame * wp.trace(e) * wp.identity(n=wp.static(kit.dimension), dtype=real)
            return f * s
        log_j = log_one_plus(volume_ratio_less_one(h))
        log_j += across(log_j, lame, mu, plane_stress)
        left = mu * (h + wp.transpose(h) + h * wp.transpose(h))
        left += lame * log_j * wp.identity(n=wp.static(kit.dimension), dtype=real)
        return left * wp.transpose(wp.inverse(f))

    @kit.func(METHOD)
    def energy_density(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Energy per reference volume of H."""
        e = half * (h + wp.transpose(h) + wp.transpose(h) * h)
        if law == 0:
            return mu * wp.ddot(e, e) + half * lame * wp.trace(e) * wp.trace(e)
        log_j = log_one_plus(volume_ratio_less_one(h))
        s = across(log_j, lame, mu, plane_stress)
        # tr C - d - 2 ln J, with the stretch across the plane; the differences of small numbers are formed first
        strain = two * (wp.trace(e) - log_j) + (wp.exp(two * s) - one - two * s)
        return half * mu * strain + half * lame * (log_j + s) * (log_j + s)

    return SimpleNamespace(stress=stress, energy_density=energy_density)

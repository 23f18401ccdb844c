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

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.materials.volume import TERMS, volume_funcs

# Newton steps for the stretch across the plane; the equation is nearly linear in its logarithm
NEWTON_STEPS = 6


@functools.cache
def law_funcs(types: NumericTypes) -> SimpleNamespace:
    """Device functions that switch laws by number.

    `stress`, `stress_change`, `energy_density`, `stress_across` and `strain_across`.
    """
    real, mat = types.real, types.mat
    one, half, two = real(1.0), real(0.5), real(2.0)
    volume = volume_funcs(types)
    volume_beyond_trace, log_defect, log_volume = volume.volume_beyond_trace, volume.log_defect, volume.log_volume

    @types.func(METHOD)
    def exp_excess(x: real) -> real:
        """exp(x) - 1 - x, of second order in x: x^2/2 (1 + x/3 (1 + x/4 (...)))."""
        if wp.abs(x) > real(0.3):
            return wp.exp(x) - one - x
        total = one
        for k in range(TERMS):
            total = one + x * total / real(TERMS + 2 - k)
        return half * x * x * total

    @types.func(METHOD)
    def across(log_j: real, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Logarithm of the stretch across the plane: mu (exp(2 s) - 1) + lambda (ln J + s) = 0; 0 in plane strain."""
        s = real(0.0)
        if plane_stress == 1:
            for _ in range(NEWTON_STEPS):
                grown = two * s + exp_excess(two * s)
                s -= (mu * grown + lame * (log_j + s)) / (two * mu * (one + grown) + lame)
        return s

    @types.func(METHOD)
    def stress(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> mat:
        """First Piola-Kirchhoff stress P of H."""
        f = h + wp.identity(n=wp.static(types.dimension), dtype=real)
        if law == 0:
            e = half * (h + wp.transpose(h) + wp.transpose(h) * h)
            s = two * mu * e + lame * wp.trace(e) * wp.identity(n=wp.static(types.dimension), dtype=real)
            return f * s
        log_j = log_volume(h)
        log_j += across(log_j, lame, mu, plane_stress)
        left = mu * (h + wp.transpose(h) + h * wp.transpose(h))
        left += lame * log_j * wp.identity(n=wp.static(types.dimension), dtype=real)
        return left * wp.transpose(wp.inverse(f))

    @types.func(METHOD)
    def stress_change(law: wp.int32, h: mat, change: mat, lame: real, mu: real, plane_stress: wp.int32) -> mat:
        """Derivative of P along a change dH of H.

        Of the linear law dP = dH S + F dS. Of the other, with G = F^-T and L the rate of lambda ln J with ln J,
        dP = mu dH + (mu - lambda ln J) G dH^T G + L (G : dH) G.
        """
        f = h + wp.identity(n=wp.static(types.dimension), dtype=real)
        if law == 0:
            e = half * (h + wp.transpose(h) + wp.transpose(h) * h)
            s = two * mu * e + lame * wp.trace(e) * wp.identity(n=wp.static(types.dimension), dtype=real)
            de = half * (wp.transpose(f) * change + wp.transpose(change) * f)
            ds = two * mu * de + lame * wp.trace(de) * wp.identity(n=wp.static(types.dimension), dtype=real)
            return change * s + f * ds
        log_j = log_volume(h)
        s_across = across(log_j, lame, mu, plane_stress)
        rate = lame
        if plane_stress == 1:
            # the stretch across the plane gives way: d(ln J + s) / d ln J
            across_rate = two * mu * (one + two * s_across + exp_excess(two * s_across))
            rate = lame * across_rate / (across_rate + lame)
        g = wp.transpose(wp.inverse(f))
        turned = (mu - lame * (log_j + s_across)) * (g * wp.transpose(change) * g)
        return mu * change + turned + rate * wp.ddot(g, change) * g

    @types.func(METHOD)
    def energy_density(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Energy per reference volume of H."""
        e = half * (h + wp.transpose(h) + wp.transpose(h) * h)
        if law == 0:
            return mu * wp.ddot(e, e) + half * lame * wp.trace(e) * wp.trace(e)
        # tr C - d - 2 ln J, with the stretch across the plane: the terms of first order in C - I cancel
        c = two * e
        beyond = volume_beyond_trace(c)
        defect = log_defect(wp.trace(c) + beyond)
        log_j = half * (wp.trace(c) + beyond - defect)
        s = across(log_j, lame, mu, plane_stress)
        strain = defect - beyond + exp_excess(two * s)
        return half * mu * strain + half * lame * (log_j + s) * (log_j + s)

    @types.func(METHOD)
    def stress_across(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Kirchhoff stress J sigma across the plane."""
        if plane_stress == 1:
            return real(0.0)
        if law == 0:
            return lame * (wp.trace(h) + half * wp.ddot(h, h))
        return lame * log_volume(h)

    @types.func(METHOD)
    def strain_across(law: wp.int32, h: mat, lame: real, mu: real, plane_stress: wp.int32) -> real:
        """Green-Lagrange strain across the plane; of the linear law -lambda/(2 mu) tr(E), lambda that of eq. 3."""
        if plane_stress == 0:
            return real(0.0)
        if law == 0:
            return -lame / (two * mu) * (wp.trace(h) + half * wp.ddot(h, h))
        s = across(log_volume(h), lame, mu, plane_stress)
        return s + half * exp_excess(two * s)

    return SimpleNamespace(
        stress=stress,
        stress_change=stress_change,
        energy_density=energy_density,
        stress_across=stress_across,
        strain_across=strain_across,
    )

"""The stiffness of the hourglass control: how it depends on the material, and how it grows in compression.

The control resists what the gradients do not contain with kappa_i = control c V_i 2 mu d / n_i. Two things that the
references leave out:

- Bending curves a body across itself the more, the closer nu is to 1/2, and the control resists that curvature. It is
  weaker, c = 1 - 0.22 (1 - 4 mu / lambda)^2, where lambda > 4 mu. Then plates of three particles and more bend as they
  should, whatever nu is (measured: 0.97 to 1.01 of the deflection); with c = 1 three rows give 0.93 at nu = 0.499.
- At a strongly compressed surface short wrinkles lose their stiffness, and the lattice folds where F_i still looks
  sound. The control grows there as the volume falls, kappa_i g(J_i) with

    g(J) = 1 + GROWTH (FIRM_BELOW - J)^3 where J < FIRM_BELOW, else 1

  in the energy, so that the force stays its gradient: the derivative of g adds kappa_i/2 g' sum_j omega_ij |e_ij|^2
  J F^-T to the stress.
"""

import functools
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD

# J below which the control grows, and how fast
FIRM_BELOW, GROWTH = 0.9, 30.0
# how much weaker the control is in an incompressible material
WEAKENING = 0.22


def control_share(mean_lame: np.ndarray, lame: np.ndarray) -> np.ndarray:
    """Factor c of the control [-], from the part of lambda beyond 4 mu [Pa] and lambda [Pa]."""
    return 1.0 - WEAKENING * (mean_lame / np.where(mean_lame > 0.0, lame, 1.0)) ** 2


@functools.cache
def control_funcs(types: NumericTypes) -> SimpleNamespace:
    """Device functions `growth`, g(J), and its derivatives `growth_slope` and `growth_curvature`."""
    real = types.real
    one, firm, rate = real(1.0), real(FIRM_BELOW), real(GROWTH)

    @types.func(METHOD)
    def growth(j: real) -> real:
        """g(J)."""
        fall = wp.max(firm - j, real(0.0))
        return one + rate * fall * fall * fall

    @types.func(METHOD)
    def growth_slope(j: real) -> real:
        """g'(J)."""
        fall = wp.max(firm - j, real(0.0))
        return -real(3.0) * rate * fall * fall

    @types.func(METHOD)
    def growth_curvature(j: real) -> real:
        """g''(J)."""
        return real(6.0) * rate * wp.max(firm - j, real(0.0))

    return SimpleNamespace(growth=growth, growth_slope=growth_slope, growth_curvature=growth_curvature)

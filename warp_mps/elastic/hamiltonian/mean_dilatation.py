"""The constants of the mean dilatation for a given set of particles, and its launches."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.dilatation_kernels import dilatation_kernels

# iterations of the balance: more change no deflection by a thousandth
BALANCING = 20


class MeanDilatation:
    """The part of lambda that acts on the mean dilatations of neighbourhoods.

    Attributes:
        lame: That part, lambda'_i [Pa], shape [n].
        acts: Whether it is other than 0 anywhere.
        dilatation: Dilatations D_i [-], shape [n].
        mean: Their means theta_i [-], shape [n]; 0 where lambda'_i is 0.
        stress: Kirchhoff stress q_i of the mean dilatations [Pa], shape [n].

    Args:
        lame: lambda'_i by material and plane [Pa], shape [n].
        groups: Number of the material and spacing of each particle, shape [n].
        pairs: Start and index of the pairs, their vectors and weights; A_i^-1 and volume of the particles.
        law: Law of each particle, shape [n].
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self,
        lame: np.ndarray,
        groups: np.ndarray,
        pairs: list[wp.array],
        law: wp.array,
        *,
        types: NumericTypes,
        device: Any,
    ) -> None:
        self._kernels, self._device, n = dilatation_kernels(types), device, len(lame)
        self._pairs, self._law = pairs, law
        self._group = wp.array(np.where(lame > 0.0, groups, -1), dtype=wp.int32, device=device)
        self.acts = bool(lame.any())
        self.lame, self._own, self._scale = (
            wp.array(values, dtype=types.real, device=device) for values in (lame, np.ones(n), np.ones(n))
        )
        if self.acts:
            self._balance(n)
        self.dilatation, self.mean, self.stress = (wp.zeros(n, dtype=types.real, device=device) for _ in range(3))

    def average(self, values: wp.array, mean_out: wp.array, first: int, count: int) -> None:
        """Launch the means of values of the neighbours."""
        inputs = [first, *self._pairs[:4], self._group, self._scale, self._own, values]
        self._launch(self._kernels.average, count, inputs, [mean_out])

    def gather(
        self,
        gradient: wp.array,
        mean: wp.array,
        stress_out: wp.array,
        pull: wp.array,
        first: int,
        count: int,
        *,
        modulus: wp.array | None = None,
        law: wp.array | None = None,
    ) -> None:
        """Launch the stress of mean dilatations, and add it to B_i.

        Args:
            gradient: Displacement gradients H_i [-], shape [n, d, d].
            mean: Mean dilatations, or their changes or rates, shape [n].
            stress_out: Kirchhoff stresses q_i [Pa], shape [n].
            pull: B_i [N m], shape [n, d, d].
            first: First particle.
            count: Number of particles.
            modulus: lambda'_i, if not that of the elasticity.
            law: Law of each particle, if not the material's.
        """
        laws = self._law if law is None else law
        constants = [*self._pairs, self._group, self._scale, self._own, laws]
        constants.append(self.lame if modulus is None else modulus)
        self._launch(self._kernels.gather, count, [first, *constants, gradient, mean], [stress_out, pull])

    def _balance(self, n: int) -> None:
        """Factors r_i with which the weights of every particle add up to 1; its own weight is what they lack of it.

        A particle without neighbours of its kind keeps its lambda. Where no factors exist, as in a chain of an odd
        number of particles, the sums of a neighbourhood are reduced to 1 at most.
        """
        ones, sums, largest = (wp.full_like(self._scale, 1.0) for _ in range(3))
        factors = np.ones(n)

        def row_sums() -> np.ndarray:
            self._scale.assign(factors)
            self._launch(self._kernels.row_sums, n, [*self._pairs[:4], self._group, self._scale, ones], [sums])
            return sums.numpy().astype(float)

        for _ in range(BALANCING):
            found = row_sums()
            factors /= np.sqrt(np.where(found > 0.0, found, 1.0))
        row_sums()
        self._launch(self._kernels.largest_sums, n, [*self._pairs[:2], self._group, sums], [largest])
        factors /= np.sqrt(largest.numpy())
        self._own.assign(1.0 - row_sums())

    def _launch(self, kernel: Any, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, count, inputs, outputs, device=self._device)

"""The tangent of a Hamiltonian model as an operator of the linear solver, and its blocks, which precondition it."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import Operator
from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.tangent_kernels import tangent_kernels


class Tangent:
    """K + m a among the free axes of a model's particles, at the last evaluation of the model's stresses.

    Attributes:
        operator: The tangent for `warp_mps.core.linear.conjugate_gradient.ConjugateGradient`, over vectors of
            n d values.
        block: Its diagonal blocks, float64, shape [n, d, d].

    Args:
        model: The model.
        u: Displacements of its state [m], vec [n].
        mass: Masses [kg], shape [n].
        held: Whether each axis of each particle is held, shape [n, d].
        inertia: The factor a of the masses [1/s^2], float64, shape [1]; it may change between solves.
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self,
        model: HamiltonianModel,
        u: wp.array,
        mass: wp.array,
        held: np.ndarray,
        inertia: wp.array,
        *,
        types: NumericTypes,
        device: Any,
    ) -> None:
        self._kernels, self._model, self._device = tangent_kernels(types), model, device
        self._u, self._mass, self._inertia = u, mass, inertia
        self._n, d = held.shape
        self._vec64 = wp.types.vector(length=d, dtype=wp.float64)
        mat64 = wp.types.matrix(shape=(d, d), dtype=wp.float64)
        self._free = wp.array(~held, dtype=types.vec, device=device)
        self._direction = wp.zeros(self._n, dtype=types.vec, device=device)
        # changes along it: of B_i; of the dilatations, their means and the stress of these; of the control
        self._change = wp.zeros(self._n, dtype=types.mat, device=device)
        self._dilatation, self._mean, self._stress, self._resistance = (
            wp.zeros(self._n, dtype=types.real, device=device) for _ in range(4)
        )
        self.block = wp.zeros(self._n, dtype=mat64, device=device)
        self._inverse = wp.zeros(self._n, dtype=mat64, device=device)
        # with which a product is that with x
        self._fresh = wp.array(np.ones(CONTROLS), dtype=wp.int32, device=device)
        self.operator = Operator(
            rows=wp.array([held.size], dtype=wp.int32, device=device),
            diagonal=wp.array(np.ones(held.size), dtype=types.real, device=device),
            active=wp.array((~held).ravel(), dtype=wp.int32, device=device),
            multiply=self._multiply,
        )

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Launch the blocks at the present state; the model's stresses must be those of this state."""
        model = self._model
        inputs = [*model.operators(), *model.constants(), model.dilatation.lame]
        inputs += [self._mass, self._inertia, self._free, model.gradient, model.resistance]
        self._launch(self._kernels.blocks, inputs, [self.block, self._inverse])

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Launch z = (diagonal blocks)^-1 r."""
        self._launch(self._kernels.precondition, [self._inverse, self.vectors(r)], [self.vectors(z)])

    def multiply(self, x: wp.array, q: wp.array) -> None:
        """Launch q = (K + m a) x over all axes, held ones as well."""
        self._multiply(self._fresh, x, x, q)

    def vectors(self, flat: wp.array) -> wp.array:
        """The memory of a vector of the solver, float64, shape [n d], as one of d numbers a particle, shape [n]."""
        return wp.array(ptr=flat.ptr, dtype=self._vec64, shape=self._n, device=self._device, copy=False)

    def _multiply(self, control: wp.array, x: wp.array, p: wp.array, q: wp.array) -> None:
        kernels, model = self._kernels, self._model
        self._launch(kernels.choose, [control, self.vectors(x), self.vectors(p)], [self._direction])
        mean, u, n = model.dilatation, self._u, self._n
        inputs = [*model.operators(), model.kappa, *model.constants()]
        inputs += [u, model.gradient, model.resistance, mean.stress, self._direction]
        self._launch(kernels.pull_change, inputs, [self._dilatation, self._resistance, self._change])
        if mean.acts:
            mean.average(self._dilatation, self._mean, 0, n)
            mean.gather(model.gradient, self._mean, self._stress, self._change, 0, n)
        inputs = [*model.operators()[:4], self._mass, self._inertia]
        inputs += [u, model.resistance, self._direction, self._resistance, self._change]
        self._launch(kernels.product, inputs, [self.vectors(q)])

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._n, inputs, outputs, device=self._device)

"""A numerical viscosity proportional to the stiffness, whatever the elastic model: it damps what a coupling excites."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.elastic.explicit.kernels import motion_kernels
from warp_mps.elastic.parts import SolidParts


class LaggedDamping:
    """The viscous force tau/dt (f^n - f^(n-1)) of the elastic forces f at the last two steps.

    Args:
        parts: The parts of the bodies.
        retardation_time: Retardation time tau [s].
    """

    def __init__(self, parts: SolidParts, retardation_time: float) -> None:
        self._parts, self._factor = parts, retardation_time / parts.dt
        self._kernels: Any = motion_kernels(parts.types)
        self._elastic, self._viscous = (
            wp.zeros(parts.count, dtype=parts.types.vec, device=parts.device) for _ in range(2)
        )

    def start(self) -> None:
        """Take the present elastic forces for those of the last step."""
        wp.copy(self._elastic, self._parts.state.force, count=self._parts.count)

    def launch(self, first: int, count: int) -> None:
        """Add the viscous force to the elastic one, and its energy loss to the dissipated energy."""
        state = self._parts.state
        inputs = [first, self._parts.dt, self._factor, state.v]
        outputs = [self._elastic, self._viscous, state.force, state.dissipated]
        wp.launch(self._kernels.add_lagged_damping, count, inputs, outputs, device=self._parts.device)

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves: elastic and viscous forces of the last step."""
        return [self._elastic, self._viscous]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        return {"retarded": np.stack([array.numpy() for array in self.evolving()])}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for array, values in zip(self.evolving(), arrays["retarded"], strict=True):
            array.assign(values)

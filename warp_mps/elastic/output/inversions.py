"""Neighbourhoods that are turned inside out: the equations can still be solved, but no longer describe a body."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.model import ElasticModel
from warp_mps.elastic.output.inversion_kernels import inversion_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# control of zero-energy modes that keeps lattices in order which fold with the default
FIRM_CONTROL = 1.0


class Inversions:
    """Finds particles with J <= 0, and lattices that have folded while every J is still positive.

    The model notes J <= 0 in every evaluation, for a later step could hide it. An equation's trial states count as
    little as the states that a coupling takes back: `keep` and `recall` are around them.

    Args:
        scene: The case.
        particles: Its elastic particles.
        model: Their model.
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self, scene: Scene, particles: Particles, model: ElasticModel, *, types: NumericTypes, device: Any
    ) -> None:
        self._scene, self._particles, self._model = scene, particles, model
        self._kernels, self._device = inversion_kernels(types), device
        self.inverted = model.inverted
        self._kept, self._tangled = (wp.zeros(particles.count, dtype=wp.int32, device=device) for _ in range(2))

    def keep(self) -> None:
        """Keep what was found so far, before trial states."""
        wp.copy(self._kept, self.inverted)

    def recall(self) -> None:
        """Return to what was kept."""
        wp.copy(self.inverted, self._kept)

    def note(self, gradients: wp.array) -> None:
        """Note J <= 0 of displacement gradients, shape [n, d, d]."""
        wp.launch(self._kernels.inversions, len(gradients), [gradients], [self.inverted], device=self._device)

    def trouble(self, state: ElasticState) -> str | None:
        """The first particle that is inverted or among folded ones, with the cause and a remedy; None without any."""
        model, n = self._model, self._particles.count
        gradients = model.gradients(state)
        self.note(gradients)
        if (found := np.flatnonzero(self.inverted.numpy())).size:
            return self._report(found, "turned inside out (J <= 0)")
        self._tangled.zero_()
        inputs = [model.start, model.index, model.bond, state.u, gradients]
        wp.launch(self._kernels.tangles, n, inputs, [self._tangled], device=self._device)
        if (found := np.flatnonzero(self._tangled.numpy())).size:
            return self._report(found, "folded over a neighbour")
        return None

    def _report(self, found: np.ndarray, state: str) -> str:
        first, others = int(found[0]), len(found) - 1
        more = f", as {'is' if others == 1 else 'are'} {others} more" if others else ""
        return (
            f"{self._particles.describe(first)} is {state}{more}: the body is crushed, or the time step is too large; "
            + self._remedy(first)
        )

    def _remedy(self, particle: int) -> str:
        """What makes such bodies resist: tried on cantilevers and pads under more load than they bear."""
        elasticity = self._scene.elasticity
        law = self._scene.materials[self._particles.materials[particle]].law
        if elasticity.model != "hamiltonian":
            return "the model 'hamiltonian' with the law 'neo_hookean' resists more"
        if law == "st_venant_kirchhoff":
            return 'this law softens in compression: give its material mps:law = "neo_hookean"'
        if elasticity.control < FIRM_CONTROL:
            return f"raise mps:control from {elasticity.control:.3g} to {FIRM_CONTROL:g}"
        return "reduce the load, or make the body stiffer"

"""The elastic bodies of a scene, advanced by the theta rule: parts, state, step and readings together."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.implicit.newton import LINEAR_TOLERANCE
from warp_mps.elastic.implicit.statistics import solver_record
from warp_mps.elastic.implicit.theta_rule import ThetaStep
from warp_mps.elastic.parts import SolidParts
from warp_mps.elastic.readings import SolidReadings
from warp_mps.elastic.solid_state import SolidState
from warp_mps.elastic.system import ElasticSystem
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.scene import Scene


class ThetaReadings(SolidReadings):
    """Readings of bodies that the theta rule advances, which counts the work of all loads together.

    Args:
        parts: The parts of the bodies.
        step: The step.
    """

    def __init__(self, parts: SolidParts, step: ThetaStep) -> None:
        super().__init__(parts)
        self._step = step

    def internal_forces(self) -> np.ndarray:
        """Elastic forces [N], shape [n, d]."""
        return self._step.elastic.numpy().astype(float)

    def energy(self) -> Energy:
        """Energies of the present state [J]; what the rule has created on balance is not taken for dissipated."""
        now = super().energy()
        return replace(now, dissipated=max(now.dissipated, 0.0))

    def work(self) -> float:
        """Work of supports, loads and external forces so far [J]."""
        return float(np.sum(self._step.work.numpy()))


class ImplicitSolid(ElasticSystem):
    """The elastic bodies of a scene, advanced by the theta rule.

    A coupling calls `save`, sets `external`, calls `advance`, looks at `state.u` and `state.v`, and calls `restore` to
    try another force; all of it stays on the device.

    Attributes:
        newton: The solver of a step.

    Args:
        scene: The case.
        particles: Its particles.
        dt: Time step of the run [s]; `advance` takes any.
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
        linear_tolerance: Tolerance of the linear systems of a step, relative to their right-hand sides.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        dt: float,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
        linear_tolerance: float = LINEAR_TOLERANCE,
    ) -> None:
        parts = SolidParts(scene, particles, dt=dt, types=types, device=device)
        self._step = ThetaStep(parts, scene.theta, graphs=graphs, linear_tolerance=linear_tolerance)
        self.newton = self._step.newton
        super().__init__(parts, SolidState(parts), ThetaReadings(parts, self._step))

    @property
    def external(self) -> wp.array:
        """Forces on the particles beside those of the scene, constant over a step [N], vec [n]."""
        return self._step.external

    def start(self) -> None:
        """Evaluate the forces of the initial state, with which the first step begins."""
        self._step.start()

    def advance(self, time: float, *, tolerance: float | None = None, share: float = math.inf) -> None:
        """Advance to a time [s] by one step.

        Args:
            time: The time [s].
            tolerance: Residual of the step relative to its forces, if not the default.
            share: Largest residual, as a share of the forces that act in the step.

        Raises:
            RunError: The step's equation was not solved; the state is the one before.
        """
        self._step.advance(time, tolerance, share)

    def save(self) -> None:
        """Keep the present state on the device."""
        self._step.save()

    def restore(self) -> None:
        """Return to the state that was kept.

        `external` stays as it is, and so does what the solver learned: the step begins its search where the last one
        led. A step that is taken again agrees with itself to the solver's tolerance, not to the bit.
        """
        self._step.restore()

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of the solvers, for run.json."""
        return {"implicit": solver_record(self.newton)}

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything that evolves, by name, for a checkpoint."""
        return {**super().arrays(), **self._step.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        super().assign(arrays)
        self._step.assign(arrays)

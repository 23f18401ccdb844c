"""Statistics of the fixed-point passes between fluid and bodies, for run.json."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_mps.core.counters import whole_numbers

# change of the forces in the last pass of a step, relative to them, beyond which the passes diverge
DIVERGED = 0.1


@dataclass
class CouplingStatistics:
    """Statistics of the passes so far.

    Attributes:
        steps: Steps done.
        passes: Passes of all steps together.
        most_passes: Passes of the step that took most.
        worst_residual: Largest change of the forces in the last pass of a step, relative to them.
        unconverged: Steps whose passes ended above the tolerance.
        diverged: Steps in a row, up to now, whose forces still changed by more than `DIVERGED` in their last pass.
        last_residual: Change of the forces in the last pass of the last step, relative to them.
    """

    steps: int = 0
    passes: int = 0
    most_passes: int = 0
    worst_residual: float = 0.0
    unconverged: int = 0
    diverged: int = 0
    last_residual: float = 0.0

    def add(self, passes: int, residual: float, *, converged: bool) -> None:
        """Count a step."""
        self.steps += 1
        self.passes += passes
        self.most_passes = max(self.most_passes, passes)
        self.worst_residual = max(self.worst_residual, residual)
        self.unconverged += not converged
        self.diverged = 0 if residual <= DIVERGED else self.diverged + 1
        self.last_residual = residual

    def state(self) -> np.ndarray:
        """The statistics, for a checkpoint, shape [7]."""
        counted = [self.steps, self.passes, self.most_passes, self.unconverged, self.diverged]
        return np.array([*counted, self.worst_residual, self.last_residual], float)

    def assign(self, state: np.ndarray) -> None:
        """Continue from what `state` returned.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        counted = whole_numbers(state[:5])
        self.steps, self.passes, self.most_passes, self.unconverged, self.diverged = counted
        self.worst_residual, self.last_residual = float(state[5]), float(state[6])

    def record(self) -> dict[str, float]:
        """For run.json."""
        return {
            "passes": self.passes / max(self.steps, 1),
            "most_passes": self.most_passes,
            "worst_residual": self.worst_residual,
            "unconverged": self.unconverged,
        }

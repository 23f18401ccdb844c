"""What the iterations between water and bodies did, for run.json."""

from __future__ import annotations

from dataclasses import dataclass

# change of the forces in a last pass, relative to them, beyond which water and bodies are at odds rather than slow
AT_ODDS = 0.1


@dataclass
class CouplingStatistics:
    """What the iterations did so far.

    Attributes:
        steps: Steps done.
        passes: Passes of all steps together.
        most_passes: Those of the longest.
        worst_residual: Largest change of the forces in a last pass, relative to them.
        disagreed: Steps that ended before water and bodies agreed.
        at_odds: Steps in a row, up to now, that ended with forces that still changed by more than `AT_ODDS`.
        last_residual: Change of the forces in the last pass of the last step, relative to them.
    """

    steps: int = 0
    passes: int = 0
    most_passes: int = 0
    worst_residual: float = 0.0
    disagreed: int = 0
    at_odds: int = 0
    last_residual: float = 0.0

    def add(self, passes: int, residual: float, *, agreed: bool) -> None:
        """Count a step."""
        self.steps += 1
        self.passes += passes
        self.most_passes = max(self.most_passes, passes)
        self.worst_residual = max(self.worst_residual, residual)
        self.disagreed += not agreed
        self.at_odds = 0 if residual <= AT_ODDS else self.at_odds + 1
        self.last_residual = residual

    def record(self) -> dict[str, float]:
        """For run.json."""
        return {
            "passes": self.passes / max(self.steps, 1),
            "most_passes": self.most_passes,
            "worst_residual": self.worst_residual,
            "disagreed": self.disagreed,
        }

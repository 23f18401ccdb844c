"""When a preconditioner that is reused from solve to solve is rebuilt.

A preconditioner lags more and more behind the matrix, and the solves take more iterations. It is rebuilt as soon as the
excess iterations have cost as much as a rebuild. This is the rule of the rent-or-buy problem: its total cost is at most
twice that of the best choice in hindsight. The cost is counted in iterations, not in seconds, so that a repeated or
restarted run takes the same decisions.

References:
    Karlin, A. R., Manasse, M. S., Rudolph, L. and Sleator, D. D., Algorithmica 3 (1988) 79.
"""

from __future__ import annotations

import numpy as np

from warp_mps.core.counters import whole_numbers

# iterations of a solve below which a rebuild saves nothing
FEW_ITERATIONS = 20
# tolerated growth of the iterations over those of the first solve after a rebuild
SLACK = 1.25


class ReusePolicy:
    """Decides when a reused preconditioner is rebuilt.

    Attributes:
        usual: Expected iterations of a solve.
        excess: Iterations beyond the expected ones since the last rebuild.
        rebuilds: Number of rebuilds so far.

    Args:
        cost: Cost of a rebuild, in iterations.
    """

    def __init__(self, cost: float) -> None:
        self._cost = cost
        self.usual, self.excess, self._first_solve = float(FEW_ITERATIONS), 0.0, False
        self.rebuilds = 0

    @property
    def rebuild_due(self) -> bool:
        """Whether the preconditioner should be rebuilt before the next solve."""
        return self.excess > self._cost

    def record_solve(self, iterations: int) -> None:
        """Count the iterations of a solve."""
        if self._first_solve:
            self.usual, self._first_solve = float(max(iterations, FEW_ITERATIONS)), False
        self.excess += max(0.0, iterations - SLACK * self.usual)

    def request_rebuild(self) -> None:
        """Make a rebuild due before the next solve, regardless of the iterations so far."""
        self.excess = np.inf

    def record_rebuild(self) -> None:
        """Restart the count after a rebuild."""
        self.excess, self._first_solve = 0.0, True
        self.rebuilds += 1

    def state(self) -> np.ndarray:
        """The counters, for a checkpoint, shape [4]."""
        return np.array([self.usual, self.excess, float(self._first_solve), float(self.rebuilds)])

    def assign(self, state: np.ndarray) -> None:
        """Restore the counters that `state` returned.

        Raises:
            ValueError: The number of rebuilds is no whole number of 0 or more.
        """
        self.usual, self.excess, self._first_solve = float(state[0]), float(state[1]), bool(state[2])
        (self.rebuilds,) = whole_numbers(state[3:])

"""When to renew what speeds up a solver and becomes worse by and by.

Whoever rents, and buys once the rent has been as much as the price, never pays more than twice the least (Karlin,
Manasse, Rudolph & Sleator, Algorithmica 3 (1988) 79). What counts are iterations, not seconds: a run that is repeated,
or continued from a checkpoint, decides the same.
"""

from __future__ import annotations

import numpy as np

# iterations of a solve that are as good as none to save
FEW_ITERATIONS = 20
# beyond those of the first solve after a renewal that are not held against it
SLACK = 1.25


class Renewal:
    """When to renew what becomes worse by and by: once it has cost as much as a renewal.

    Attributes:
        usual: Iterations that a solve is expected to take.
        excess: Iterations beyond that since the last renewal.
        renewals: Renewals so far.

    Args:
        price: A renewal, in iterations.
    """

    def __init__(self, price: float) -> None:
        self._price = price
        self.usual, self.excess, self._fresh = float(FEW_ITERATIONS), 0.0, False
        self.renewals = 0

    @property
    def due(self) -> bool:
        """Whether to renew."""
        return self.excess > self._price

    def count(self, iterations: int) -> None:
        """Take note of a solve."""
        if self._fresh:
            self.usual, self._fresh = float(max(iterations, FEW_ITERATIONS)), False
        self.excess += max(0.0, iterations - SLACK * self.usual)

    def demand(self) -> None:
        """Renew before the next solve, whatever the last ones took."""
        self.excess = np.inf

    def renew(self) -> None:
        """Begin anew."""
        self.excess, self._fresh = 0.0, True
        self.renewals += 1

    def numbers(self) -> np.ndarray:
        """What it remembers."""
        return np.array([self.usual, self.excess, float(self._fresh)])

    def assign(self, numbers: np.ndarray) -> None:
        """Remember what `numbers` gave."""
        self.usual, self.excess, self._fresh = float(numbers[0]), float(numbers[1]), bool(numbers[2])

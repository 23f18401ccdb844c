"""Conservation of momentum: the internal forces of the particles must sum up to zero."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import RunError
from warp_mps.observers.base import Observer, View
from warp_mps.observers.records import numbers_of

NAMES = ["resultant", "magnitude"]


class MomentumMonitor(Observer):
    """Keeps the largest resultant of the internal forces, relative to the sum of their magnitudes.

    The internal force on a particle is the total force less its weight, loads and body forces.

    Args:
        every: Steps between two looks.
    """

    def __init__(self, *, every: int) -> None:
        self.every = every
        # largest resultant and magnitude so far [N]
        self._largest = (0.0, 0.0)
        self._regular = (0.0, 0.0)

    @property
    def error(self) -> float:
        """Largest resultant over the largest sum of magnitudes [-]; 0 where no force acts."""
        resultant, magnitude = self._largest
        return resultant / magnitude if magnitude else 0.0

    def observe(self, view: View) -> None:
        """Look at the forces.

        Raises:
            RunError: A force is not finite.
        """
        forces = view.internal_forces
        bad = np.flatnonzero(~np.isfinite(forces).all(axis=1))
        if len(bad):
            place = view.particles.describe(int(bad[0]))
            raise RunError(f"the force on {place} is not finite at {view.time:.6g} s (step {view.step})")
        resultant, magnitude = float(np.linalg.norm(forces.sum(axis=0))), float(np.linalg.norm(forces, axis=1).sum())
        self._largest = max(self._largest[0], resultant), max(self._largest[1], magnitude)
        # the last moment of a run may lie off the grid, where a run that goes on from there would not look
        if view.step % self.every == 0:
            self._regular = self._largest

    def record(self) -> dict[str, float]:
        """What it has seen so far, as JSON can hold it, for a checkpoint."""
        return dict(zip(NAMES, self._regular, strict=True))

    def restore(self, record: object) -> None:
        """Go on from what `record` gave.

        Raises:
            ValueError: It is not such a record.
        """
        resultant, magnitude = numbers_of(record, NAMES)
        self._largest = self._regular = resultant, magnitude

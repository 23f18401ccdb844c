"""Conservation of momentum: the internal forces of the particles must sum up to zero."""

from __future__ import annotations

import numpy as np

from warp_mps.observers.base import Observer, View


class MomentumMonitor(Observer):
    """Keeps the largest resultant of the internal forces, relative to the sum of their magnitudes.

    The internal force on a particle is the total force less its weight, loads and body forces.

    Args:
        every: Steps between two looks.
    """

    def __init__(self, *, every: int) -> None:
        self.every = every
        self._resultant = 0.0
        self._magnitude = 0.0

    @property
    def error(self) -> float:
        """Largest resultant over the largest sum of magnitudes [-]; 0 where no force acts."""
        return self._resultant / self._magnitude if self._magnitude else 0.0

    def observe(self, view: View) -> None:
        """Look at the forces."""
        forces = view.internal_forces
        self._resultant = max(self._resultant, float(np.linalg.norm(forces.sum(axis=0))))
        self._magnitude = max(self._magnitude, float(np.linalg.norm(forces, axis=1).sum()))

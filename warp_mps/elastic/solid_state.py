"""Everything that evolves in the elastic bodies of a scene, for snapshots and checkpoints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import warp as wp

from warp_mps.elastic.explicit.lagged_damping import LaggedDamping
from warp_mps.elastic.parts import SolidParts


class SolidState:
    """The states of all parts together; a step goes on from their contents.

    Args:
        parts: The parts of the bodies.
        lagged: Their numerical viscosity, if any.
    """

    def __init__(self, parts: SolidParts, lagged: LaggedDamping | None = None) -> None:
        self._parts, self._lagged = parts, lagged

    def evolving(self) -> list[wp.array]:
        """Device arrays of everything that evolves."""
        arrays = [array for part in self._evolving_parts() for array in part.evolving()]
        return [*arrays, self._parts.inversions.inverted]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything that evolves, by name, for a checkpoint."""
        return {name: array for part in self._evolving_parts() for name, array in part.arrays().items()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        parts = self._parts
        for part in (parts.state, parts.boundary, parts.model.rotation, parts.viscosity, parts.body_forces):
            if part:
                part.assign(arrays)
        if self._lagged:
            self._lagged.assign(arrays)
        if parts.walls:
            parts.walls.assign(arrays, parts.boundary.steps)
        # the stresses belong to the step, but readings at this moment need them
        for _, launch in parts.model.passes[:-1]:
            launch(parts.state, 0, parts.count)
        if parts.contacts:
            parts.contacts.assign(arrays)
            parts.contacts.initialize(parts.state)

    def _evolving_parts(self) -> Iterator[Any]:
        parts = self._parts
        found = (parts.state, parts.boundary, parts.model.rotation, parts.viscosity, parts.walls, parts.contacts)
        return (part for part in (*found, parts.body_forces, self._lagged) if part)

"""A shape given by ready-made particles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.numbers import as_array
from warp_mps.shapes.point_search import near_points
from warp_mps.shapes.shape import Shape


@dataclass(frozen=True, eq=False)
class Points(Shape):
    """Ready-made particles.

    Attributes:
        positions: Positions [m], shape [n, 2] or [n, 3].
        velocities: Initial velocities in the scene's coordinates [m/s], of the same shape; None is at rest.
            They stay as they are where the particles are moved or turned.
    """

    positions: np.ndarray
    velocities: np.ndarray | None = None

    is_region: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("positions", self._rows("positions", self.positions))
        if self.velocities is not None:
            self._set("velocities", self._rows("velocities", self.velocities))
            if len(self.velocities) != len(self.positions):
                message = f"has {len(self.velocities)} rows for {len(self.positions)} positions"
                raise InputError(self._kind, "velocities", message)

    def _rows(self, name: str, values: np.ndarray) -> np.ndarray:
        rows = as_array(values)
        if rows.ndim != 2 or rows.shape[1] not in (2, 3) or not np.isfinite(rows).all():
            raise InputError(self._kind, name, "must be finite, shape [n, 2] or [n, 3]")
        return np.pad(rows, ((0, 0), (0, 3 - rows.shape[1])))

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the placed points along a unit direction of the scene [m]."""
        along = self.to_scene(self.positions) @ direction
        return float(along.min()), float(along.max())

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie within a tolerance [m] of a particle."""
        return near_points(points, self.to_scene(self.positions), tolerance)

"""Units and axes: how a stage's numbers become the scene's, and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from warp_mps.errors import InputError
from warp_mps.scene import StageFrame
from warp_mps.usd.case.stage_attribute import StageAttribute

# Components out of the plane below this fraction of the vector are rounding.
OUT_OF_PLANE = 1e-6


@dataclass(frozen=True)
class Frame:
    """The map between a stage and a scene.

    Attributes:
        stage: Units and axes of the stage.
        dimension: 2 or 3.
    """

    stage: StageFrame
    dimension: int

    @cached_property
    def rotation(self) -> np.ndarray:
        """Rotation from the stage's axes to the scene's, shape [3, 3]; in 2-D the third row is the normal."""
        rows = [np.eye(3)["xyz".index(axis)] for axis in self.stage.axes]
        return np.array(rows if len(rows) == 3 else [*rows, np.cross(rows[0], rows[1])])

    def factor(self, attribute: StageAttribute) -> float:
        """SI value of an attribute's 1."""
        return self.stage.meters_per_unit**attribute.length * self.stage.kilograms_per_unit**attribute.mass

    def vectors_to_scene(self, vectors: ArrayLike, attribute: StageAttribute, where: str) -> np.ndarray:
        """Vectors of the stage, shape [..., 3], in SI units along the scene's axes, shape [..., dimension].

        An axial vector of a plane becomes its one component out of the plane, shape [..., 1].

        Raises:
            InputError: A vector points where a 2-D scene has no room for it.
        """
        turned = np.asarray(vectors, float) * self.factor(attribute) @ self.rotation.T
        if self.dimension == 3 or attribute.known.nature == "point":
            return turned[..., : self.dimension]
        kept, lost = (
            (turned[..., 2:], turned[..., :2])
            if attribute.known.nature == "axial"
            else (turned[..., :2], turned[..., 2:])
        )
        if lost.size and abs(lost).max() > OUT_OF_PLANE * abs(turned).max():
            direction = "along the normal of" if attribute.known.nature == "axial" else "in"
            reason = f"must lie {direction} the plane {self.stage.axes} of this 2-D scene"
            raise InputError(where, attribute.name, reason)
        return kept

    def vectors_to_stage(self, vectors: ArrayLike, attribute: StageAttribute) -> np.ndarray:
        """The inverse of `vectors_to_scene`, shape [..., 3]."""
        vectors = np.atleast_1d(np.asarray(vectors, float))
        before = 3 - vectors.shape[-1] if attribute.known.nature == "axial" else 0
        widths = [(0, 0)] * (vectors.ndim - 1) + [(before, 3 - vectors.shape[-1] - before)]
        return np.pad(vectors, widths) @ self.rotation / self.factor(attribute)

    def placement(self, matrix: np.ndarray) -> np.ndarray:
        """Placement in the scene of a shape whose own lengths are in metres, from its matrix in the stage, [4, 4]."""
        placement = np.eye(4)
        placement[:3, :3] = self.rotation @ matrix[:3, :3]
        placement[:3, 3] = self.rotation @ matrix[:3, 3] * self.stage.meters_per_unit
        return placement

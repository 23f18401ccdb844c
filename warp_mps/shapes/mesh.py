"""A shape bounded by a closed surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes import closed_surface
from warp_mps.shapes.numbers import as_array
from warp_mps.shapes.shape import Shape


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """The inside of a closed surface of triangles.

    Attributes:
        points: Vertices [m], shape [n, 3].
        triangles: Vertices of each triangle, shape [m, 3].
    """

    points: np.ndarray
    triangles: np.ndarray

    def __post_init__(self) -> None:
        super().__post_init__()
        points, numbers = as_array(self.points), as_array(self.triangles)
        triangles = numbers.astype(np.int64)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.isfinite(points).all():
            raise InputError(self._kind, "points", "must be finite, shape [n, 3], n at least 1")
        good = triangles.ndim == 2 and triangles.shape[1] == 3 and np.array_equal(triangles, numbers)
        if not good or triangles.min(initial=0) < 0:
            raise InputError(self._kind, "triangles", "must be indices of points, shape [n, 3]")
        if triangles.max(initial=0) >= len(points):
            raise InputError(self._kind, "triangles", f"refers to point {triangles.max()} of {len(points)}")
        self._set("points", points)
        self._set("triangles", triangles)

    @classmethod
    def from_file(cls, path: str | Path, *, scale: float = 1.0, placement: np.ndarray | None = None) -> Mesh:
        """The inside of a closed surface in an STL, OBJ or PLY file, read by trimesh.

        Args:
            path: The file.
            scale: Metres per unit of the file: 0.001 for a file in millimetres.
            placement: How it is turned, stretched and moved, as of every `Shape`; applied after the scale.

        Raises:
            InputError: trimesh is not installed, the file cannot be read, or the surface is not closed; the reason
                then tells where an open edge is.
        """
        from warp_mps.shapes.mesh_file import read_mesh

        points, triangles = read_mesh(Path(path), scale)
        return cls(points, triangles, placement=placement)

    def corners(self) -> np.ndarray:
        """Corners of the placed triangles [m], shape [m, 3, 3]."""
        return self.to_scene(self.points)[self.triangles]

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the placed points along a unit direction of the scene [m]."""
        along = self.to_scene(self.points) @ direction
        return float(along.min()), float(along.max())

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the surface, moved out by a tolerance [m]."""
        corners = self.corners()
        result = closed_surface.enclosed(points, corners)
        if tolerance < 0 and result.any():
            result[result] = ~closed_surface.near_surface(points[result], corners, -tolerance)
        if tolerance > 0 and not result.all():
            result[~result] = closed_surface.near_surface(points[~result], corners, tolerance)
        return result

"""A shape bounded by a closed surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes import closed_surface
from warp_mps.shapes.numbers import as_array
from warp_mps.shapes.shape import Shape
from warp_mps.shapes.shells import Shells, find_shells


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """The inside of a closed surface of triangles.

    Where the surface has several shells, it is what any of them encloses, also where they overlap; a shell that is
    turned opposite to the outermost one around it is a cavity. How all are turned together does not matter.

    Attributes:
        points: Vertices [m], shape [n, 3].
        triangles: Vertices of each triangle, shape [m, 3].
        unscaled_file: Name of the file that it was read from without a scale, empty otherwise.
    """

    points: np.ndarray
    triangles: np.ndarray
    unscaled_file: str = field(default="", repr=False)

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
    def from_file(cls, path: str | Path, *, scale: float | None = None, placement: np.ndarray | None = None) -> Mesh:
        """The inside of a closed surface in an STL, OBJ or PLY file, read by trimesh.

        Args:
            path: The file.
            scale: Metres per unit of the file, which does not say it: 0.001 for a file in millimetres. If it is not
                given, the file is read in metres, and a check or a run remarks on it with the size that results.
            placement: How it is turned, stretched and moved, as of every `Shape`; applied after the scale.

        Raises:
            InputError: trimesh is not installed, the file cannot be read, or the surface is not closed; the reason
                then tells where an open edge is.
        """
        from warp_mps.shapes.mesh_file import read_mesh

        points, triangles = read_mesh(Path(path), 1.0 if scale is None else scale)
        name = Path(path).name if scale is None else ""
        return cls(points, triangles, placement=placement, unscaled_file=name)

    def corners(self) -> np.ndarray:
        """Corners of the placed triangles [m], shape [m, 3, 3]."""
        return self.to_scene(self.points)[self.triangles]

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the placed points along a unit direction of the scene [m]."""
        along = self.to_scene(self.points) @ direction
        return float(along.min()), float(along.max())

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the surface, moved out by a tolerance [m]."""
        if self.fault:
            raise InputError(self._kind, "triangles", self.fault)
        corners = self.to_scene(self._shells.points)[self._shells.triangles]
        result = self._encloses(points, corners)
        if tolerance < 0 and result.any():
            near = np.flatnonzero(result)
            near = near[closed_surface.near_surface(points[near], corners, -tolerance)]
            result[near] = self._within_others(points[near], corners, -tolerance)
        if tolerance > 0 and not result.all():
            result[~result] = closed_surface.near_surface(points[~result], corners, tolerance)
        return result

    @property
    def fault(self) -> str:
        """Why it has no inside, as a clause of an error message; empty if it has one."""
        return self._hole or self._shells.fault

    @property
    def idle_shells(self) -> np.ndarray:
        """A vertex [m] of each shell that lies inside others, turned alike, and so adds nothing, shape [n, 3]."""
        return self.to_scene(self._shells.idle)

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        return closed_surface.same_places(self.points)

    @cached_property
    def _hole(self) -> str:
        source, places = self._places
        hole = closed_surface.open_edge(places[self.triangles], self.to_scene(self.points[source]))
        return f"the mesh is not closed: every edge must belong to exactly two triangles, {hole}" if hole else ""

    @cached_property
    def _shells(self) -> Shells:
        source, places = self._places
        return find_shells(self.points[source], places[self.triangles])

    def _encloses(self, points: np.ndarray, corners: np.ndarray) -> np.ndarray:
        """Whether more solids than cavities wind about points."""
        owners, shells, _ = closed_surface.windings(points, corners, self._shells.numbers)
        return np.bincount(owners, self._shells.roles[shells], len(points)) > 0

    def _within_others(self, points: np.ndarray, corners: np.ndarray, distance: float) -> np.ndarray:
        """Whether points near a shell lie in others so deep that all within a distance [m] is inside."""
        if len(self._shells.roles) == 1:
            return np.zeros(len(points), bool)
        directions = np.concatenate([np.eye(3), -np.eye(3), np.array([*product((-1, 1), repeat=3)]) / np.sqrt(3)])
        around = [self._encloses(points + distance * direction, corners) for direction in directions]
        return np.all(around, axis=0)

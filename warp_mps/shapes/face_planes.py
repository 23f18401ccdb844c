"""Lattices between the plane faces of walls that are not boxes: tanks made of several boxes, or drawn as a mesh.

Along each axis the plane faces across it cut the lattice into segments. Each is filled as a wall of its own, so that
the particles lie half a spacing behind every face, as well as the lengths allow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from warp_mps.shapes.lattice import FIT_TOLERANCE, Line, anchored, cells, is_multiple
from warp_mps.shapes.mesh import Mesh
from warp_mps.shapes.primitives import Box
from warp_mps.shapes.shape import Shape

# cosine to an axis from which on a direction is along it
ALONG = 1.0 - 1e-9
# in spacings: faces nearer to each other count as one; segments of at least this length are filled evenly, shorter ones
# with their outermost particles exactly half a spacing inside
NEAREST, LONG = 0.5, 10.0


@dataclass(frozen=True)
class BrokenLine(Line):
    """Particles along an axis in segments, each of evenly spaced ones.

    Attributes:
        centre: Middle between the outermost ones [m].
        count: Their number.
        step: Mean distance between them [m].
        parts: The segments, in order.
    """

    parts: tuple[Line, ...]

    @classmethod
    def of(cls, parts: Sequence[Line]) -> BrokenLine:
        """The line of some segments, of at least one particle."""
        x = np.concatenate([part.coordinates() for part in parts])
        step = float(x[-1] - x[0]) / max(1, len(x) - 1)
        return cls(0.5 * float(x[0] + x[-1]), len(x), step, tuple(parts))

    def coordinates(self) -> np.ndarray:
        """Their coordinates [m], shape [count]."""
        return np.concatenate([part.coordinates() for part in self.parts])


def broken_line(
    shape: Shape, axis: np.ndarray, low: float, high: float, spacing: float, met: tuple[bool, bool]
) -> BrokenLine | None:
    """The particles of a wall along an axis, between its plane faces.

    Args:
        shape: Shape of the wall.
        axis: Unit direction of the axis, shape [3].
        low: Where the shape begins along it [m].
        high: Where it ends [m].
        spacing: Particle spacing l0 [m].
        met: Whether something lies at its low and its high end.

    Returns:
        The line; None if there is nothing to break it, or if all segments are whole numbers of spacings.
    """
    planes = np.concatenate([face_planes(leaf, axis, spacing) for leaf in shape.leaves()])
    flat = [bool((np.abs(planes - end) <= FIT_TOLERANCE * spacing).any()) for end in (low, high)]
    cuts = [low]
    for plane in np.sort(planes[planes < high - NEAREST * spacing]).tolist():
        if plane > cuts[-1] + NEAREST * spacing:
            cuts.append(plane)
    cuts.append(high)
    # a shape that begins with a box has that box's lattice, which is fitted to its ends
    unbroken = len(cuts) == 2 and (isinstance(shape.leaves()[0], Box) or not any(flat))
    if unbroken or all(is_multiple(end - start, spacing) for start, end in pairwise(cuts)):
        return None
    parts = []
    for start, end in pairwise(cuts):
        ends = start != low or met[0], end != high or met[1]
        round_end = (start == low and not flat[0]) or (end == high and not flat[1])
        parts.append(_segment(start, end, spacing, ends, whole=not round_end))
    return BrokenLine.of([part for part in parts if part.count])


def face_planes(shape: Shape, axis: np.ndarray, spacing: float) -> np.ndarray:
    """Coordinates of the plane faces of a box or a mesh across an axis [m], shape [faces]; none of other shapes.

    Faces of a mesh smaller than a particle's do not count.
    """
    if isinstance(shape, Box):
        own = shape.linear / np.linalg.norm(shape.linear, axis=0)
        square = np.allclose(own.T @ own, np.eye(3), atol=1e-9)
        return np.array(shape.interval(axis)) if square and np.abs(axis @ own).max() > ALONG else np.zeros(0)
    if not isinstance(shape, Mesh):
        return np.zeros(0)
    a, b, c = np.moveaxis(shape.corners(), 1, 0)
    normals = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    across = np.abs(normals @ axis) > (1.0 - FIT_TOLERANCE**2) * areas
    heights, areas = (a @ axis)[across & (areas > 0.0)], areas[across & (areas > 0.0)]
    levels, owners = np.unique(np.round(heights / (FIT_TOLERANCE * spacing)), return_inverse=True)
    large = np.bincount(owners.reshape(-1), areas, minlength=len(levels)) >= spacing**2
    return levels[large] * FIT_TOLERANCE * spacing


def _segment(low: float, high: float, spacing: float, ends: tuple[bool, bool], *, whole: bool) -> Line:
    """The particles between two ends, of which one or both are to be met; both are plane faces if they are whole."""
    size = (high - low) / spacing
    count = cells(high - low, spacing, whole=whole, nodes=False)
    if not whole or is_multiple(high - low, spacing) or not all(ends) or count < 2:
        return anchored(low, high, count, spacing, ends)
    step = (high - low) / count if size >= LONG else (high - low - spacing) / (count - 1)
    return Line(0.5 * (low + high), count, step)

"""Which faces of walls and fluids meet something, so that their lattices begin there whatever their size.

The lattice of a box whose size is no whole number of spacings cannot lie half a spacing inside all of its faces. The
faces that matter are those that meet something:

    walls:   a face beyond which, as seen along its normal, there is a fluid, a body or another wall; and a face that
             looks up where anything reaches above it, for water may come over it. The outer faces of a tank do not.
    fluids:  a face with a body, a wall or another fluid within half a spacing, and one on a face of a periodic domain.

Bodies keep the lattice centred on them. Walls continue the lattice of the water along their faces, so that their
particles face each other: half a spacing beside it the number density of water in 3-D is 0.7 % lower, and it settles.
"""

from __future__ import annotations

import functools

import numpy as np

from warp_mps.scene import Body, Fluid, Scene, Wall
from warp_mps.scene.validation.rules import kind_of, place
from warp_mps.shapes import Box, Fit, Grid, Points, contains, grid_of

# in particle spacings: what reaches no further beyond a face, or beside it, counts as flush with it; how near a fluid
# must be to what it lies on
FLUSH, NEAR = 0.1, 0.5
# cosine between the normal of a face and the direction against gravity from which on it looks up
LOOKS_UP = 0.5
# number of points along each edge of a face of a fluid at which neighbours are looked for, at most
SAMPLES = 24


class Fits:
    """How the lattices of a scene's walls and fluids meet what lies at their faces.

    Args:
        scene: The case.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def of(self, item: Body | Wall | Fluid) -> Fit | None:
        """That of a body (None), a wall or a fluid."""
        if isinstance(item, Wall):
            return Fit(ends=functools.partial(_faces_of_wall, self._scene, item), keeps="face", guides=self._water)
        if isinstance(item, Fluid):
            return Fit(ends=functools.partial(_faces_of_fluid, self._scene, item), keeps="volume")
        return None

    def grid(self, item: Body | Wall | Fluid) -> Grid:
        """The lattice that fills a body, wall or fluid."""
        where = place(item, kind_of(item))
        return grid_of(item.shape, item.spacing, self._scene.dimension, item.node_axes, where, self.of(item))

    def _water(self) -> list[Grid]:
        """Lattices of the boxes of water, which walls continue."""
        return self._grids

    @functools.cached_property
    def _grids(self) -> list[Grid]:
        return [self.grid(fluid) for fluid in self._scene.fluids if isinstance(fluid.shape, Box)]


def _faces_of_wall(scene: Scene, wall: Wall, axes: np.ndarray, intervals: np.ndarray) -> np.ndarray:
    """Flags of the faces of a wall beyond which there is something, shape [axes, 2]."""
    met = np.zeros(intervals.shape, bool)
    margin = FLUSH * wall.spacing
    spans = np.array([[item.shape.interval(axis) for axis in axes.T] for item in scene.filled if item is not wall])
    if not len(spans):
        return met
    gravity = np.zeros(3)
    gravity[: len(scene.gravity)] = scene.gravity
    upwards = -(gravity @ axes) / (np.linalg.norm(gravity) or 1.0)
    looks_up = -upwards > LOOKS_UP, upwards > LOOKS_UP
    overlap = (spans[..., 0] < intervals[:, 1] - margin) & (spans[..., 1] > intervals[:, 0] + margin)
    beyond = spans[..., 0] < intervals[:, 0] - margin, spans[..., 1] > intervals[:, 1] + margin
    for axis, end in np.ndindex(met.shape):
        opposite = np.delete(overlap, axis, axis=1).all(axis=1)
        met[axis, end] = (beyond[end][:, axis] & (opposite | looks_up[end][axis])).any()
    return met


def _faces_of_fluid(scene: Scene, fluid: Fluid, axes: np.ndarray, intervals: np.ndarray) -> np.ndarray:
    """Flags of the faces of a fluid that lie on something, shape [axes, 2]."""
    met = np.zeros(intervals.shape, bool)
    counts = np.clip(np.ceil(np.ptp(intervals, axis=1) / fluid.spacing), 1, SAMPLES).astype(int)
    lines = [low + (high - low) * (np.arange(n) + 0.5) / n for (low, high), n in zip(intervals, counts, strict=True)]
    for axis, end in np.ndindex(met.shape):
        met[axis, end] = _on_period(scene, fluid, axes[:, axis], intervals[axis, end])
        beyond = intervals[axis, end] + (2 * end - 1) * NEAR * fluid.spacing
        face = [*lines[:axis], np.array([beyond]), *lines[axis + 1 :]]
        points = np.stack(np.meshgrid(*face, indexing="ij"), axis=-1).reshape(-1, len(counts)) @ axes.T
        for item in scene.filled:
            if met[axis, end]:
                break
            if item is not fluid:
                tolerance = NEAR * item.spacing if isinstance(item.shape, Points) else 0.0
                met[axis, end] = contains(item.shape, points[:, : scene.dimension], tolerance).any()
    return met


def _on_period(scene: Scene, fluid: Fluid, axis: np.ndarray, at: float) -> bool:
    """Whether a face at a coordinate along an axis lies on a face of a periodic domain."""
    if scene.flow.domain is None:
        return False
    corners = np.array(scene.flow.domain)[:, list(scene.flow.periodic)]
    along = np.abs(axis[list(scene.flow.periodic)]) > 1.0 - 1e-9
    return bool((np.abs(corners[:, along] - at) <= NEAR * fluid.spacing).any())

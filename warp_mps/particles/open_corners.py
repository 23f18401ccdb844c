"""Walls that meet along an edge only, with nothing behind it: water leaks between particles 1.4 spacings apart."""

from __future__ import annotations

import numpy as np

from warp_mps.scene import Body, Scene, Wall
from warp_mps.scene.validation.rules import place
from warp_mps.shapes import Box, contains

# in spacings: how near faces are that meet, and how far beside the edge something is looked for
MEETS, BESIDE = 0.25, 0.5


def remarks_on_open_corners(scene: Scene) -> list[str]:
    """A line for each pair of walls, boxes along the scene's axes, that leave their common corner open to a fluid."""
    walls = [wall for wall in scene.walls if _is_along_axes(wall)]
    if not scene.fluids or len(walls) < 2:
        return []
    axes = np.eye(3)[: scene.dimension]
    spans = np.array([[wall.shape.interval(axis) for axis in axes] for wall in walls])
    margin = MEETS * scene.fluids[0].spacing
    low, high = spans[..., 0], spans[..., 1]
    # [one, other, axis]: whether the one ends where the other begins, and whether they lie beside each other
    ends = np.abs(high[:, None] - low[None]) <= margin
    beside = (low[:, None] < high[None] - margin) & (low[None] < high[:, None] - margin)
    meets = ends | ends.transpose(1, 0, 2)
    edge = (meets.sum(axis=2) == 2) & ((meets | beside).all(axis=2))
    return [line for a, b in np.argwhere(np.triu(edge, 1)) for line in _open(scene, walls, spans, ends, (a, b))]


def _is_along_axes(wall: Wall) -> bool:
    linear = np.abs(wall.shape.linear)
    return isinstance(wall.shape, Box) and bool(np.count_nonzero(linear > 1e-9 * linear.max()) == 3)


def _open(scene: Scene, walls: list[Wall], spans: np.ndarray, ends: np.ndarray, pair: tuple[int, int]) -> list[str]:
    """A line about two walls that meet along an edge, unless one of the two cells beside it is filled."""
    a, b = pair
    across = np.flatnonzero(ends[a, b] | ends[b, a])
    at = 0.5 * (np.maximum(spans[a, :, 0], spans[b, :, 0]) + np.minimum(spans[a, :, 1], spans[b, :, 1]))
    # along each axis, the side of the edge on which the first wall lies
    side = np.where(ends[a, b][across], -1.0, 1.0)
    points = np.repeat(at[None], 2, axis=0)
    points[:, across] += BESIDE * scene.fluids[0].spacing * side * np.array([(1.0, -1.0), (-1.0, 1.0)])
    filled = np.zeros(2, bool)
    solids: list[Wall | Body] = [*scene.walls, *scene.bodies]
    for item in solids:
        filled |= contains(item.shape, points, MEETS * item.spacing)
    if filled.any():
        return []
    where, other = place(walls[a], "wall"), place(walls[b], "wall")
    corner = ", ".join(f"{c:.4g}" for c in at)
    return [
        f"{where}: meets {other} along an edge only, at ({corner}) m: water leaks there; let one reach past the other"
    ]

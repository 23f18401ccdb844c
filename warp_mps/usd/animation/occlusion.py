"""Walls that hide the rest of a scene from the camera, so that a view can leave them out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warp_mps.usd.animation.viewpoint import space_axes

if TYPE_CHECKING:
    from warp_mps.particles.particles import Particles
    from warp_mps.scene import StageFrame

# largest share of the content that a wall may hide
HIDDEN = 0.15
# sample points for later positions of the fluid, along every axis
PLACES = 24


def hidden_share(wall: np.ndarray, content: np.ndarray, cell: float) -> float:
    """Share of the content that a wall hides, in the cells of a coarse picture.

    Args:
        wall: Particles of the wall: coordinates across, up, and towards the viewer, shape [n, 3].
        content: Particles of the content in the same coordinates, shape [m, 3].
        cell: Width of a cell, some particles wide.
    """
    cells = np.floor(np.concatenate([wall, content])[:, :2] / cell).astype(np.int64)
    columns, rows = (cells - cells.min(axis=0)).T
    places = rows * (columns.max() + 1) + columns
    nearest = np.full((2, places.max() + 1), -np.inf)
    np.maximum.at(nearest[0], places[: len(wall)], wall[:, 2])
    np.maximum.at(nearest[1], places[len(wall) :], content[:, 2])
    seen = np.isfinite(nearest[1])
    return float(np.mean(nearest[0][seen] > nearest[1][seen]))


def occluding_walls(particles: Particles, frame: StageFrame) -> list[str]:
    """Names of the walls that hide the rest of a 3-D scene from the camera of its animation.

    Fluid may reach every point between the walls, at the heights at which it starts.
    """
    first, last = particles.elastic, particles.count - particles.liquid
    if len(frame.axes) == 2 or first == last or last - first == particles.count:
        return []
    axes = space_axes("XYZ".index(frame.up_axis))
    content = [particles.positions[:first]]
    if particles.liquid:
        content.append(_fluid_positions(particles.positions, particles.positions[last:], "XYZ".index(frame.up_axis)))
    local = np.concatenate(content) @ axes.T
    cell = 3.0 * float(particles.spacings.max())
    if particles.liquid:
        cell = max(cell, float(np.ptp(particles.positions, axis=0).max()) / (PLACES - 1))
    found = []
    for name, (start, end) in zip(particles.names, particles.ranges, strict=True):
        wall = first <= start < end <= last
        if wall and hidden_share(particles.positions[start:end] @ axes.T, local, cell) > HIDDEN:
            found.append(name)
    return found


def _fluid_positions(everything: np.ndarray, fluid: np.ndarray, up: int) -> np.ndarray:
    """Points all over the scene, at the heights of the fluid, shape [PLACES^3, 3]."""
    low, high = everything.min(axis=0), everything.max(axis=0)
    low[up], high[up] = fluid[:, up].min(), fluid[:, up].max()
    lines = [np.linspace(low[axis], high[axis], PLACES) for axis in range(3)]
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)

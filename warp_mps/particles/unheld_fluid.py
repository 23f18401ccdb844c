"""Fluid that nothing holds at the start: drawn beside its tank, or where a side or a floor is missing.

Gravity makes a particle fall that has no body and no wall below it; and one that stands on something runs out along a
horizontal axis of the scene in whose direction nothing stands at its height. Both are looked for in columns along the
axes of the scene, two spacings wide.
"""

from __future__ import annotations

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene
from warp_mps.scene.validation.rules import place

# in spacings: how near to the solid below it a particle stands on it; width of the columns
STANDS, WIDTH = 1.5, 2.0
# cosine between gravity and an axis of the scene from which on gravity lies along it
ALONG = 0.999


def remarks_on_unheld_fluid(scene: Scene, particles: Particles) -> list[str]:
    """A line for each fluid that falls or runs out of the scene; none without walls or gravity along an axis."""
    direction = gravity_axis(scene)
    if not scene.walls or direction is None:
        return []
    vertical, downwards = direction
    solids = particles.positions[: particles.count - particles.liquid]
    lines = []
    for fluid in scene.fluids:
        first, last = particles.ranges[particles.names.index(fluid.name)]
        x, spacing = particles.positions[first:last], fluid.spacing
        depth = distance_to_solid(solids, x, vertical, downwards, spacing)
        falls = np.isinf(depth) & (vertical not in scene.flow.periodic)
        where = place(fluid, "fluid")
        if falls.any():
            at = _point(x[np.argmax(falls)])
            lines.append(f"{where}: {falls.sum()} particles have nothing below them, as at {at} m: they fall out")
        for axis in (k for k in range(scene.dimension) if k != vertical and k not in scene.flow.periodic):
            stands = np.flatnonzero(depth < STANDS * spacing)
            for side in (-1, 1):
                away = np.isinf(distance_to_solid(solids, x[stands], axis, side, spacing))
                if away.any():
                    end = f"{'low' if side < 0 else 'high'} {scene.frame.axes[axis]}"
                    at = _point(max(x[stands[away]], key=lambda point: side * point[axis]))
                    lines.append(f"{where}: nothing holds it towards {end}, as at {at} m: move it, or add a wall there")
    return lines


def gravity_axis(scene: Scene) -> tuple[int, int] | None:
    """The axis of the scene along which gravity acts, and its sign; None if it acts along none."""
    gravity = scene.gravity_vector
    size = float(np.linalg.norm(gravity))
    if size == 0.0 or np.abs(gravity).max() < ALONG * size:
        return None
    vertical = int(np.argmax(np.abs(gravity)))
    return vertical, int(np.sign(gravity[vertical]))


def distance_to_solid(solids: np.ndarray, x: np.ndarray, axis: int, side: int, spacing: float) -> np.ndarray:
    """Distance along an axis, to one side, to the nearest solid particle in the same column of cells [m], shape [n].

    Args:
        solids: Positions of solid particles [m], shape [m, d].
        x: Positions to look from [m], shape [n, d].
        axis: The axis along which to look.
        side: 1 towards greater coordinates, -1 towards smaller ones.
        spacing: Particle spacing l0 [m].
    """
    distance = np.full(len(x), np.inf)
    if not len(solids) or not len(x):
        return distance
    both = np.concatenate((solids, x))
    cells = np.floor(np.delete(both, axis, axis=1) / (WIDTH * spacing)).astype(np.int64)
    column = np.unique(cells, axis=0, return_inverse=True)[1].reshape(-1)
    along = side * both[:, axis]
    # a column and the place in it as one number, which sorts
    low, reach = along.min(), 2.0 * np.ptp(along) + spacing
    keys = column + (along - low) / reach
    there, here = np.sort(keys[: len(solids)]), keys[len(solids) :]
    following = np.searchsorted(there, here)
    found = np.flatnonzero(following < len(there))
    beyond = there[following[found]]
    same = np.floor(beyond) == column[len(solids) :][found]
    distance[found[same]] = (beyond[same] - here[found[same]]) * reach
    return distance


def _point(position: np.ndarray) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in position) + ")"

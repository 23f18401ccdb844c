"""A point that is fixed to a wall, found from where the wall's particles are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warp_mps.observers.base import View
from warp_mps.particles.particles import Particles

# particles of the wall that are used: few are enough, since a wall is rigid
LOOKED_AT = 64


def rigid_point(particles: Particles, wall: str, point: np.ndarray) -> Callable[[View], np.ndarray]:
    """A function for the position of a point of a wall at a moment.

    Args:
        particles: The particles.
        wall: Name of the wall.
        point: The point of the undisplaced scene [m], shape [d]; it need not lie in the wall.

    Returns:
        Position [m], shape [d], of a view.
    """
    first, last = particles.ranges[particles.names.index(wall)]
    chosen = np.unique(np.linspace(first, last - 1, min(last - first, LOOKED_AT)).astype(int))
    reference = particles.positions[chosen]
    centre = reference.mean(axis=0)

    def locate(view: View) -> np.ndarray:
        present = view.positions[chosen]
        if np.array_equal(present, reference):
            return point
        middle = present.mean(axis=0)
        return middle + _turn(reference - centre, present - middle) @ (point - centre)

    return locate


def _turn(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The rotation that best turns arms [k, d] into others (Kabsch, Acta Cryst. A 32 (1976) 922), shape [d, d]."""
    left, _, right = np.linalg.svd(after.T @ before)
    sign = np.ones(len(left))
    # never a reflection: a wall that is flat or one particle thin leaves the last direction to this
    sign[-1] = np.sign(np.linalg.det(left @ right))
    return (left * sign) @ right

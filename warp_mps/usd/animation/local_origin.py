"""Where the coordinates of an animation begin: points are in single precision, which a scene far away would use up."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.particles.particles import Particles

if TYPE_CHECKING:
    from warp_mps.scene import StageFrame

# rounding of coordinates, in spacings, up to which points stay in the stage's own coordinates
COARSEST = 1e-3
# distance of the middle of the particles, in half extents, from which a local origin makes coordinates finer
FAR = 4.0


def local_origin(particles: Particles, frame: StageFrame) -> np.ndarray:
    """Origin of the points of an animation [stage units], shape [3]; 0 unless the particles lie far from it.

    It is the middle of the particles, rounded to a multiple of a power of two above their extent, so that coordinates
    relative to it are exact in double precision.

    Args:
        particles: Particles of the scene.
        frame: How the scene lies in its stage.
    """
    origin = np.zeros(3)
    if not len(particles.positions):
        return origin
    low, high = particles.positions.min(axis=0), particles.positions.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * float((high - low).max())
    finest, spacing = np.finfo(np.float32).eps, float(particles.spacings.min())
    far = float(np.abs(middle).max())
    if far * finest <= COARSEST * spacing or far <= FAR * half:
        return origin
    unit = frame.meters_per_unit
    step = 2.0 ** math.ceil(math.log2(max(2.0 * half, spacing) / unit))
    origin[["xyz".index(axis) for axis in frame.axes]] = np.round(middle / unit / step) * step
    return origin

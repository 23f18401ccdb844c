"""The camera of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_mps.app.view.spheres import Spheres
from warp_mps.usd.animation.viewpoint import SLOPE

# the share of the picture's field that the scene fills
FILLED = 0.96


@dataclass(frozen=True)
class Camera:
    """A camera before a scene.

    Attributes:
        axes: The picture's right, its top and the direction to the viewer, as rows, shape [3, 3].
        target: Point in the middle of the picture [stage units], shape [3].
        scale: Pixels per stage unit at the target [px].
        middle: Column and row of the target [px].
        distance: Distance of the camera from the target [stage units], infinite for a plane.
    """

    axes: np.ndarray
    target: np.ndarray
    scale: float
    middle: tuple[float, float]
    distance: float = np.inf

    def see(self, points: np.ndarray, widths: np.ndarray) -> Spheres:
        """Particles as the camera sees them.

        Args:
            points: Positions [stage units], shape [n, 3].
            widths: Widths [stage units], shape [n].
        """
        local = (points - self.target) @ self.axes.T
        # those that are behind it are put out of the picture
        ahead = 1.0 - local[:, 2] / self.distance
        scale = self.scale / np.where(ahead > 0.01, ahead, np.nan)
        centres = np.array(self.middle) + scale[:, None] * local[:, :2] * [1.0, -1.0]
        centres = np.nan_to_num(centres, nan=-1e9)
        radii = np.nan_to_num(0.5 * scale * widths, nan=1.0)
        return Spheres(centres, -local[:, 2], radii, 0.5 * widths)


def frame_points(
    axes: np.ndarray, points: np.ndarray, widths: np.ndarray, field: tuple[float, float, float, float], *, flat: bool
) -> Camera:
    """A camera that has all particles in a field of the picture.

    Args:
        axes: Its axes, shape [3, 3].
        points: Positions [stage units], shape [n, 3].
        widths: Widths [stage units], shape [n].
        field: Left, top, right and bottom of the field [px].
        flat: Whether it looks from infinitely far.
    """
    left, top, right, bottom = field
    size, middle = FILLED * np.array([right - left, bottom - top]), (0.5 * (left + right), 0.5 * (top + bottom))
    local, half = points @ axes.T, 0.5 * widths[:, None]
    low, high = (local - half).min(axis=0), (local + half).max(axis=0)
    target = 0.5 * (low + high)
    scale = float(np.min(size / np.maximum(high - low, 1e-30)[:2]))
    if flat:
        return Camera(axes, target @ axes, scale, middle)
    reach = float(np.linalg.norm(high - low)) / 2.0
    for _ in range(8):
        distance = reach / SLOPE
        moved = local - target
        ahead = distance / (distance - moved[:, 2:])
        low2 = ((moved[:, :2] - half) * ahead).min(axis=0)
        high2 = ((moved[:, :2] + half) * ahead).max(axis=0)
        target[:2] += 0.5 * (low2 + high2)
        scale = float(np.min(size / (high2 - low2)))
    return Camera(axes, target @ axes, scale, middle, reach / SLOPE)

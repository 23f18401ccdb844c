"""The direction from which a scene is viewed."""

from __future__ import annotations

import numpy as np

# direction to a camera in space, along the scene's right, up and towards
VIEW = (0.5, 0.38, 1.0)
# half the angle of view, as a slope
SLOPE = 0.2


def plane_axes(normal: int, up: int) -> np.ndarray:
    """A camera's right, top and direction to the viewer, as rows, before a plane, shape [3, 3].

    Args:
        normal: The stage's axis that is normal to the plane.
        up: The stage's axis that is up, also in the picture if it lies in the plane.
    """
    others = [axis for axis in range(3) if axis != normal]
    top = up if up in others else others[-1]
    right = next(axis for axis in others if axis != top)
    rows = np.eye(3)[[right, top]]
    return np.array([*rows, np.cross(*rows)])


def space_axes(up: int, view: np.ndarray | None = None) -> np.ndarray:
    """A camera's right, top and direction to the viewer, as rows, in a 3-D scene, shape [3, 3].

    Args:
        up: The stage's axis that is up.
        view: Direction from the scene to the camera, shape [3]; None looks obliquely from above.
    """
    right, height, towards = VIEW
    if view is None:
        view = np.array([right, height, towards] if up == 1 else [right, -towards, height])
    towards_eye = view / np.linalg.norm(view)
    # seen from straight above, the next axis is up in the picture
    top = np.eye(3)[up if abs(towards_eye[up]) < 0.999 else (up + 1) % 3]
    across = np.cross(top, towards_eye)
    across /= np.linalg.norm(across)
    return np.array([across, np.cross(towards_eye, across), towards_eye])

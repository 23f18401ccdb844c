"""Where a run takes place: its plane or space, the box around it, and what of it a picture should show.

Places are positions by the number of a cloud, shape [frames, n, dimension].
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

# a part of a run that flies off further than this many sizes of the rest is left out of the picture
FAR = 1.0
# percentage of a fluid's particles that may leave the picture at either side
DROPS = 0.2


def axes_of(points: Mapping[int, np.ndarray], up_axis: str) -> str:
    """The stage's axes along which the scene lies; in a plane the one to the right, then the one upwards."""
    flat = [all(np.ptp(value[..., axis]) == 0.0 for value in points.values()) for axis in range(3)]
    if not any(flat):
        return "xyz"
    up = up_axis.lower()
    # a row of particles is flat along two axes: the plane is then any that holds it
    normal = next((axis for axis in ("zyx" if up == "y" else "yxz") if flat["xyz".index(axis)]), "z")
    rest = [axis for axis in "xyz" if axis != normal]
    return "".join(sorted(rest, key=lambda axis: axis == up))


def box_of(places: Mapping[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a box around all particles, without those that fly far off [m]."""
    every = np.concatenate([_somewhere(value) for value in places.values()])
    if not len(every):
        return np.zeros(every.shape[1]), np.ones(every.shape[1])
    inner = np.percentile(every, [0.2, 99.8], axis=0)
    reach = FAR * max(float(np.ptp(inner, axis=0).max()), 1e-12)
    low, high = np.maximum(every.min(axis=0), inner[0] - reach), np.minimum(every.max(axis=0), inner[1] + reach)
    return low.astype(float), high.astype(float)


def seen_of(places: Mapping[int, np.ndarray], fluids: list[int]) -> np.ndarray:
    """The corners of what a picture should show: everything but single drops that fly far, shape [2, dimension]."""
    corners = []
    for number, value in places.items():
        every, off = _somewhere(value), DROPS if number in fluids else 0.0
        if len(every):
            corners.append(np.percentile(every, [off, 100.0 - off], axis=0))
    return np.array([np.min(corners, axis=0)[0], np.max(corners, axis=0)[1]]) if corners else np.array(box_of(places))


def _somewhere(places: np.ndarray) -> np.ndarray:
    """The places that are any, shape [n, dimension]."""
    every = places.reshape(-1, places.shape[-1])
    return every[np.isfinite(every).all(axis=1)]

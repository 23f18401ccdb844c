"""Named initial velocity fields: shapes of vibration along an axis.

References:
    Rao, S. S., Mechanical Vibrations, 5th ed., section 8.5 (transverse vibration of beams).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from warp_mps.scene import VelocityField


def velocity(field: VelocityField, positions: np.ndarray) -> np.ndarray:
    """Velocity of each particle in a named field.

    Args:
        field: The field.
        positions: Reference positions [m], shape [n, d].

    Returns:
        Velocities [m/s], shape [n, d].
    """
    axis = np.asarray(field.axis, float)
    along = (positions - np.asarray(field.origin, float)) @ (axis / np.linalg.norm(axis)) / field.length
    return np.outer(_SHAPES[field.kind](along, field.mode), np.asarray(field.amplitude, float))


def beam_root(ends: str, mode: int) -> float:
    """The root beta L of a uniform beam's frequency equation.

    cos(b) cosh(b) = 1 for ``free_free_beam``, -1 for ``clamped_free_beam`` (Rao, table 8.4).
    """
    sign = 1.0 if ends == "free_free_beam" else -1.0
    root = (mode + 0.5) * math.pi if sign > 0 else (mode - 0.5) * math.pi
    for _ in range(50):  # Newton on cos(b) - sign / cosh(b), which stays of order one where cosh(b) does not
        value = math.cos(root) - sign / math.cosh(root)
        slope = -math.sin(root) + sign * math.sinh(root) / math.cosh(root) ** 2
        root -= value / slope
    return root


def _sine(along: np.ndarray, mode: int) -> np.ndarray:
    return np.sin(mode * math.pi * along)


def _free_free(along: np.ndarray, mode: int) -> np.ndarray:
    b = beam_root("free_free_beam", mode)
    ratio = (math.cosh(b) - math.cos(b)) / (math.sinh(b) - math.sin(b))
    return _normalized(along, b, lambda s: np.cosh(s) + np.cos(s) - ratio * (np.sinh(s) + np.sin(s)))


def _clamped_free(along: np.ndarray, mode: int) -> np.ndarray:
    b = beam_root("clamped_free_beam", mode)
    ratio = (math.cosh(b) + math.cos(b)) / (math.sinh(b) + math.sin(b))
    return _normalized(along, b, lambda s: np.cosh(s) - np.cos(s) - ratio * (np.sinh(s) - np.sin(s)))


def _normalized(along: np.ndarray, root: float, shape: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    return shape(root * along) / shape(np.asarray(root))


_SHAPES = {"sine": _sine, "free_free_beam": _free_free, "clamped_free_beam": _clamped_free}

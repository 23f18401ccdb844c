"""Conversion between linear colours, which USD stores, and sRGB colours (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def srgb_to_linear(screen: ArrayLike) -> np.ndarray:
    """Linear colours from sRGB colours, from 0 to 1."""
    screen = np.asarray(screen, dtype=float)
    return np.where(screen <= 0.04045, screen / 12.92, ((np.maximum(screen, 0.0) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(light: ArrayLike) -> np.ndarray:
    """SRGB colours from linear colours, from 0 to 1."""
    light = np.asarray(light, dtype=float)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0) ** (1.0 / 2.4) - 0.055)

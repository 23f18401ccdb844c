"""Colours: USD's are amounts of light, those that people choose are as screens take them (sRGB, IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def to_light(screen: ArrayLike) -> np.ndarray:
    """Amounts of light of colours as screens take them, from 0 to 1."""
    screen = np.asarray(screen, dtype=float)
    return np.where(screen <= 0.04045, screen / 12.92, ((np.maximum(screen, 0.0) + 0.055) / 1.055) ** 2.4)


def to_screen(light: ArrayLike) -> np.ndarray:
    """Colours as screens take them, of amounts of light from 0 to 1."""
    light = np.asarray(light, dtype=float)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0) ** (1.0 / 2.4) - 0.055)

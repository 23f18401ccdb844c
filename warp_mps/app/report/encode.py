"""Numbers as short text: whole numbers of 8 or 16 bits, differences in time, zlib, base64.

An array of whole numbers q, shape [frames, n], is written as its differences along the frames, taken `order` times
(modulo 2^16, the first frame against 0); zigzag code makes small negative differences small numbers, and their low and
high bytes stand apart. ``page/data.js`` reads it.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass

import numpy as np

# a position that is not there: not finite, or outside the box
MISSING = 65535


@dataclass(frozen=True)
class Packed:
    """An array of whole numbers as text.

    Attributes:
        order: Number of times that differences were taken.
        text: Base64 of zlib's format.
    """

    order: int
    text: str


def quantize(values: np.ndarray, low: np.ndarray | float, high: np.ndarray | float, top: int) -> np.ndarray:
    """Numbers from `low` to `high` as whole numbers from 0 to `top`, uint16, clipped; not finite ones are 0."""
    scale = np.where(np.asarray(high) > low, top / np.maximum(np.subtract(high, low), 1e-300), 0.0)
    scaled = np.nan_to_num((values - low) * scale, nan=0.0, posinf=top, neginf=0.0)
    return np.clip(np.rint(scaled), 0, top).astype(np.uint16)


def pack(numbers: np.ndarray) -> Packed:
    """Pack an array, uint16, shape [frames, n], with the differences that make it shortest."""
    found = []
    differences = numbers
    for order in range(3):
        data = _planes(differences)
        found.append((len(data), order, data))
        differences = np.diff(differences, axis=0, prepend=np.zeros_like(differences[:1]))
    _, order, data = min(found)
    return Packed(order, base64.b64encode(data).decode("ascii"))


def _planes(numbers: np.ndarray) -> bytes:
    signed = numbers.astype(np.uint16).view(np.int16)
    codes = ((signed << 1) ^ (signed >> 15)).view(np.uint16)
    low, high = (codes & 255).astype(np.uint8), (codes >> 8).astype(np.uint8)
    return zlib.compress(low.tobytes() + high.tobytes(), 6)

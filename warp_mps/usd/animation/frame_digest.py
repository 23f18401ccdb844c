"""A running digest of the frames of an animation, by which a continued run knows its own frames again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np


class FrameDigest:
    """Counts frames and hashes their time codes and arrays, one after the other."""

    def __init__(self) -> None:
        self._hash, self._count = hashlib.sha256(), 0
        self._last: float | None = None

    def add(self, code: float, bodies: Iterable[tuple[str, Mapping[str, np.ndarray]]]) -> None:
        """Add a frame; a frame at the time code of the one before is the same.

        Args:
            code: Its time code.
            bodies: Name of each body and its arrays by the names of the attributes.
        """
        if code == self._last:
            return
        self._last, self._count = code, self._count + 1
        self._hash.update(f"{float(code)!r}\n".encode())
        for body, values in bodies:
            for name in sorted(values):
                # USD saves arrays once that are equal, of 0.0 and -0.0, too
                array = np.ascontiguousarray(values[name]) + values[name].dtype.type(0)
                self._hash.update(f"{body}.{name} {array.dtype.str} {array.shape}\n".encode())
                self._hash.update(array.tobytes())

    def mark(self) -> dict[str, Any]:
        """The number of frames and their digest."""
        return {"count": self._count, "sha256": self._hash.hexdigest()}


def digest_of(bodies: Iterable[Any], layer: Any, codes: Iterable[float]) -> FrameDigest:
    """The digest of the frames of a layer at some time codes; `bodies` are its prims in the order of the particles."""
    found, prims = FrameDigest(), list(bodies)
    for code in codes:
        found.add(code, [(prim.name, _samples(prim, layer, code)) for prim in prims])
    return found


def _samples(prim: Any, layer: Any, code: float) -> dict[str, np.ndarray]:
    samples = {item.name: layer.QueryTimeSample(item.path, code) for item in prim.attributes}
    return {name: np.array(value) for name, value in samples.items() if value is not None}

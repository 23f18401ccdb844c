"""Whether the numbers of a scene lie in the ranges that stand at its fields (`warp_mps.scene.fields`)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from warp_mps.scene.fields import Attribute, attributes_of
from warp_mps.scene.validation.rules import in_range, positive, require
from warp_mps.shapes.numbers import is_number


def check_limits(record: Any, where: str) -> None:
    """Check the numbers of a record of a scene, but not those of the records in it.

    Args:
        record: A scene, or a part of one.
        where: Its name in error messages.

    Raises:
        InputError: A number is out of its range.
    """
    for name, known in attributes_of(type(record)).items():
        value = getattr(record, name)
        if is_number(value) and not isinstance(value, np.ndarray):
            _check(float(value), known, where, name)


def _check(value: float, known: Attribute, where: str, attribute: str) -> None:
    if known.allowed:
        words = ", ".join(str(number) for number in known.allowed)
        require(value in known.allowed, where, attribute, f"is {value:g}, must be one of: {words}")
    elif known.above == 0.0 and known.maximum is None:
        positive(value, where, attribute)
    elif known.minimum is not None:
        high = math.inf if known.maximum is None else known.maximum
        in_range(value, known.minimum, high, where, attribute)
    elif known.above is not None and known.maximum is not None:
        reason = f"is {value:g}, must be above {known.above:g} and at most {known.maximum:g}"
        require(known.above < value <= known.maximum, where, attribute, reason)
    elif known.finite:
        require(math.isfinite(value), where, attribute, f"is {value:g}, must be finite")

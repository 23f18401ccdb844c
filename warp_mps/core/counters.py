"""Counters of a checkpoint, which may come from anywhere."""

from __future__ import annotations

import numpy as np

# counters in double precision are exact up to here
MOST = 2.0**53


def whole_numbers(values: np.ndarray) -> list[int]:
    """Counters as integers.

    Raises:
        ValueError: One of them is no whole number of 0 or more.
    """
    found = np.asarray(values, float).ravel()
    if not ((found >= 0.0) & (found <= MOST) & (found == np.floor(found))).all():
        raise ValueError(f"counters are {found.tolist()}, must be whole numbers of 0 or more")
    return [int(value) for value in found]


def require_within(name: str, values: np.ndarray, most: int) -> None:
    """Require integers, such as flags or indices, from 0 up to the largest that there is.

    Raises:
        ValueError: One of them is not.
    """
    wrong = np.flatnonzero((values < 0) | (values > most))
    if len(wrong):
        raise ValueError(f"{name} holds {values.ravel()[wrong[0]]}, must be 0 to {most}")

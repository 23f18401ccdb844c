"""Numbers and vectors in the fields of shapes and scenes."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import InputError


def is_number(value: object) -> bool:
    """Whether a value is a single number of any type.

    A text is not, even if it reads as a number, nor is a whole number that is too large for a float.
    """
    if isinstance(value, str | bytes):
        return False
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return False
    return True


def as_array(values: object) -> np.ndarray:
    """Numbers as an array; an empty array of anything else."""
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0)


def shown(value: object) -> str:
    """A value as it is written, or its type where Python does not write it: a whole number of thousands of digits."""
    try:
        return repr(value)
    except ValueError:
        return f"{type(value).__name__} of an excessive size"


def as_vector(
    values: object, where: str, name: str, *, depth: float = 0.0, finite: bool = False
) -> tuple[float, float, float]:
    """Three numbers of a field that may be given with 2.

    Args:
        values: 2 or 3 numbers.
        where: Owner of the field, for error messages.
        name: Name of the field.
        depth: The third number where 2 are given.
        finite: Whether infinite numbers are refused.

    Raises:
        InputError: It is not 2 or 3 numbers, or not finite ones.
    """
    given = as_array(values)
    good = np.isfinite(given) if finite else ~np.isnan(given)
    if given.shape not in ((2,), (3,)) or not good.all():
        raise InputError(where, name, f"must be 2 or 3 {'finite ' if finite else ''}numbers, not {shown(values)}")
    x, y, *z = given.tolist()
    return x, y, z[0] if z else depth

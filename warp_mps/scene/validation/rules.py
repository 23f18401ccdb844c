"""Checks of numbers, words and vectors; each raises an error of one line with its place and field."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from warp_mps.errors import InputError

if TYPE_CHECKING:
    from warp_mps.scene import Body, BodyForce, Fluid, Load, Measurement, Part, Probe, Support, Wall


# of any number, in SI units: beyond it, and below its inverse, products of a few numbers overflow or underflow
LARGEST = 1e60

# relative difference up to which spacings, or multiples of them, are the same
SAME = 1e-6


def place(item: Body | Part | Wall | Fluid | Support | Load | BodyForce | Probe | Measurement, kind: str) -> str:
    """How an error names an item: its path, or its kind and name where it has none."""
    return item.path or f"{kind} '{item.name}'"


def kind_of(item: Body | Wall | Fluid) -> Literal["body", "wall", "fluid"]:
    """How an error names a body, wall or fluid: ``body``, ``wall`` or ``fluid``."""
    return "body" if hasattr(item, "material") else "wall" if hasattr(item, "slip") else "fluid"


def require(good: bool | np.bool_, where: str, attribute: str, reason: str) -> None:
    """Raise an error with the place, the attribute and the reason unless a condition holds.

    Raises:
        InputError: It is not.
    """
    if not good:
        raise InputError(where, attribute, reason)


def positive(value: float, where: str, attribute: str) -> None:
    """Refuse a number that is not finite and above 0, or that is absurdly small or large.

    Raises:
        InputError: It is.
    """
    value = float(value)  # a single-precision number has no room for the limits
    require(math.isfinite(value) and value > 0.0, where, attribute, f"is {value:g}, must be finite and above 0")
    good = 1.0 / LARGEST <= value <= LARGEST
    require(good, where, attribute, f"is {value:g}, must be between {1.0 / LARGEST:g} and {LARGEST:g}")


def in_range(value: float, low: float, high: float, where: str, attribute: str) -> None:
    """Refuse a number that is not between two others, these included.

    Raises:
        InputError: It is.
    """
    value = float(value)
    good = math.isfinite(value) and low <= value <= min(high, LARGEST)
    limits = f"at least {low:g}" if math.isinf(high) else f"between {low:g} and {high:g}"
    require(good, where, attribute, f"is {value:g}, must be finite and {limits}")


def choice(value: str, choices: Sequence[str], where: str, attribute: str) -> None:
    """Refuse a word that is not one of the choices.

    Raises:
        InputError: It is.
    """
    require(value in choices, where, attribute, f"is {value!r}, must be one of: {', '.join(choices)}")


def named(name: str, known: Sequence[str], where: str, attribute: str, kind: str) -> None:
    """Refuse a name that no item of a kind has, and list those that there are.

    Raises:
        InputError: There is no such name.
    """
    options = f"one of: {', '.join(known)}" if known else "the scene has none"
    require(name in known, where, attribute, f"is {name!r}, must name a {kind}: {options}")


def vector(value: Sequence[float] | np.ndarray, size: int, where: str, attribute: str) -> None:
    """Refuse a vector that does not hold the given number of finite numbers.

    Raises:
        InputError: It is.
    """
    array = np.asarray(value, float)
    good = array.shape == (size,) and bool(np.all(np.isfinite(array)))
    require(good, where, attribute, f"is {tuple(array.tolist())}, must be {size} finite numbers")
    reason = f"is {tuple(array.tolist())}, must be {size} numbers of at most {LARGEST:g} in size"
    require(bool(np.all(np.abs(array) <= LARGEST)), where, attribute, reason)

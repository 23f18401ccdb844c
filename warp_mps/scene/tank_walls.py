"""The walls of a rectangular tank."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from warp_mps.errors import InputError
from warp_mps.scene.bodies import Wall
from warp_mps.scene.choices import WallSlipName
from warp_mps.scene.motions import HarmonicMotion, HarmonicRotation, TableMotion, TableRotation
from warp_mps.shapes import Box
from warp_mps.shapes.numbers import as_array, is_number, shown

SideName = Literal["left", "right", "bottom", "top", "front", "back"]
# the sides at the low and the high end of the axes x, y, z, by the axis that points up, seen with x to the right
SIDES: dict[str, tuple[tuple[SideName, SideName], ...]] = {
    "y": (("left", "right"), ("bottom", "top"), ("back", "front")),
    "z": (("left", "right"), ("front", "back"), ("bottom", "top")),
}


def tank(
    low: Sequence[float],
    high: Sequence[float],
    spacing: float,
    *,
    layers: int = 3,
    open: Sequence[SideName] = ("top",),
    up: Literal["y", "z"] = "y",
    name: str = "",
    motion: HarmonicMotion | TableMotion | None = None,
    rotation: HarmonicRotation | TableRotation | None = None,
    friction: float | None = None,
    slip: WallSlipName = "free",
) -> tuple[Wall, ...]:
    """The walls of a rectangular tank, whose inner faces lie exactly at its corners.

    The walls are ``bottom``, ``top``, ``left``, ``right`` and, in 3-D, ``front`` and ``back``, but for the open ones.
    They meet without sharing space: bottom and top reach out below and above the others. A box of water
    fits between them whatever their lengths; a level between two rows of particles is remarked.

    Args:
        low: Inner corner with the least coordinates [m], 2 or 3 numbers: a tank of a 2-D or of a 3-D scene.
        high: Inner corner with the greatest coordinates [m], as many numbers.
        spacing: Particle spacing l0 [m], that of the fluid.
        layers: Rows of particles across a wall. In 2-D, 3 keep the fluid on its two sides apart.
        open: Sides without a wall.
        up: Axis that points up, ``y`` or ``z``, which names the sides: ``front`` is at high z if y is up, and at low y
            if z is.
        name: Prefix of the names of the walls: ``name="basin_"`` makes ``basin_left`` and so on.
        motion: Prescribed displacement of all of them.
        rotation: Prescribed rotation of all of them.
        friction: Coefficient of friction of bodies on them [-]; None is that of `Contact`.
        slip: ``free`` or ``no``, as of a `Wall`.

    Returns:
        The walls.

    Raises:
        InputError: The corners, the spacing or the number of layers are impossible, a side is unknown, or all are open.
    """
    where = f"tank {name.rstrip('_')!r}" if name else "tank"
    lower, upper = _corners(low, high, where)
    dimension = len(lower)
    _check_numbers(spacing, layers, where)
    if up not in SIDES or (dimension == 2 and up != "y"):
        raise InputError(where, "up", f"is {up!r}, must be {'y' if dimension == 2 else 'y or z'}")
    sides = SIDES[up][:dimension]
    known = [side for pair in sides for side in pair]
    if not isinstance(open, str | tuple | list):
        raise InputError(where, "open", f"is {open!r}, must be names of sides among {', '.join(known)}")
    for side in [open] if isinstance(open, str) else open:
        if side not in known:
            raise InputError(where, "open", f"names no side: {side!r}; there are {', '.join(known)}")
    if set(known) <= set(open):
        raise InputError(where, "open", "leaves no wall")
    walls = []
    # extent of the next walls: the inner box and the walls around it that are still to come
    outer = np.array([lower, upper])
    thickness = layers * spacing
    for axis in range(dimension):
        for end, sign in ((0, -1.0), (1, 1.0)):
            if sides[axis][end] not in open:
                outer[end, axis] += sign * thickness
    for axis in sorted(range(dimension), key=lambda k: k != "xyz".index(up)):
        for end, side in enumerate(sides[axis]):
            if side in open:
                continue
            corners = outer.copy()
            corners[1 - end, axis] = (lower, upper)[end][axis]
            wall = Wall(
                name=f"{name}{side}",
                shape=Box.from_corners(*corners.tolist()),
                spacing=spacing,
                motion=motion,
                rotation=rotation,
                friction=friction,
                slip=slip,
            )
            walls.append(wall)
        outer[:, axis] = lower[axis], upper[axis]
    return tuple(walls)


def _corners(low: Sequence[float], high: Sequence[float], where: str) -> tuple[np.ndarray, np.ndarray]:
    lower, upper = as_array(low), as_array(high)
    good = lower.shape == upper.shape and lower.shape in ((2,), (3,))
    if not good or not np.isfinite([lower, upper]).all() or not (upper > lower).all():
        reason = (
            f"are {shown(low)} and {shown(high)}, must be 2 or 3 finite numbers each, high above low along every axis"
        )
        raise InputError(where, "low, high", reason)
    return lower, upper


def _check_numbers(spacing: float, layers: int, where: str) -> None:
    if not (is_number(spacing) and 0.0 < spacing < np.inf):
        raise InputError(where, "spacing", f"is {shown(spacing)}, must be finite and above 0")
    if not (isinstance(layers, int | np.integer) and layers >= 1):
        raise InputError(where, "layers", f"is {shown(layers)}, must be a whole number of at least 1")

"""A fluid that fills a tank, or a region, up to a level."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from warp_mps.errors import InputError
from warp_mps.scene.bodies import Fluid, Wall
from warp_mps.scene.materials import Liquid
from warp_mps.scene.validation.rules import SAME, place
from warp_mps.shapes import Box, Shape, contains
from warp_mps.shapes.numbers import is_number, shown

REMEDY = "give the region of the fluid as a shape: inside=Box.from_corners(low, high), or inside=Mesh.from_file(path)"


def fill_to(
    level: float,
    inside: Sequence[Wall] | Shape,
    *,
    spacing: float | None = None,
    liquid: Liquid = Liquid(),
    name: str = "water",
    up: Literal["y", "z"] = "y",
) -> Fluid:
    """A fluid at rest that fills a tank of walls, or a region, up to a level.

    Args:
        level: Coordinate of the free surface along the axis that points up [m].
        inside: The walls of a rectangular tank, such as `tank` makes; or the region that the fluid may fill, of any
            shape, which is cut at the level. Bodies and walls in it need not be left out: the fluid gives way to them.
        spacing: Particle spacing l0 [m]; None is that of the walls.
        liquid: Its density and viscosity; water by default.
        name: Name of the fluid.
        up: Axis that points up, ``y`` or ``z``.

    Returns:
        The fluid. In a tank its particles lie evenly between the walls, and begin at the bottom; where the depth is no
        whole number of their distances, `check` remarks how far from the level the uppermost ones end.

    Raises:
        InputError: The level is not in the tank or the region, or the walls are not boxes along the axes that hold the
            fluid up to the level; the reason then tells where it would run out.
    """
    where = f"fluid {name!r}"
    if not (is_number(level) and np.isfinite(float(level))):
        raise InputError(where, "level", f"is {level!r:.80}, must be a finite number")
    if up not in ("y", "z"):
        raise InputError(where, "up", f"is {up!r}, must be y or z")
    walls = tuple(inside) if isinstance(inside, tuple | list) else ()
    if not isinstance(inside, Shape) and not (walls and all(isinstance(wall, Wall) for wall in walls)):
        raise InputError(where, "inside", f"must be the walls of a tank, in a tuple, or a shape, not {inside!r:.80}")
    if spacing is None:
        if not walls:
            raise InputError(where, "spacing", "must be given for a region that is a shape")
        spacing = walls[0].spacing
    if not (is_number(spacing) and 0.0 < spacing < np.inf):
        raise InputError(where, "spacing", f"is {shown(spacing)}, must be finite and above 0")
    vertical = "xyz".index(up)
    if isinstance(inside, Shape):
        shape = below_level(inside, float(level), vertical, where)
    else:
        shape = _room(walls, float(level), vertical, spacing, where)
    return Fluid(name=name, shape=shape, spacing=spacing, liquid=liquid)


def below_level(region: Shape, level: float, up: int, where: str) -> Shape:
    """The part of a region below a level, on a lattice that begins at the region's lowest point.

    Args:
        region: The region, of any shape with an inside.
        level: Coordinate of the level [m].
        up: The axis along which it is measured: 1 is y, 2 is z.
        where: Owner of the region, for error messages.

    Returns:
        A box if the region is one along the scene's axes, else its intersection with one.

    Raises:
        InputError: The region is ready-made particles, or the level does not lie in it.
    """
    if not region.is_region:
        raise InputError(where, "level", "is for a shape with an inside, not for ready-made particles")
    intervals = [region.interval(axis) for axis in np.eye(3)]
    low, high = intervals[up]
    if not low < level <= high + SAME * (high - low):
        reason = f"is {level:g} m, must lie in the region, which reaches from {low:g} to {high:g} m"
        raise InputError(where, "level", reason)
    intervals[up] = (low, min(level, high))
    size = tuple(float(b - a) for a, b in intervals)
    # an infinitely deep region has no centre along z
    center = tuple(float(0.5 * (a + b)) if np.isfinite([a, b]).all() else 0.0 for a, b in intervals)
    below = Box(size, center)
    return below if isinstance(region, Box) and region.placement is None else below & region


def _room(walls: tuple[Wall, ...], level: float, up: int, spacing: float, where: str) -> Box:
    """The box between the walls of a tank, from its bottom to the level."""
    for wall in walls:
        if not isinstance(wall.shape, Box) or wall.shape.placement is not None:
            reason = f"{place(wall, 'wall')} is not a box along the axes; {REMEDY}"
            raise InputError(where, "inside", reason)
    middle, half = (np.array([getattr(wall.shape, name) for wall in walls]) for name in ("center", "size"))
    dimension = 3 if np.isfinite(half).all() else 2
    if up >= dimension:
        raise InputError(where, "up", "is 'z', but the walls are of a 2-D scene, where y points up")
    low, high = (middle - 0.5 * half)[:, :dimension], (middle + 0.5 * half)[:, :dimension]
    margin = 1e-3 * spacing
    seed = 0.5 * (low.min(0) + high.max(0))
    corners = np.array([seed, seed])
    corners[:, up] = _bottom(low, high, seed, up, level, where), level
    seed[up] = 0.5 * corners[:, up].sum()
    for axis in (k for k in range(dimension) if k != up):
        beside = np.all(np.delete((low < seed) & (high > seed), axis, axis=1), axis=1)
        below, above = high[beside, axis] <= seed[axis], low[beside, axis] >= seed[axis]
        if not below.any() or not above.any():
            end = "high" if below.any() else "low"
            reason = f"have none at the {end} end of {'xyz'[axis]}: the fluid would run out there; {REMEDY}"
            raise InputError(where, "inside", f"the walls {reason}")
        corners[:, axis] = high[beside, axis][below].max(), low[beside, axis][above].min()
    _refuse_leak(walls, corners, up, spacing, margin, where)
    return Box.from_corners(*corners.tolist())


def _bottom(low: np.ndarray, high: np.ndarray, seed: np.ndarray, up: int, level: float, where: str) -> float:
    """Height of the bottom in the middle of the tank [m], with a ceiling, if there is one, at the level or above."""
    at = np.all(np.delete((low < seed) & (high > seed), up, axis=1), axis=1)
    if not at.any():
        raise InputError(where, "inside", f"the walls have none at the bottom: the fluid would run out; {REMEDY}")
    order = np.argsort(low[at, up])
    starts, ends = low[at, up][order], high[at, up][order]
    bottom = ends[0]
    for start, end in zip(starts[1:], ends[1:], strict=True):
        if start <= bottom:
            bottom = max(bottom, end)
    ceiling = min((start for start in starts if start > bottom), default=np.inf)
    if not bottom < level <= ceiling:
        limits = f"above the bottom of the tank, {bottom:g} m"
        limits += f", and at most at its ceiling, {ceiling:g} m" if np.isfinite(ceiling) else ""
        raise InputError(where, "level", f"is {level:g} m, must be {limits}")
    return float(bottom)


def _refuse_leak(
    walls: tuple[Wall, ...], corners: np.ndarray, up: int, spacing: float, margin: float, where: str
) -> None:
    """Refuse sides and a bottom of a room, from one corner to another, that walls do not cover everywhere."""
    dimension = corners.shape[1]
    counts = np.maximum(1, np.ceil((corners[1] - corners[0]) / spacing)).astype(int)
    lines = [a + (b - a) * (np.arange(n) + 0.5) / n for a, b, n in zip(*corners, counts, strict=True)]
    for axis in range(dimension):
        for end, sign in ((0, -1.0), (1, 1.0)):
            if axis == up and end == 1:
                continue
            face = [*lines[:axis], corners[end, axis : axis + 1] + sign * margin, *lines[axis + 1 :]]
            points = np.stack(np.meshgrid(*face, indexing="ij"), axis=-1).reshape(-1, dimension)
            covered = np.any([contains(wall.shape, points, margin) for wall in walls], axis=0)
            if not covered.all():
                at = ", ".join(f"{c:.6g}" for c in points[np.argmin(covered)])
                reason = f"no wall holds the fluid at ({at}) m: lower the level, add a wall there, or {REMEDY}"
                raise InputError(where, "inside", reason)

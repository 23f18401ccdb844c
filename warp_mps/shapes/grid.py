"""The regular lattice that covers a shape: its directions, and where along them its particles lie."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes import closed_surface, lattice
from warp_mps.shapes.face_planes import broken_line
from warp_mps.shapes.lattice import FIT_TOLERANCE, Line, anchored, is_multiple
from warp_mps.shapes.mesh import Mesh
from warp_mps.shapes.primitives import Box
from warp_mps.shapes.shape import Difference, Intersection, Shape, Union

BLOCK = 500_000
# in steps: how near to the end of a shape that meets nothing a particle may lie, and how near to each other ends are
# that count as one
FREE_END = 0.25


@dataclass(frozen=True, kw_only=True)
class Fit:
    """How the lattice of a box meets what lies at its faces, where its size is no whole number of spacings.

    Along an axis with one face to meet, the lattice keeps its spacing and begins half a spacing inside that face. Where
    both are to be met, it changes its spacing between them.

    Attributes:
        ends: Tells which faces are to be met: from the directions of the lattice as columns, shape [3, axes], and
            the coordinates of the faces along them [m], shape [axes, 2], makes flags, shape [axes, 2].
        keeps: What does not change where the spacing does. ``face``: the outermost particles lie half of the
            given spacing inside both faces (a wall). ``volume``: they lie half a step inside, and the spacing along
            the other axes makes up for the volume of a particle (a fluid).
        guides: Lattices beside it. Along an axis without a face to meet, or with one at which a guide begins or ends
            too, it continues the first guide along that axis, so that the particles of both face each other.
    """

    ends: Callable[[np.ndarray, np.ndarray], np.ndarray]
    keeps: Literal["face", "volume"]
    guides: Callable[[], Sequence[Grid]] = tuple


@dataclass(frozen=True, kw_only=True)
class Grid:
    """The lattice that covers a shape.

    Attributes:
        numbers: Axes of the shape, 0 to 2 for x to z, that the directions of the lattice are.
        axes: Unit directions of the lattice as columns, shape [3, axes].
        lines: Where its particles lie along them.
        nodes: Whether the outermost particles lie on the faces, one flag an axis.
        intervals: Least and greatest coordinate of the shape along the axes [m], shape [axes, 2].
        fits: Whether every particle of the lattice is one of the shape's.
    """

    numbers: tuple[int, ...]
    axes: np.ndarray
    lines: tuple[Line, ...]
    nodes: tuple[bool, ...]
    intervals: np.ndarray
    fits: bool

    @property
    def centres(self) -> np.ndarray:
        """Coordinates of its centre along the axes [m], shape [axes]."""
        return np.array([line.centre for line in self.lines])

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of particles along the axes."""
        return tuple(line.count for line in self.lines)

    def blocks(self) -> Iterator[np.ndarray]:
        """Positions of the lattice [m], shape [n, 3], a few layers at a time to bound the memory."""
        first_axis, *others = [line.coordinates() for line in self.lines]
        layer = int(np.prod(self.counts[1:], dtype=np.int64))
        step = max(1, BLOCK // max(1, layer))
        for first in range(0, len(first_axis), step):
            yield lattice.product([first_axis[first : first + step], *others]) @ self.axes.T


def grid_of(
    shape: Shape, spacing: float, dimension: int, node_axes: Sequence[int], where: str, fit: Fit | None = None
) -> Grid:
    """The lattice that covers a shape; the arguments are those of `warp_mps.shapes.fill`.

    Raises:
        InputError: The shape is thinner than one particle, unbounded, not closed, or has no section at z = 0.
    """
    if not spacing > 0 or not np.isfinite(spacing):
        raise InputError(where, "spacing", f"must be positive, not {spacing}")
    for leaf in shape.leaves():
        if isinstance(leaf, Mesh) and leaf.fault:
            raise InputError(where, "shape", leaf.fault)
    source = shape.leaves()[0]
    grid = _own_grid(source, spacing, dimension, node_axes, where, fit)
    if source is not shape:
        grid = _continued(grid, shape, dimension, where)
    if fit and fit.keeps == "face" and not grid.fits:
        return _between_faces(grid, shape, spacing, fit)
    return grid


def _between_faces(grid: Grid, shape: Shape, spacing: float, fit: Fit) -> Grid:
    """The lattice of a wall that is no box, broken at the plane faces that cut it into unfitting lengths."""
    met: list[list[bool]] = np.asarray(fit.ends(grid.axes, grid.intervals), bool).tolist()
    lines = []
    for line, axis, (low, high), on, ends in zip(
        grid.lines, grid.axes.T, grid.intervals.tolist(), grid.nodes, met, strict=True
    ):
        broken = None if on else broken_line(shape, axis, low, high, spacing, (ends[0], ends[1]))
        lines.append(broken or line)
    return replace(grid, lines=tuple(lines))


def _own_grid(
    shape: Shape, spacing: float, dimension: int, node_axes: Sequence[int], where: str, fit: Fit | None
) -> Grid:
    """The lattice of a shape that is not made of others."""
    numbers, axes, aligned = _axes(shape, dimension)
    intervals = _intervals(shape, axes, dimension, where)
    fits = aligned and isinstance(shape, Box)
    nodes = tuple(number in node_axes for number in numbers)
    counts = [
        lattice.cells(high - low, spacing, whole=fits, nodes=on)
        for (low, high), on in zip(intervals, nodes, strict=True)
    ]
    for number, count, (low, high) in zip(numbers, counts, intervals, strict=True):
        if count < 1:
            extent = f"{high - low:g} m along {'xyz'[number]}"
            text = f"{spacing:g} m is too large: the shape is {extent}, thinner than one particle"
            raise InputError(where, "spacing", text)
    lines = tuple(Line(0.5 * (low + high), n, spacing) for (low, high), n in zip(intervals, counts, strict=True))
    grid = Grid(numbers=numbers, axes=axes, lines=lines, nodes=nodes, intervals=np.array(intervals), fits=fits)
    return _fitted(grid, fit, spacing) if fit and fits else grid


def _fitted(grid: Grid, fit: Fit, spacing: float) -> Grid:
    """The lattice of a box that meets what lies at its faces; unchanged where it does so already."""
    extents = grid.intervals[:, 1] - grid.intervals[:, 0]
    exact = [on or is_multiple(extent, spacing) for extent, on in zip(extents, grid.nodes, strict=True)]
    guides = fit.guides()
    if all(exact) and not guides:
        return grid
    met: list[list[bool]] = np.asarray(fit.ends(grid.axes, grid.intervals), bool).tolist()
    steps = _steps(grid, fit, spacing, exact, met)
    lines = []
    for k, (line, (low, high), step) in enumerate(zip(grid.lines, grid.intervals.tolist(), steps, strict=True)):
        guide = _guide(grid, k, met[k], guides, spacing) if not grid.nodes[k] and not all(met[k]) else None
        if guide is not None and not (exact[k] and _in_phase(line, guide)):
            lines.append(guide.continued(low + FREE_END * guide.step, high - FREE_END * guide.step))
        elif exact[k] and step == spacing:
            lines.append(line)
        else:
            count = line.count if step == spacing or all(met[k]) else max(1, round(extents[k] / step))
            lines.append(anchored(low, high, count, step, (met[k][0], met[k][1])))
    return replace(grid, lines=tuple(lines))


def _steps(grid: Grid, fit: Fit, spacing: float, exact: list[bool], met: list[list[bool]]) -> list[float]:
    """Distances between the particles of a fitted lattice along its axes [m]."""
    extents = grid.intervals[:, 1] - grid.intervals[:, 0]
    steps = np.full(len(exact), spacing)
    between = [k for k, fine in enumerate(exact) if not fine and all(met[k])]
    for k in between:
        count = grid.counts[k]
        if fit.keeps == "volume":
            steps[k] = extents[k] / count
        elif count > 1:
            steps[k] = (extents[k] - spacing) / (count - 1)
    free = [k for k, on in enumerate(grid.nodes) if not on and not all(met[k])]
    if fit.keeps == "volume" and between and free:
        steps[free] = spacing * np.prod(spacing / steps) ** (1.0 / len(free))
    return [float(step) for step in steps]


def _guide(grid: Grid, axis: int, met: list[bool], guides: Sequence[Grid], spacing: float) -> Line | None:
    """The line that a lattice continues along an axis, if there is one."""
    for other in guides:
        parallel = np.abs(grid.axes[:, axis] @ other.axes)
        own = int(np.argmax(parallel))
        if parallel[own] < 1.0 - 1e-9:
            continue
        forwards = bool(grid.axes[:, axis] @ other.axes[:, own] > 0.0)
        low, high = other.intervals[own] if forwards else -other.intervals[own][::-1]
        line = other.lines[own] if forwards else replace(other.lines[own], centre=-other.lines[own].centre)
        flush = abs(np.array([low, high]) - grid.intervals[axis]) <= FREE_END * spacing
        if all(flush[met]):
            return line
    return None


def _in_phase(line: Line, guide: Line) -> bool:
    """Whether the particles of two lines lie at the same places, as far as both reach."""
    shift = (line.coordinates()[0] - guide.coordinates()[0]) / guide.step
    drift = line.count * abs(line.step / guide.step - 1.0)
    return abs(shift - round(shift)) + drift <= FIT_TOLERANCE


def _axes(shape: Shape, dimension: int) -> tuple[tuple[int, ...], np.ndarray, bool]:
    """Numbers and unit directions (columns) of the lattice's axes, and whether they are the shape's own."""
    own = lattice.rigid_axes(shape.linear)
    if dimension == 3:
        return (0, 1, 2), np.eye(3) if own is None else own, own is not None
    if own is not None:
        flat = tuple(k for k in range(3) if abs(own[2, k]) < 1e-9)
        if len(flat) == 2:
            return flat, own[:, flat], True
    return (0, 1), np.eye(3)[:, :2], False


def _intervals(shape: Shape, axes: np.ndarray, dimension: int, where: str) -> list[tuple[float, float]]:
    """Least and greatest coordinate of the shape, or of its section, along each axis [m]."""
    intervals = _reach(shape, axes, dimension)
    if intervals is None:
        low, high = shape.interval(np.array([0.0, 0.0, 1.0]))
        text = f"has no section at z = 0, where the plane of a 2-D scene lies: it reaches from {low:g} to {high:g} m"
        raise InputError(where, "shape", text)
    if not np.isfinite(intervals).all():
        raise InputError(where, "shape", "is unbounded: give it a finite size along every axis")
    return [(float(low), float(high)) for low, high in intervals]


def _reach(shape: Shape, axes: np.ndarray, dimension: int) -> np.ndarray | None:
    """Bounds of the shape, or of its section, along each axis [m], shape [axes, 2]; None where there is no section."""
    if isinstance(shape, Difference):
        return _reach(shape.first, axes, dimension)
    if isinstance(shape, Union | Intersection):
        one, other = (_reach(operand, axes, dimension) for operand in (shape.first, shape.second))
        if one is None or other is None:
            return (other if one is None else one) if isinstance(shape, Union) else None
        least, most = (np.minimum, np.maximum) if isinstance(shape, Union) else (np.maximum, np.minimum)
        return np.column_stack((least(one[:, 0], other[:, 0]), most(one[:, 1], other[:, 1])))
    if dimension == 2:
        low, high = shape.interval(np.array([0.0, 0.0, 1.0]))
        if low > 0 or high < 0:
            return None
        if isinstance(shape, Mesh):
            along = closed_surface.section(shape.corners()).reshape(-1, 3) @ axes
            return np.column_stack((along.min(0), along.max(0))) if len(along) else None
    return np.array([shape.interval(axis) for axis in axes.T])


def _continued(grid: Grid, shape: Shape, dimension: int, where: str) -> Grid:
    """The lattice of a composite: that of its first operand, as far as the composite reaches."""
    intervals = _intervals(shape, grid.axes, dimension, where)
    lines = tuple(line.continued(low, high) for line, (low, high) in zip(grid.lines, intervals, strict=True))
    if any(line.count < 1 for line in lines):
        raise InputError(where, "shape", "is empty, or thinner than one particle: do its two shapes meet?")
    return replace(grid, lines=lines, intervals=np.array(intervals), fits=False)

"""Filling a shape with particles on a regular lattice, and testing points against it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes import closed_surface, lattice
from warp_mps.shapes.mesh import Mesh
from warp_mps.shapes.points import Points
from warp_mps.shapes.primitives import Box
from warp_mps.shapes.shape import Difference, Intersection, Shape, Union

# In particle spacings: cells whose centre lies on the surface but for rounding are kept, so that a symmetric shape
# stays symmetric.
SURFACE_TOLERANCE = 1e-6
BLOCK = 500_000


def contains(shape: Shape, points: np.ndarray, tolerance: float) -> np.ndarray:
    """Tell which points lie in a shape; faces count as inside.

    Args:
        shape: A region of the scene.
        points: Points [m], shape [n, 2] (then at z = 0) or [n, 3].
        tolerance: Distance outside the surface that still counts as inside [m]; where negative, the distance inside
            the surface that no longer does.

    Returns:
        Flags, shape [n].
    """
    points = np.asarray(points, float)
    padded = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    return shape.inside(padded, tolerance)


def fill(shape: Shape, spacing: float, dimension: int, *, node_axes: Sequence[int] = (), where: str = "") -> np.ndarray:
    """Fill a shape with particles on a regular lattice, centred on the shape.

    The lattice lies along the shape's own axes; along the scene's if the placement shears the shape, or if it turns
    a shape of a 2-D scene out of the plane. A box takes the nearest whole number of particles along each axis, the
    outermost half a spacing inside its faces; other shapes take the cells whose centres they contain. Shapes made of
    others by ``|``, ``-`` and ``&`` take the lattice of their first operand, continued as far as they reach.

    Args:
        shape: Shape to fill; `Points` are returned as they are.
        spacing: Particle spacing l0 [m].
        dimension: 2 or 3.
        node_axes: Axes of the lattice along which the outermost particles lie on the faces.
        where: Owner of the shape, for error messages.

    Returns:
        Positions [m], shape [n, dimension].

    Raises:
        InputError: The shape is thinner than one particle, unbounded, not closed, or has no section at z = 0.
    """
    if isinstance(shape, Points):
        return shape.to_scene(shape.positions)[:, :dimension]
    grid = _grid(shape, spacing, dimension, node_axes, where)
    blocks = [block for block in grid.blocks() if len(block)]
    if grid.fits:
        return np.concatenate(blocks)[:, :dimension]
    kept = [block[_keep(shape, grid, block)] for block in blocks]
    positions = np.concatenate(kept)[:, :dimension] if kept else np.zeros((0, dimension))
    if not len(positions):
        raise InputError(where, "spacing", f"{spacing:g} m leaves no particle: the shape is thinner than one particle")
    return positions


def particle_count(
    shape: Shape, spacing: float, dimension: int, node_axes: Sequence[int] = (), *, where: str = "shape"
) -> int:
    """Number of particles that `fill` makes, at most, without making them; exact for a box and for `Points`.

    Args:
        shape: Shape to fill.
        spacing: Particle spacing l0 [m].
        dimension: 2 or 3.
        node_axes: Axes of the lattice along which the outermost particles lie on the faces.
        where: Owner of the shape, for error messages.

    Raises:
        InputError: As for `fill`.
    """
    if isinstance(shape, Points):
        return len(shape.positions)
    grid = _grid(shape, spacing, dimension, node_axes, where)
    return int(np.prod(np.array(grid.counts, dtype=object)))


@dataclass(frozen=True, kw_only=True)
class _Grid:
    """The lattice that covers a shape.

    Attributes:
        axes: Unit directions of the lattice as columns, shape [3, axes].
        centres: Coordinates of its centre along them [m].
        counts: Numbers of particles along them.
        nodes: Whether the outermost particles lie on the faces, one flag an axis.
        spacing: Particle spacing [m].
        fits: Whether every particle of the lattice is one of the shape's.
    """

    axes: np.ndarray
    centres: tuple[float, ...]
    counts: tuple[int, ...]
    nodes: tuple[bool, ...]
    spacing: float
    fits: bool

    def blocks(self) -> Iterator[np.ndarray]:
        """Positions of the lattice [m], shape [n, 3], a few layers at a time to bound the memory."""
        lines = [lattice.coordinates(c, n, self.spacing) for c, n in zip(self.centres, self.counts, strict=True)]
        layer = int(np.prod(self.counts[1:], dtype=np.int64))
        step = max(1, BLOCK // max(1, layer))
        for first in range(0, self.counts[0], step):
            yield lattice.product([lines[0][first : first + step], *lines[1:]]) @ self.axes.T


def _grid(shape: Shape, spacing: float, dimension: int, node_axes: Sequence[int], where: str) -> _Grid:
    if not spacing > 0 or not np.isfinite(spacing):
        raise InputError(where, "spacing", f"must be positive, not {spacing}")
    for leaf in shape.leaves():
        hole = closed_surface.open_edge(leaf.points, leaf.triangles) if isinstance(leaf, Mesh) else None
        if hole:
            reason = f"the mesh is not closed: every edge must belong to exactly two triangles, {hole}"
            raise InputError(where, "shape", reason)
    source = shape.leaves()[0]
    grid = _own_grid(source, spacing, dimension, node_axes, where)
    return grid if source is shape else _continued(grid, shape, dimension, where)


def _own_grid(shape: Shape, spacing: float, dimension: int, node_axes: Sequence[int], where: str) -> _Grid:
    """The lattice of a shape that is not made of others."""
    numbers, axes, aligned = _axes(shape, dimension)
    intervals = _intervals(shape, axes, dimension, where)
    fits = aligned and isinstance(shape, Box)
    nodes = tuple(number in node_axes for number in numbers)
    counts = tuple(
        lattice.cells(high - low, spacing, whole=fits, nodes=on)
        for (low, high), on in zip(intervals, nodes, strict=True)
    )
    for number, count, (low, high) in zip(numbers, counts, intervals, strict=True):
        if count < 1:
            extent = f"{high - low:g} m along {'xyz'[number]}"
            text = f"{spacing:g} m is too large: the shape is {extent}, thinner than one particle"
            raise InputError(where, "spacing", text)
    centres = tuple(0.5 * (low + high) for low, high in intervals)
    return _Grid(axes=axes, centres=centres, counts=counts, nodes=nodes, spacing=spacing, fits=fits)


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


def _continued(grid: _Grid, shape: Shape, dimension: int, where: str) -> _Grid:
    """The lattice of a composite: that of its first operand, as far as the composite reaches."""
    centres, counts = [], []
    for (low, high), centre, count in zip(
        _intervals(shape, grid.axes, dimension, where), grid.centres, grid.counts, strict=True
    ):
        start = centre - 0.5 * (count - 1) * grid.spacing
        first = int(np.ceil((low - start) / grid.spacing - SURFACE_TOLERANCE))
        last = int(np.floor((high - start) / grid.spacing + SURFACE_TOLERANCE))
        if last < first:
            raise InputError(where, "shape", "is empty, or thinner than one particle: do its two shapes meet?")
        # the centre moves by half the number of cells gained at one end and lost at the other: 0 for an equal extent
        centres.append(centre + 0.5 * (first + last - (count - 1)) * grid.spacing)
        counts.append(last - first + 1)
    return replace(grid, centres=tuple(centres), counts=tuple(counts), fits=False)


def _keep(shape: Shape, grid: _Grid, positions: np.ndarray) -> np.ndarray:
    """Which of the lattice's positions the shape contains."""
    along = positions @ grid.axes
    # particles on a face are moved inwards by less than any tolerance, so that rounding does not lose them
    inwards = np.where(grid.nodes, (np.array(grid.centres) - along) * SURFACE_TOLERANCE, 0.0)
    tolerance = 0.0 if isinstance(shape, Mesh) else SURFACE_TOLERANCE * grid.spacing
    return contains(shape, positions + inwards @ grid.axes.T, tolerance)

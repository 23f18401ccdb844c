"""Filling a shape with particles on a regular lattice, and testing points against it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.grid import Fit, Grid, grid_of
from warp_mps.shapes.lattice import FIT_TOLERANCE
from warp_mps.shapes.mesh import Mesh
from warp_mps.shapes.points import Points
from warp_mps.shapes.ready_made import check_spacing
from warp_mps.shapes.shape import Shape

# In particle spacings: cells whose centre lies on the surface but for rounding are kept, so that a symmetric shape
# stays symmetric.
SURFACE_TOLERANCE = 1e-6


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


def fill(
    shape: Shape,
    spacing: float,
    dimension: int,
    *,
    node_axes: Sequence[int] = (),
    fit: Fit | None = None,
    where: str = "",
) -> np.ndarray:
    """Fill a shape with particles on a regular lattice, centred on the shape unless it is fitted to faces.

    The lattice lies along the shape's own axes; along the scene's if the placement shears the shape, or if it turns
    a shape of a 2-D scene out of the plane. A box takes the nearest whole number of particles along each axis, the
    outermost half a spacing inside its faces; other shapes take the cells whose centres they contain. Shapes made of
    others by ``|``, ``-`` and ``&`` take the lattice of their first operand, continued as far as they reach.

    Args:
        shape: Shape to fill; `Points` are returned as they are.
        spacing: Particle spacing l0 [m].
        dimension: 2 or 3.
        node_axes: Axes of the lattice along which the outermost particles lie on the faces.
        fit: How the lattice of a box, or of a composite that begins with one, meets what lies at its faces.
        where: Owner of the shape, for error messages.

    Returns:
        Positions [m], shape [n, dimension].

    Raises:
        InputError: The shape is thinner than one particle, unbounded, not closed, or has no section at z = 0; or its
            ready-made particles coincide, or are not a spacing apart.
    """
    if isinstance(shape, Points):
        check_spacing(shape, spacing, dimension, where)
        return shape.to_scene(shape.positions)[:, :dimension]
    grid = grid_of(shape, spacing, dimension, node_axes, where, fit)
    if grid.fits:
        return np.concatenate([block for block in grid.blocks() if len(block)])[:, :dimension]
    # one block after the other: the lattice about a thin shell takes far more memory than the particles in it
    kept = [block[_keep(shape, grid, block, spacing)] for block in grid.blocks() if len(block)]
    positions = np.concatenate(kept)[:, :dimension] if kept else np.zeros((0, dimension))
    if not len(positions):
        raise InputError(where, "spacing", f"{spacing:g} m leaves no particle: the shape is thinner than one particle")
    return positions


def particle_count(
    shape: Shape,
    spacing: float,
    dimension: int,
    node_axes: Sequence[int] = (),
    *,
    fit: Fit | None = None,
    where: str = "shape",
    exact: bool = False,
) -> int:
    """Number of particles that `fill` makes, without keeping them.

    By default it is at most that of the lattice that covers the shape, which is found at once, and is exact for a box
    and for `Points`.

    Args:
        shape: Shape to fill.
        spacing: Particle spacing l0 [m].
        dimension: 2 or 3.
        node_axes: Axes of the lattice along which the outermost particles lie on the faces.
        fit: As of `fill`.
        where: Owner of the shape, for error messages.
        exact: Whether the shape is filled, a few layers at a time, to count its particles.

    Raises:
        InputError: As for `fill`.
    """
    if isinstance(shape, Points):
        return len(shape.positions)
    grid = grid_of(shape, spacing, dimension, node_axes, where, fit)
    if exact and not grid.fits:
        return sum(int(_keep(shape, grid, block, spacing).sum()) for block in grid.blocks() if len(block))
    return int(np.prod(np.array(grid.counts, dtype=object)))


def _keep(shape: Shape, grid: Grid, positions: np.ndarray, spacing: float) -> np.ndarray:
    """Which of the lattice's positions the shape contains."""
    tolerance = 0.0 if isinstance(shape, Mesh) else SURFACE_TOLERANCE * spacing
    if not any(grid.nodes):
        return contains(shape, positions, tolerance)
    along = positions @ grid.axes
    # particles on a face are moved inwards, so that rounding does not lose them: the outermost ones by what the
    # coordinates of a mesh in single precision may be off, others by less than any tolerance
    off_centre = grid.centres - along
    reach = np.array([0.5 * (line.count - 1) * line.step for line in grid.lines])
    outermost = np.abs(off_centre) > reach - FIT_TOLERANCE * spacing
    inwards = np.where(outermost, np.sign(off_centre) * FIT_TOLERANCE * spacing, off_centre * SURFACE_TOLERANCE)
    return contains(shape, positions + np.where(grid.nodes, inwards, 0.0) @ grid.axes.T, tolerance)

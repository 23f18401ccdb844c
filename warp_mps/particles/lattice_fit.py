"""How the lattice of a body, wall or fluid lies in its drawn shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_mps.particles.met_faces import Fits
from warp_mps.scene import Body, Fluid, Wall
from warp_mps.shapes import Points


@dataclass(frozen=True, kw_only=True)
class LatticeFit:
    """How a lattice lies in a shape, along each of its directions.

    Attributes:
        axes: The shape's own axes that the directions are, ``x``, ``y`` or ``z``.
        directions: Unit vectors along the lattice, shape [dimension, dimension].
        sizes: Distances between the faces of the drawn shape, in spacings [-].
        across: Number of particles from one side to the other.
        steps: Distances between the particles, in spacings [-].
        misfit: How far the particles reach beyond the low and the high side of the drawn shape, in spacings; negative
            where they end before it [-], shape [dimension, 2].
        met: Whether something lies at these sides, shape [dimension, 2]; at all of them for a body.
        matters: Whether it matters where these sides lie, shape [dimension, 2]: not for a wall where nothing meets it.
    """

    axes: tuple[str, ...]
    directions: tuple[tuple[float, ...], ...]
    sizes: tuple[float, ...]
    across: tuple[int, ...]
    steps: tuple[float, ...]
    misfit: tuple[tuple[float, float], ...]
    met: tuple[tuple[bool, bool], ...]
    matters: tuple[tuple[bool, bool], ...]

    @property
    def offsets(self) -> dict[str, float]:
        """The misfits that matter [-], by side: ``-x``, ``+x``, ``-y``, ..."""
        return {
            f"{sign}{axis}": offset
            for axis, offsets, sides in zip(self.axes, self.misfit, self.matters, strict=True)
            for sign, offset, counts in zip("-+", offsets, sides, strict=True)
            if counts
        }

    @property
    def worst(self) -> float:
        """The misfit of largest magnitude among those that matter [-]."""
        return max(self.offsets.values(), key=abs, default=0.0)


def lattice_fit(item: Body | Wall | Fluid, fits: Fits, positions: np.ndarray | None = None) -> LatticeFit | None:
    """How the particles of an item lie in its shape; None for ready-made particles.

    A particle reaches half a step of the lattice beyond its centre, and along node axes it does not. The rows of a wall
    that is met on both sides reach half a spacing instead: they are stretched or squeezed so that the outermost ones
    lie half a spacing inside the faces.

    Args:
        item: The body, wall or fluid.
        fits: The lattices of its scene.
        positions: Its particles [m], shape [n, dimension]; if not given, all of the lattice about the shape.
    """
    if isinstance(item.shape, Points):
        return None
    grid, fit = fits.grid(item), fits.of(item)
    met = np.asarray(fit.ends(grid.axes, grid.intervals), bool) if fit else np.ones(grid.intervals.shape, bool)
    across, misfit = [], []
    for k, (line, (low, high), on) in enumerate(zip(grid.lines, grid.intervals.tolist(), grid.nodes, strict=True)):
        along = line.coordinates() if positions is None else positions @ grid.axes[: positions.shape[1], k]
        first, last = float(along.min()), float(along.max())
        stretched = isinstance(item, Fluid) or not met[k].all()
        half = 0.0 if on else 0.5 * (line.step if stretched else item.spacing)
        across.append(round((last - first) / line.step) + 1)
        # without the sign of a rounded zero
        reach = np.round([(low - first + half) / item.spacing, (last + half - high) / item.spacing], 6) + 0.0
        misfit.append((float(reach[0]), float(reach[1])))
    sides = [(bool(low), bool(high)) for low, high in met]
    return LatticeFit(
        axes=tuple("xyz"[number] for number in grid.numbers),
        directions=tuple(tuple(axis.tolist()) for axis in grid.axes.T),
        sizes=tuple((np.ptp(grid.intervals, axis=1) / item.spacing).tolist()),
        across=tuple(across),
        steps=tuple(line.step / item.spacing for line in grid.lines),
        misfit=tuple(misfit),
        met=tuple(sides),
        # the sides of a fluid that meet nothing are its free surface; those of a wall are dry
        matters=tuple(sides if isinstance(item, Wall) else [(True, True)] * len(sides)),
    )

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
        directions: Unit vectors along the lattice, shape [dimension, dimension].
        across: Number of particles from one side to the other.
        steps: Distances between the particles, in spacings [-].
        misfit: How far the particles reach beyond the low and the high side of the drawn shape, in spacings; negative
            where they end before it [-], shape [dimension, 2].
    """

    directions: tuple[tuple[float, ...], ...]
    across: tuple[int, ...]
    steps: tuple[float, ...]
    misfit: tuple[tuple[float, float], ...]

    @property
    def worst(self) -> float:
        """The misfit of largest magnitude [-]."""
        return max((side for sides in self.misfit for side in sides), key=abs)


def lattice_fit(item: Body | Wall | Fluid, positions: np.ndarray, fits: Fits) -> LatticeFit | None:
    """How the particles of an item lie in its shape; None for ready-made particles.

    A particle reaches half a spacing beyond its centre, and half a step where the particles of a fluid are stretched
    or squeezed; along node axes it does not.

    Args:
        item: The body, wall or fluid.
        positions: Its particles [m], shape [n, dimension].
        fits: The lattices of its scene.
    """
    if isinstance(item.shape, Points):
        return None
    grid = fits.grid(item)
    axes = grid.axes[: positions.shape[1]]
    across, misfit = [], []
    for axis, line, (low, high), on in zip(axes.T, grid.lines, grid.intervals, grid.nodes, strict=True):
        along = positions @ axis
        first, last = float(along.min()), float(along.max())
        half = 0.0 if on else 0.5 * (line.step if isinstance(item, Fluid) else item.spacing)
        across.append(round((last - first) / line.step) + 1)
        reach = (float(low) - first + half) / item.spacing, (last + half - float(high)) / item.spacing
        misfit.append((round(reach[0], 6), round(reach[1], 6)))
    return LatticeFit(
        directions=tuple(tuple(axis.tolist()) for axis in axes.T),
        across=tuple(across),
        steps=tuple(line.step / item.spacing for line in grid.lines),
        misfit=tuple(misfit),
    )

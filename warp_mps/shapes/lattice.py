"""Regular lattices over a box, and the pair lists that searches on a lattice of cells need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# In particle spacings: lengths that differ by less count as equal. It is far above the rounding of coordinates in
# single precision, as of the points of a mesh, and far below what matters.
FIT_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Line:
    """Evenly spaced particles along an axis.

    Attributes:
        centre: Their middle [m].
        count: Their number.
        step: Distance between them [m].
    """

    centre: float
    count: int
    step: float

    def coordinates(self) -> np.ndarray:
        """Their coordinates, symmetric about the centre [m], shape [count]."""
        return self.centre + (np.arange(self.count) - 0.5 * (self.count - 1)) * self.step

    def continued(self, low: float, high: float) -> Line:
        """The line from one coordinate to another [m], continued or cut; its count is below 1 where nothing is left."""
        start = self.centre - 0.5 * (self.count - 1) * self.step
        first = int(np.ceil((low - start) / self.step - FIT_TOLERANCE))
        last = int(np.floor((high - start) / self.step + FIT_TOLERANCE))
        # the centre moves by half the number of cells gained at one end and lost at the other: 0 for an equal extent
        return Line(self.centre + 0.5 * (first + last - (self.count - 1)) * self.step, last - first + 1, self.step)


def cells(extent: float, spacing: float, *, whole: bool, nodes: bool) -> int:
    """Number of particles along an axis.

    Args:
        extent: Length to fill [m].
        spacing: Particle spacing [m].
        whole: Whether the ends are faces that the lattice fits between (a box), so that the nearest number of
            particles is right; otherwise the lattice covers the extent, and cells outside the shape are dropped later.
        nodes: Whether the outermost particles lie on the ends rather than half a spacing inside.

    Returns:
        The number, below 1 if the extent is thinner than one particle.
    """
    ratio = extent / spacing
    if round(ratio) < 1:
        return 0
    if nodes:
        return round(ratio) + 1
    # A length that is a multiple of the spacing but for rounding must not gain a cell.
    return round(ratio) if whole else int(np.ceil(ratio - FIT_TOLERANCE))


def is_multiple(extent: float, spacing: float) -> bool:
    """Whether a length is a whole number of spacings."""
    return abs(extent / spacing - round(extent / spacing)) <= FIT_TOLERANCE


def anchored(low: float, high: float, count: int, step: float, ends: tuple[bool, bool]) -> Line:
    """Particles that lie half a step inside one of two ends, or about their middle if both or neither is to be met.

    Args:
        low: The one end [m].
        high: The other [m].
        count: Number of particles.
        step: Distance between them [m].
        ends: Whether the low and the high end are to be met.
    """
    reach = 0.5 * count * step
    if ends == (True, False):
        return Line(low + reach, count, step)
    if ends == (False, True):
        return Line(high - reach, count, step)
    return Line(0.5 * (low + high), count, step)


def product(lines: list[np.ndarray]) -> np.ndarray:
    """Every combination of the coordinates of each axis, the last axis fastest, shape [n, axes]."""
    grids = np.meshgrid(*lines, indexing="ij")
    return np.stack([grid.ravel() for grid in grids], axis=1)


def rigid_axes(linear: np.ndarray) -> np.ndarray | None:
    """Directions of the local axes under a linear map, or None if the map shears.

    Args:
        linear: Linear map, columns are the images of the local axes, shape [3, 3].

    Returns:
        Unit columns, orthogonal to each other, shape [3, 3].
    """
    axes = linear / np.linalg.norm(linear, axis=0)
    return axes if np.allclose(axes.T @ axes, np.eye(3), atol=1e-9) else None


def expand(starts: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (owner, entry) of a list of ranges.

    Args:
        starts: First entry of each owner's range, shape [n].
        counts: Number of entries in each range, shape [n].

    Returns:
        The owner and the entry of each pair, two arrays of shape [sum of counts].
    """
    owners = np.repeat(np.arange(len(counts)), counts)
    offsets = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owners, np.repeat(starts, counts) + offsets

"""Regular lattices over a box, and the pair lists that searches on a lattice of cells need."""

from __future__ import annotations

import numpy as np


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
    return round(ratio) if whole else int(np.ceil(ratio - 1e-6))


def coordinates(centre: float, count: int, spacing: float) -> np.ndarray:
    """Coordinates of `count` particles, symmetric about the centre [m], shape [count]."""
    return centre + (np.arange(count) - 0.5 * (count - 1)) * spacing


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

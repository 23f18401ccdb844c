"""Level of the free surface on a line along gravity, without spray.

The density of the fluid along the line, smoothed with (1 - (r/R)^2)^3 and R = 2.5 spacings, is at least half of its
largest over one or several intervals. The level is the upper end of the highest one that holds water: on a plane
surface that is half a spacing above its particles.

An interval is spray, and left out, if the particles in it belong to a detached cluster: one in which particles are less
than 1.5 spacings apart, of less than 5 % of all particles, that reaches no farther than 6 spacings from them.
"""

from __future__ import annotations

import numpy as np

from warp_mps.shapes.point_search import cell_pairs

# reach of the smoothed density, in spacings, and points a spacing at which it is looked at
REACH, POINTS = 2.5, 4
# a cluster: largest distance of neighbours, in spacings; how far spray reaches, in spacings, and its largest share
CONNECTED, LARGEST_REACH, LARGEST_SHARE = 1.5, 6.0, 0.05


def surface_level(positions: np.ndarray, point: np.ndarray, up: np.ndarray, spacing: float) -> float:
    """Height of the free surface on the line through a point, the point's own where the line is dry [m].

    Args:
        positions: Positions of the fluid's particles [m], shape [n, d].
        point: A point of the line [m], shape [d].
        up: Unit vector against gravity, shape [d].
        spacing: Particle spacing l0 [m].
    """
    arms = positions - point
    heights = arms @ up
    beside = np.sum(arms**2, axis=1) - heights**2
    column = np.flatnonzero(beside < (REACH * spacing) ** 2)
    base = float(point @ up)
    if not np.any(beside < spacing**2):
        return base
    high = heights[column]
    levels = np.arange(high.max() + REACH * spacing, high.min() - REACH * spacing, -spacing / POINTS)
    density = _smooth(((levels[:, None] - high) / spacing) ** 2 + beside[column] / spacing**2).sum(axis=1)
    half = 0.5 * density.max()
    for top, bottom in _intervals(density >= half):
        seeds = column[(high < levels[top] + spacing) & (high > levels[bottom] - spacing)]
        if not _is_spray(positions, seeds, spacing):
            part = (density[top] - half) / (density[top] - density[top - 1]) if top else 0.0
            return base + float(levels[top] + part * spacing / POINTS)
    return base


def _intervals(wet: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run of True values."""
    changes = np.flatnonzero(np.diff(np.concatenate(([0], wet.astype(int), [0]))))
    return [(int(first), int(after) - 1) for first, after in changes.reshape(-1, 2)]


def _is_spray(positions: np.ndarray, seeds: np.ndarray, spacing: float) -> bool:
    """Whether some particles belong to a small detached cluster.

    Args:
        positions: Positions of all particles [m], shape [n, d].
        seeds: Indices of the particles.
        spacing: Particle spacing l0 [m].
    """
    reach = LARGEST_REACH * spacing
    low, high = positions[seeds].min(axis=0), positions[seeds].max(axis=0)
    if np.any(high - low > 2.0 * reach):
        return False
    # a cluster that goes on beyond this box is no spray
    near = np.flatnonzero(np.all((positions > low - reach) & (positions < high + reach), axis=1))
    x = np.zeros((len(near), 3))
    x[:, : positions.shape[1]] = positions[near]
    found, frontier = np.isin(near, seeds), np.flatnonzero(np.isin(near, seeds))
    while len(frontier):
        reached = np.zeros(len(near), bool)
        for owners, entries in cell_pairs(x[frontier], x, CONNECTED * spacing):
            together = np.linalg.norm(x[frontier[owners]] - x[entries], axis=1) < CONNECTED * spacing
            reached[entries[together]] = True
        frontier = np.flatnonzero(reached & ~found)
        found |= reached
    cluster, rim = positions[near[found]], reach - CONNECTED * spacing
    wide = np.any((cluster < low - rim) | (cluster > high + rim))
    return not wide and len(cluster) < LARGEST_SHARE * len(positions)


def _smooth(squares: np.ndarray) -> np.ndarray:
    """The kernel (1 - (r/R)^2)^3 of the squared distance, R the reach, both in spacings."""
    return np.maximum(1.0 - squares / REACH**2, 0.0) ** 3

"""Whether ready-made particles are as far apart as their spacing says, from which masses and neighbours follow."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.point_search import crowd, nearest_points, pair_in_a_cell
from warp_mps.shapes.points import Points

# in spacings: particles nearer to each other coincide; bounds of the median distance to the nearest one, which is 1 on
# a lattice, 1.12 in the densest packing of balls and 0.7 to 0.8 in packings at random
COINCIDENT, LEAST_MEDIAN, LARGEST_MEDIAN = 0.1, 0.6, 1.5
# in spacings: distance at which two particles are the same point
SAME_POINT = 1e-3
# mean number of particles in a cell of one spacing from which on the search begins with nearer ones
CROWDED = 16.0


def check_spacing(shape: Points, spacing: float, dimension: int, where: str) -> None:
    """Refuse ready-made particles that coincide, or whose spacing is not theirs.

    Args:
        shape: The particles.
        spacing: Particle spacing l0 that is given for them [m].
        dimension: 2 (their third coordinates do not count) or 3.
        where: Owner of the shape, for error messages.

    Raises:
        InputError: Two are nearer to each other than `COINCIDENT` spacings, or the median distance to the nearest one
            is not between `LEAST_MEDIAN` and `LARGEST_MEDIAN` spacings.
    """
    x = _positions(shape, dimension)
    if len(x) < 2:
        return
    pair = pair_in_a_cell(x, SAME_POINT * spacing)
    if pair is None:
        distances, nearest = _nearest(x, spacing)
        median = _median(distances)
        if not LEAST_MEDIAN * spacing <= median <= LARGEST_MEDIAN * spacing:
            apart = f"{median:.4g}" if np.isfinite(median) else f"more than {LARGEST_MEDIAN * spacing:.4g}"
            reason = f"is {spacing:g} m, but its particles lie {apart} m apart (median distance to the nearest one)"
            limits = f"{LEAST_MEDIAN:g} to {LARGEST_MEDIAN:g} spacings: their masses follow from it"
            raise InputError(where, "spacing", f"{reason}, must be {limits}")
        first = int(np.argmin(distances))
        if distances[first] < COINCIDENT * spacing:
            pair = first, int(nearest[first])
    if pair is not None:
        one, other = sorted(pair)
        at = ", ".join(f"{c:.6g}" for c in x[one, :dimension])
        apart = f"{np.linalg.norm(x[one] - x[other]):.3g} m apart"
        reason = f"rows {one} and {other} coincide at ({at}) m: they are {apart}"
        raise InputError(where, "positions", f"{reason}, must be {COINCIDENT * spacing:.3g} m or more; leave one out")


def median_distance(shape: Points, spacing: float, dimension: int) -> float:
    """Median distance from ready-made particles to the nearest other one [m]; infinite beyond 1.5 spacings.

    Args:
        shape: The particles.
        spacing: Particle spacing l0 [m].
        dimension: 2 or 3.
    """
    return _median(_nearest(_positions(shape, dimension), spacing)[0])


def _positions(shape: Points, dimension: int) -> np.ndarray:
    """Positions in the scene [m], in 2-D at z = 0, shape [n, 3]."""
    return shape.to_scene(shape.positions) * (np.arange(3) < dimension)


def _nearest(x: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the nearest other particles [m], of half of them at least, and their indices."""
    distances, nearest = np.full(len(x), np.inf), np.full(len(x), -1)
    reaches = [1.05, LARGEST_MEDIAN]
    if crowd(x, spacing) > CROWDED:
        reaches = [0.003, 0.01, 0.03, COINCIDENT, 0.3, LEAST_MEDIAN, *reaches]
    for reach in reaches:
        lone = np.flatnonzero(np.isinf(distances))
        distances[lone], nearest[lone] = nearest_points(x[lone], x, reach * spacing, lone)
        if reach >= COINCIDENT and np.isfinite(_median(distances)):
            break
    return distances, nearest


def _median(distances: np.ndarray) -> float:
    middle = len(distances) // 2
    return float(np.partition(distances, middle)[middle])

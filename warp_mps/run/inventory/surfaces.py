"""Particles at the surface of a set, and the nearest of one set to those of another."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.shapes.lattice import expand, product

# in spacings: how far off its place a neighbour on a lattice may be, which may be stretched and turned
BESIDE = 1.3
# pairs that are looked at together, to bound the memory
PAIRS = 4_000_000


def surface_particles(positions: np.ndarray, spacing: float) -> np.ndarray:
    """Flags of the particles that have fewer neighbours beside them than one inside a lattice, shape [n].

    Args:
        positions: Positions [m], shape [n, d].
        spacing: Particle spacing [m].
    """
    counts = np.zeros(len(positions), np.int64)
    for owners, others in _pairs(positions, positions, BESIDE * spacing):
        close = np.linalg.norm(positions[owners] - positions[others], axis=1) <= BESIDE * spacing
        counts += np.bincount(owners[close], minlength=len(positions))
    # a particle is a neighbour of itself here
    return counts < 2 * positions.shape[1] + 1


def nearest_offsets(queries: np.ndarray, points: np.ndarray, distance: float) -> np.ndarray:
    """Vectors from each query to the nearest of the points [m], NaN where none is within a distance, shape [n, d].

    Args:
        queries: Positions [m], shape [n, d].
        points: Points [m], shape [m, d].
        distance: Largest distance [m].
    """
    result = np.full(queries.shape, np.nan)
    low, high = points.min(axis=0) - distance, points.max(axis=0) + distance
    near = np.flatnonzero(np.all((queries >= low) & (queries <= high), axis=1))
    low, high = queries.min(axis=0) - distance, queries.max(axis=0) + distance
    points = points[np.all((points >= low) & (points <= high), axis=1)]
    if not len(near) or not len(points):
        return result
    least = np.full(len(queries), distance)
    for owners, others in _pairs(queries[near], points, distance):
        offsets = points[others] - queries[near[owners]]
        lengths = np.linalg.norm(offsets, axis=1)
        # the last of equal owners is written: sort so that this is the nearest
        order = np.argsort(-lengths, kind="stable")
        order = order[lengths[order] <= least[near[owners[order]]]]
        result[near[owners[order]]] = offsets[order]
        least[near[owners[order]]] = lengths[order]
    return result


def _pairs(queries: np.ndarray, points: np.ndarray, distance: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of a query and a point in cells of a size beside each other, in blocks."""
    low = np.minimum(points.min(axis=0), queries.min(axis=0))
    span = np.maximum(points.max(axis=0), queries.max(axis=0)) - low
    size = max(distance, float(span.max()) * 2.0**-19)
    keys = _keys(np.floor((points - low) / size).astype(np.int64))
    order = np.argsort(keys, kind="stable")
    keys, cells = keys[order], np.floor((queries - low) / size).astype(np.int64)
    for shift in product([np.arange(-1, 2)] * queries.shape[1]):
        wanted = _keys(cells + shift)
        first = np.searchsorted(keys, wanted, "left")
        counts = np.searchsorted(keys, wanted, "right") - first
        ends = np.cumsum(counts)
        for block in np.split(np.arange(len(queries)), np.searchsorted(ends, np.arange(PAIRS, ends[-1] + 1, PAIRS))):
            owners, entries = expand(first[block], counts[block])
            if len(owners):
                yield block[owners], order[entries]


def _keys(cells: np.ndarray) -> np.ndarray:
    """A number for each cell, from its coordinates from -1 to 2^20 - 2."""
    keys = np.zeros(len(cells), np.int64)
    for column in cells.T:
        keys = (keys << 20) | (column + 1)
    return keys

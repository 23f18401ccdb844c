"""Aggregation: compact groups of particles, whose rigid motions are the coarse unknowns of a preconditioner.

An aggregate is a connected piece of a body in a box of a lattice that is laid over the body's reference configuration.
Bodies share none, and neither do the two sides of a gap. What the particles' neighbour lists connect is a body here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warp_mps.shapes.lattice import expand

# width of the boxes in particle spacings; narrower boxes cost more in unknowns than they save in iterations
WIDTH = 4.0
# largest number of unknowns of a body, by the inversion on the host, and of entries of the dense inverse per particle:
# beyond that a product with the inverse takes longer than one with the tangent, and the boxes are made wider
MOST_UNKNOWNS = 900
INVERSE_PER_PARTICLE = 50.0
GROWTH = 1.15


@dataclass(frozen=True)
class Aggregates:
    """Groups of particles, in the order of their bodies.

    Attributes:
        of: Aggregate of each particle, -1 for one that does not move, shape [n].
        first: First place of each aggregate in `order`, shape [count + 1].
        order: Particles by aggregate.
        bodies: Body of each aggregate, ascending, shape [count].
        rows: Aggregates that are coupled to those in `columns`, including themselves, shape [couplings].
        columns: Aggregates that they are coupled to, shape [couplings].
        colours: Colours such that no aggregate is coupled to two of the same colour, shape [count].
    """

    of: np.ndarray
    first: np.ndarray
    order: np.ndarray
    bodies: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    colours: np.ndarray

    @property
    def count(self) -> int:
        """Number of aggregates."""
        return len(self.bodies)


def aggregate(
    positions: np.ndarray,
    spacings: np.ndarray,
    moves: np.ndarray,
    start: np.ndarray,
    index: np.ndarray,
    *,
    modes: int,
    rings: int = 1,
) -> Aggregates:
    """Aggregate particles.

    Args:
        positions: Reference positions [m], shape [n, d].
        spacings: Their spacings [m], shape [n].
        moves: Whether any axis of a particle is free, shape [n].
        start: First neighbour of each particle in `index`, shape [n + 1]; every particle has at least one.
        index: Neighbours.
        modes: Unknowns of an aggregate.
        rings: Neighbours of neighbours up to which a term of the energy reaches: 1, with mean dilatations 2.
    """
    bodies = _labels(start, index, np.zeros(len(positions), int))
    of = _pieces(positions, spacings, moves, start, index, bodies, modes)
    count = of.max(initial=-1) + 1
    order = np.argsort(of, kind="stable")[int(np.sum(of < 0)) :]
    first = np.searchsorted(of[order], np.arange(count + 1))
    rows, columns = _couplings(of, start, index, count, rings)
    return Aggregates(of, first, order, bodies[order[first[:-1]]], rows, columns, _colours(rows, columns, count))


def _labels(start: np.ndarray, index: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """Smallest particle that each one is connected to through neighbours of its own kind, shape [n]."""
    label = np.arange(len(kinds))
    same = np.repeat(kinds, np.diff(start)) == kinds[index]
    while True:
        nearby = np.where(same, label[index], len(kinds))
        lower = np.minimum(label, np.minimum.reduceat(nearby, start[:-1]))
        # pointer jumping: a label is a particle of the same piece
        lower = lower[lower]
        if (lower == label).all():
            return label
        label = lower


def _pieces(
    positions: np.ndarray,
    spacings: np.ndarray,
    moves: np.ndarray,
    start: np.ndarray,
    index: np.ndarray,
    bodies: np.ndarray,
    modes: int,
) -> np.ndarray:
    """Aggregate of each particle, sorted by body, in boxes as narrow as their number may be."""
    members = {int(body): np.flatnonzero((bodies == body) & moves) for body in np.unique(bodies[moves])}
    width = {body: WIDTH * float(spacings[inside].max()) for body, inside in members.items()}
    kinds = np.full(len(positions), -1)
    wide = list(members)
    while wide:
        for body in wide:
            kinds[members[body]] = _boxes(positions[members[body]], width[body])
        # particles that do not move separate the pieces of a box
        labels = _labels(start, index, np.where(moves, kinds, -1))
        counts = {body: len(np.unique(labels[members[body]])) for body in wide}
        extents = {body: float(np.ptp(positions[members[body]], axis=0).max()) for body in wide}
        wide = [
            body
            for body in wide
            if modes * counts[body] > _most_unknowns(len(members[body])) and width[body] < 2.0 * extents[body]
        ]
        for body in wide:
            width[body] *= GROWTH
    of = np.full(len(positions), -1)
    if members:
        there = np.flatnonzero(moves)
        keys = np.stack((bodies[there], labels[there]))
        of[there] = np.unique(keys, axis=1, return_inverse=True)[1].reshape(-1)
    return of


def _most_unknowns(particles: int) -> float:
    return min(MOST_UNKNOWNS, math.sqrt(INVERSE_PER_PARTICLE * particles))


def _boxes(positions: np.ndarray, width: float) -> np.ndarray:
    """Boxes of a lattice that fits a body, of about a width [m]."""
    low, extent = positions.min(axis=0), np.ptp(positions, axis=0)
    # a lattice of m spacings has m + 1 particles along an axis
    numbers = np.maximum(np.round((extent + width / WIDTH) / width), 1.0).astype(int)
    place = (positions - low) / np.where(extent > 0.0, extent, 1.0) * numbers
    # particles on a face between boxes all go to the same side
    boxes = np.minimum(np.floor(place + 1e-6).astype(int), numbers - 1)
    return np.ravel_multi_index(tuple(boxes.T), tuple(numbers))


def _couplings(
    of: np.ndarray, start: np.ndarray, index: np.ndarray, count: int, rings: int
) -> tuple[np.ndarray, np.ndarray]:
    """Aggregates that a force connects: those which the neighbourhood of one particle touches."""
    particle, touched = np.flatnonzero(of >= 0), of[of >= 0]
    for _ in range(rings):
        particle, touched = _touched_by_neighbours(particle, touched, start, index, count)
    codes = [np.arange(count) * (count + 1)]
    shift = 1
    while shift < len(particle):
        both = particle[shift:] == particle[:-shift]
        if not both.any():
            break
        one, other = touched[:-shift][both], touched[shift:][both]
        codes += [np.unique(one * count + other), np.unique(other * count + one)]
        shift += 1
    rows, columns = np.divmod(np.unique(np.concatenate(codes)), max(count, 1))
    return rows, columns


def _colours(rows: np.ndarray, columns: np.ndarray, count: int) -> np.ndarray:
    """Greedy colours of a graph such that neighbours of one node differ (Curtis, Powell and Reid)."""
    ends = np.searchsorted(rows, np.arange(count + 1))
    near = [columns[ends[node] : ends[node + 1]].tolist() for node in range(count)]
    colours = np.full(count, -1)
    for node in range(count):
        taken = {colours[other] for middle in near[node] for other in near[middle]}
        colours[node] = next(colour for colour in range(count) if colour not in taken)
    return colours


def _touched_by_neighbours(
    particle: np.ndarray, touched: np.ndarray, start: np.ndarray, index: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Particles and the aggregates that they or their neighbours touch, by particle and aggregate."""
    n = len(start) - 1
    first = np.searchsorted(particle, np.arange(n + 1))
    pairs, entries = expand(first[index], np.diff(first)[index])
    owner, near = np.repeat(np.arange(n), np.diff(start))[pairs], touched[entries]
    seen = np.unique(np.concatenate((owner * (count + 1) + near, particle * (count + 1) + touched)))
    return seen // (count + 1), seen % (count + 1)

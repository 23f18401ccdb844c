"""Aggregates: compact, connected, of one body, and coloured so that none feels two of one colour."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from tests.elastic.states import Strained, strain
from tests.scenes import HAMILTONIAN, block, scene_of
from warp_mps.elastic.implicit.aggregates import MOST_UNKNOWNS, Aggregates, aggregate
from warp_mps.shapes import Box, Points


def gather(held: Strained, moves: np.ndarray | None = None) -> Aggregates:
    particles, model = held.particles, held.model
    moves = np.ones(particles.count, bool) if moves is None else moves
    lists = (model.start.numpy(), model.index.numpy())
    modes = 3 * (particles.dimension - 1)
    return aggregate(particles.positions, particles.spacings, moves, *lists, modes=modes)


def beam(dimension: int, *counts: int) -> Strained:
    shape = Box(tuple(0.01 * count for count in counts))
    return strain(scene_of(block(dimension, shape=shape), dimension=dimension, elasticity=HAMILTONIAN))


def members(groups: Aggregates) -> Iterator[np.ndarray]:
    for k in range(groups.count):
        yield groups.order[groups.first[k] : groups.first[k + 1]]


@pytest.mark.parametrize("counts", [(40, 4), (13, 22), (12, 4, 9)])
def test_they_share_out_the_particles(counts: tuple[int, ...]) -> None:
    held = beam(len(counts), *counts)
    groups = gather(held)
    assert np.array_equal(np.sort(groups.order), np.arange(held.particles.count))
    for k, inside in enumerate(members(groups)):
        assert (groups.of[inside] == k).all()
        assert np.ptp(held.particles.positions[inside], axis=0).max() < 5.5 * 0.01
    sizes = np.diff(groups.first)
    assert sizes.min() >= 0.4 * sizes.max()


def test_a_beam_is_cut_across() -> None:
    groups = gather(beam(2, 40, 4))
    assert groups.count == 10
    assert (np.diff(groups.first) == 16).all()
    assert groups.colours.max() == 2


def test_what_does_not_move_is_in_none() -> None:
    held = beam(2, 40, 4)
    moves = held.particles.positions[:, 0] > 0.0
    groups = gather(held, moves)
    assert (groups.of[~moves] == -1).all()
    assert (groups.of[moves] >= 0).all()
    assert gather(held, np.zeros_like(moves)).count == 0


def test_bodies_and_sides_of_a_gap_share_none() -> None:
    """Two bodies that touch, the second a fork whose prongs are a spacing further apart than particles feel."""
    lattice = np.stack(np.meshgrid(np.arange(20.0), np.arange(8.0), indexing="ij"), axis=-1).reshape(-1, 2)
    gap = (np.abs(lattice[:, 1] - 3.5) < 1.0) & (lattice[:, 0] > 3.0)
    fork = block(2, name="fork", shape=Points(0.01 * lattice[~gap]))
    plain = block(2, name="plain", shape=Points(0.01 * (lattice + np.array([0.0, 8.0]))))
    held = strain(scene_of(plain, fork, elasticity=HAMILTONIAN))
    particles = held.particles
    groups = gather(held)
    prongs = 0
    for inside in members(groups):
        assert np.ptp(particles.bodies[inside]) == 0
        places = particles.positions[inside] / 0.01
        if particles.bodies[inside[0]] == 1 and places[:, 0].min() > 3.5:
            prongs += 1
            assert np.ptp(places[:, 1]) < 3.5
    assert prongs >= 4
    assert len(np.unique(groups.bodies)) == 2


def test_large_bodies_have_wider_ones() -> None:
    groups = gather(beam(2, 150, 150))
    assert 0.5 * MOST_UNKNOWNS < 3 * groups.count <= MOST_UNKNOWNS


@pytest.mark.parametrize("counts", [(30, 9), (9, 9, 9)])
def test_none_feels_two_of_one_colour(counts: tuple[int, ...]) -> None:
    groups = gather(beam(len(counts), *counts))
    for row in range(groups.count):
        felt = groups.columns[groups.rows == row]
        assert len(np.unique(groups.colours[felt])) == len(felt)
        assert row in felt

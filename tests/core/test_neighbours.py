"""Neighbour lists against SciPy's k-d tree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from warp_mps.core.device import open_device
from warp_mps.core.neighbours import reference_neighbours


def neighbours(positions: np.ndarray, groups: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The list, made on the CPU."""
    start, index = reference_neighbours(positions, groups, reach, device=open_device("cpu"))
    return start.numpy(), index.numpy()


def pairs_of(start: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Pairs (i, j) of a list, shape [pairs, 2]."""
    return np.column_stack((np.repeat(np.arange(len(start) - 1), np.diff(start)), index))


def expected_pairs(positions: np.ndarray, groups: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Both directions of all pairs closer than their mean reach, in order."""
    found = cKDTree(positions).query_pairs(reach.max() * (1 + 1e-6), output_type="ndarray")
    i, j = np.concatenate((found, found[:, ::-1])).T
    distance = np.linalg.norm(positions[i] - positions[j], axis=1)
    near = (distance < 0.5 * (reach[i] + reach[j]) * (1 + 1e-6)) & (groups[i] == groups[j])
    return np.array(sorted(zip(i[near], j[near], strict=True)))


def lattice(dimension: int, cells: int, spacing: float) -> np.ndarray:
    """A cube of particles away from the origin."""
    line = np.arange(cells) * spacing
    return np.stack(np.meshgrid(*[line] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension) - 7.3


@pytest.mark.parametrize("dimension", [2, 3])
def test_random_points_of_two_groups_and_sizes(dimension: int) -> None:
    rng = np.random.default_rng(3)
    positions = rng.uniform(-5.0, 3.0, (800, dimension)) * (1.0, 0.3, 0.2)[:dimension]
    groups = rng.integers(0, 2, 800)
    reach = np.where(groups == 0, 0.5, 0.8)
    found = pairs_of(*neighbours(positions, groups, reach))
    np.testing.assert_array_equal(found, expected_pairs(positions, groups, reach))


@pytest.mark.parametrize("radius", [1.5, 2.0, 2.1, 3.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_neighbours_exactly_at_the_radius_are_all_kept(dimension: int, radius: float) -> None:
    """Every particle inside a lattice has the same neighbours, whatever the rounding of 0.1 and of the offset."""
    positions = lattice(dimension, 9, 0.1)
    start, index = neighbours(positions, np.zeros(len(positions), int), np.full(len(positions), radius * 0.1))
    found = pairs_of(start, index)
    np.testing.assert_array_equal(
        found, expected_pairs(positions, np.zeros(len(positions), int), np.full(len(positions), radius * 0.1))
    )
    steps = np.stack(np.meshgrid(*[np.arange(-3, 4)] * dimension), axis=-1).reshape(-1, dimension)
    within = int(np.sum(np.linalg.norm(steps, axis=1) <= radius)) - 1
    inside = np.all(np.abs(positions - positions.mean(axis=0)) < 0.15, axis=1)
    assert (np.diff(start)[inside] == within).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_rows_are_sorted_and_pairs_mutual(dimension: int) -> None:
    positions = np.random.default_rng(5).uniform(0.0, 1.0, (500, dimension))
    pairs = pairs_of(*neighbours(positions, np.zeros(500, int), np.full(500, 0.2)))
    assert len(pairs) > 500
    np.testing.assert_array_equal(pairs, np.unique(pairs, axis=0))
    np.testing.assert_array_equal(np.unique(pairs[:, ::-1], axis=0), pairs)


def test_a_long_thin_body_far_larger_than_the_grid() -> None:
    """Cells alias in a grid of bounded size; the distance still decides."""
    positions = np.zeros((6000, 2))
    positions[:, 0] = np.arange(6000) * 1.0
    start, index = neighbours(positions, np.zeros(6000, int), np.full(6000, 1.1))
    expected = np.concatenate([[i - 1] * (i > 0) + [i + 1] * (i < 5999) for i in range(6000)])
    np.testing.assert_array_equal(index, expected)
    assert start[-1] == 2 * 5999


def test_a_single_particle_has_no_neighbour() -> None:
    start, index = neighbours(np.zeros((1, 3)), np.zeros(1, int), np.ones(1))
    assert start.tolist() == [0, 0]
    assert len(index) == 0

"""The weight function and the number density of a full lattice, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from warp_mps.core.weights import lattice_neighbours, lattice_number_density, weight


def test_weight_by_hand() -> None:
    np.testing.assert_allclose(weight(np.array([0.5, 1.0, 2.0, 2.1, 3.0]), 2.1), [3.2, 1.1, 0.05, 0.0, 0.0], atol=1e-15)


def test_weight_takes_a_radius_for_each_pair() -> None:
    np.testing.assert_allclose(weight(np.array([1.0, 1.0]), np.array([2.0, 3.0])), [1.0, 2.0])


@pytest.mark.parametrize(
    ("dimension", "shells"),
    [
        (2, [(4, 1.0), (4, 2.0), (4, 4.0)]),
        (3, [(6, 1.0), (12, 2.0), (8, 3.0), (6, 4.0)]),
    ],
)
def test_number_density_by_hand(dimension: int, shells: list[tuple[int, float]]) -> None:
    """Shells of the lattice within 2.1 spacings: how many neighbours, at what squared distance."""
    expected = sum(count * (2.1 / math.sqrt(square) - 1.0) for count, square in shells)
    assert lattice_number_density(dimension, 2.1) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(("dimension", "expected"), [(2, 4 * 0.5 + 4 * (1.5 / math.sqrt(2) - 1)), (3, 3.72792206)])
def test_number_density_of_a_short_radius(dimension: int, expected: float) -> None:
    assert lattice_number_density(dimension, 1.5) == pytest.approx(expected, rel=1e-8)


def test_neighbours_at_the_radius_weigh_nothing() -> None:
    assert lattice_number_density(2, 2.0) == pytest.approx(4 * 1.0 + 4 * (2 / math.sqrt(2) - 1), rel=1e-14)


@pytest.mark.parametrize(
    ("dimension", "radius", "count"), [(2, 1.5, 8), (2, 2.0, 12), (2, 2.1, 12), (3, 1.5, 18), (3, 2.1, 32)]
)
def test_neighbours_inside_a_lattice(dimension: int, radius: float, count: int) -> None:
    assert lattice_neighbours(dimension, radius) == count

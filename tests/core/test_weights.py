"""The weight function and the number density of a full lattice, by hand."""

import math

import numpy as np
import pytest
import warp as wp

from warp_mps.core.types import PRECISIONS, numeric_types
from warp_mps.core.weights import (
    LEAST_DISTANCE,
    lattice_neighbours,
    lattice_number_density,
    weight,
    weight_function,
    wendland_c2,
    wendland_c2_slope,
    wendland_functions,
)


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


@pytest.mark.parametrize("precision", PRECISIONS)
def test_the_warp_function_is_that_of_numpy(precision: str) -> None:
    """And is finite for two particles in one place."""
    types = numeric_types(2, precision)
    weigh = weight_function(types)
    real = types.real

    @wp.kernel(module="unique", enable_backward=False)
    def weigh_all(r: wp.array(dtype=real), r_e: real, w_out: wp.array(dtype=real)):
        w_out[wp.tid()] = weigh(r[wp.tid()], r_e)

    r = wp.array([0.5, 1.0, 2.0, 2.1, 3.0, 0.0], dtype=real, device="cpu")
    w = wp.zeros_like(r)
    wp.launch(weigh_all, len(r), [r, 2.1], [w], device="cpu")
    np.testing.assert_allclose(w.numpy()[:5], weight(r.numpy()[:5], 2.1), rtol=1e-6, atol=1e-6)
    assert w.numpy()[5] == pytest.approx(1.0 / LEAST_DISTANCE)


def test_wendland_s_kernel_and_its_slope() -> None:
    s = np.linspace(0.0, 1.2, 25)
    step = 1e-6
    difference = (wendland_c2(s + step) - wendland_c2(s - step)) / (2 * step)
    np.testing.assert_allclose(wendland_c2_slope(s), difference, atol=1e-9)
    assert wendland_c2(np.array([0.0, 1.0, 2.0])).tolist() == [1.0, 0.0, 0.0]
    assert (np.diff(wendland_c2(s)) <= 0.0).all()


@pytest.mark.parametrize("precision", PRECISIONS)
def test_wendland_s_kernel_in_warp_is_that_of_numpy(precision: str) -> None:
    """And so is its slope over s, which is finite at 0."""
    types = numeric_types(2, precision)
    functions = wendland_functions(types)
    kernel, slope_ratio = functions.wendland_c2, functions.wendland_c2_slope_ratio
    real = types.real

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(s: wp.array(dtype=real), w_out: wp.array(dtype=real), slope_out: wp.array(dtype=real)):
        i = wp.tid()
        w_out[i] = kernel(s[i])
        slope_out[i] = slope_ratio(s[i])

    s = np.array([0.0, 0.1, 0.5, 0.9, 1.0, 1.5])
    at = wp.array(s, dtype=real, device="cpu")
    w, slope = wp.zeros_like(at), wp.zeros_like(at)
    wp.launch(evaluate, len(s), [at], [w, slope], device="cpu")
    np.testing.assert_allclose(w.numpy(), wendland_c2(s), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(-slope.numpy() * s, wendland_c2_slope(s), rtol=1e-5, atol=1e-6)
    assert slope.numpy()[0] == pytest.approx(20.0)

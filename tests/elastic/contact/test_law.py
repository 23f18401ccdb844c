"""The contact law: how flat a lattice acts, against sums that are independent of the tested code."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from warp_mps.elastic.contact.law import SUPPORT, capacity, law_constants

# spacing of the particle, and of the lattice that it touches
SPACINGS = [(1.0, 1.0), (1.0, 0.5), (0.5, 1.0), (1.0, 0.2), (0.2, 1.0)]


def density(own: float, other: float, gap: float, at: tuple[float, ...]) -> float:
    """The contact density: the sum of W over a half-space, `gap` from its nearest layer and `at` along it, times w."""
    support, lateral = SUPPORT * max(own, other), np.arange(-14, 15) * other
    total = 0.0
    for place in itertools.product(*([lateral] * len(at)), gap + other * np.arange(14)):
        r = np.linalg.norm(np.array(place) - (*at, 0.0))
        total += max(1.0 - r / support, 0.0) ** 4 * (1.0 + 4.0 * r / support)
    return total * law_constants(len(at) + 1, own, other)[0]


@pytest.mark.parametrize(("own", "other"), SPACINGS)
def test_the_contact_density_is_1_at_touch_at_any_lateral_position(own: float, other: float) -> None:
    """The face of a lattice is flat to 1.5 % of the spacing where that is felt, with very unequal spacings to 3 %."""
    touch = 0.5 * (own + other)
    values = [density(own, other, touch, (x * other,)) for x in np.linspace(0.0, 0.9, 10)]
    assert np.mean(values) == pytest.approx(1.0, abs=1e-3)
    slope = (density(own, other, 0.99 * touch, (0.0,)) - density(own, other, 1.01 * touch, (0.0,))) / (0.02 * touch)
    assert np.ptp(values) / slope < (0.003 if own >= other else 0.015) * touch


def test_in_space_too() -> None:
    places = [(x, y) for x in (0.0, 0.25, 0.5) for y in (0.0, 0.25, 0.5)]
    values = [density(1.0, 1.0, 1.0, place) for place in places]
    weights = np.outer((1, 2, 1), (1, 2, 1)).ravel()
    assert np.average(values, weights=weights) == pytest.approx(1.0, abs=1e-3)
    assert np.ptp(values) < 0.03


@pytest.mark.parametrize(("own", "other"), SPACINGS)
def test_both_faces_together_are_as_stiff_as_a_layer_of_the_material(own: float, other: float) -> None:
    """V per area of both sides, twice differentiated at touch, is E/l."""
    mean = 0.5 * (own + other)
    stiffness = 0.0
    for a, b in ((own, other), (other, own)):
        step = 1e-4 * mean
        slope = (density(a, b, mean - step, (0.37 * b,)) - density(a, b, mean + step, (0.37 * b,))) / (2 * step)
        stiffness += law_constants(2, a, b)[1] * slope**2 / a
    assert stiffness * mean == pytest.approx(1.0, rel=0.03)


def test_the_law_scales_with_the_spacing() -> None:
    for dimension in (2, 3):
        weight, scale = law_constants(dimension, 1.0, 0.7)
        small = law_constants(dimension, 1e-3, 0.7e-3)
        assert small[0] == pytest.approx(weight, rel=1e-12)
        assert small[1] == pytest.approx(1e-3**dimension * scale, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("spacing", [1.0, 0.3])
def test_there_is_room_for_a_face_that_is_pressed_in_by_half(dimension: int, spacing: float) -> None:
    reach = 2.35
    lateral = np.arange(-10, 11) * spacing
    points = itertools.product(*([lateral] * (dimension - 1)), 0.25 * (1.0 + spacing) + spacing * np.arange(10))
    found = sum(np.linalg.norm(point) < reach for point in points)
    assert found <= capacity(dimension, reach, spacing) < 5 * found

"""Mass, centre of gravity and inertia of particles."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.run.inventory.mass_properties import mass_properties
from warp_mps.shapes import Box, Sphere, fill


def test_a_plate_has_the_inertia_of_a_solid_one() -> None:
    positions = fill(Box((0.4, 0.1), (1.0, 2.0)), 0.05, 2)
    found = mass_properties(positions, np.full(16, 3.0 * 0.05**2), np.full(16, 0.05))
    assert (found.volume, found.mass) == pytest.approx((0.04, 0.12))
    assert found.centre == pytest.approx((1.0, 2.0))
    assert found.inertia == (pytest.approx((0.12 * (0.4**2 + 0.1**2) / 12.0,)),)


def test_a_turned_brick_has_the_inertia_of_a_solid_one() -> None:
    brick = Box((0.4, 0.2, 0.1)).turned(0.5, axis=(1.0, 2.0, 3.0)).moved((1.0, 2.0, 3.0))
    positions = fill(brick, 0.05, 3)
    found = mass_properties(positions, np.full(len(positions), 7.0 * 0.05**3), np.full(len(positions), 0.05))
    assert found.mass == pytest.approx(0.056)
    assert found.centre == pytest.approx((1.0, 2.0, 3.0))
    own = 0.056 / 12.0 * np.diag([0.2**2 + 0.1**2, 0.4**2 + 0.1**2, 0.4**2 + 0.2**2])
    turn = brick.linear
    assert found.inertia is not None
    np.testing.assert_allclose(found.inertia, turn @ own @ turn.T, atol=1e-15)


def test_a_ball_is_that_of_its_formula() -> None:
    positions = fill(Sphere(0.5), 0.025, 3)
    found = mass_properties(positions, np.full(len(positions), 2.0 * 0.025**3), np.full(len(positions), 0.025))
    assert found.mass == pytest.approx(2.0 * np.pi / 6.0, rel=0.01)
    assert found.inertia is not None
    np.testing.assert_allclose(np.diag(found.inertia), 0.1 * found.mass, rtol=0.02)


def test_walls_have_a_volume_and_no_mass() -> None:
    found = mass_properties(fill(Box((0.2, 0.1)), 0.05, 2), None, np.full(8, 0.05))
    assert found.volume == pytest.approx(0.02)
    assert (found.mass, found.inertia) == (None, None)

"""Collisions of fluid particles with each other and with walls."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import (
    DT,
    KINDS,
    L0,
    finished,
    fluids_of,
    put,
    scene_of,
    small,
    stir,
    tank,
    tolerance,
    total_momentum,
    wall_count,
    water,
)
from warp_mps.fluid.collisions import KEPT_APART, RESTITUTION


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_two_particles_that_approach_collide(precision: str) -> None:
    """Along their line, with the coefficient of restitution, and momentum kept; the velocity across that line stays."""
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0])), precision=precision)
    gap = 0.4 * L0
    put(fluids, {0: ([0.3, 0.3], [0.5, 0.2]), 1: ([0.3 + gap, 0.3], [-0.1, 0.0])})
    du = finished(fluids)
    expected = 0.5 * (1.0 + RESTITUTION) * 0.6
    near = tolerance(precision, 1e-12, 1e-6)
    np.testing.assert_allclose(du[0], [-expected, 0.0], atol=near)
    np.testing.assert_allclose(du[1], [expected, 0.0], atol=near)
    np.testing.assert_allclose(du[2:], 0.0, atol=near)
    # the change of velocity acts on the second half of the step's move
    x = fluids.state.x.numpy()
    np.testing.assert_allclose(x[:2, 0], [0.3 - 0.5 * DT * expected, 0.3 + gap + 0.5 * DT * expected], atol=near)


@pytest.mark.parametrize(
    ("gap", "speed"), [(0.4 * L0, 0.3), (1.001 * KEPT_APART * L0, -0.3), (0.4 * L0, 0.0)], ids=["part", "far", "rest"]
)
def test_what_parts_or_is_far_does_not_collide(gap: float, speed: float) -> None:
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0])))
    put(fluids, {0: ([0.3, 0.3], [0.0, 1.0]), 1: ([0.3 + gap, 0.3], [speed, -1.0])})
    assert not finished(fluids).any()


def test_a_particle_bounces_off_a_wall_which_gets_its_impulse() -> None:
    fluids = fluids_of(tank((8, 8), room=(16, 20), gravity=()))
    w, walls = wall_count(fluids), fluids.state.x.numpy()[: wall_count(fluids)]
    floor = int(np.argmin(np.linalg.norm(walls - [12.5 * L0, -0.5 * L0], axis=1)))
    put(fluids, {0: ([walls[floor, 0], walls[floor, 1] + 0.7 * L0], [0.0, -0.4])})
    du = finished(fluids)
    np.testing.assert_allclose(du[0], [0.0, 0.4 * (1.0 + RESTITUTION)], rtol=1e-12)
    impulse = fluids.state.impulse.numpy()
    np.testing.assert_allclose(impulse[floor], -1000.0 * L0**2 * du[0], rtol=1e-12)
    assert np.count_nonzero(impulse.any(axis=1)) == 1
    assert w == len(impulse)


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_collisions_keep_momentum_and_take_energy(dimension: int, precision: str) -> None:
    """Of many particles that are too close to each other and to walls."""
    fluids = fluids_of(tank(small(dimension), gravity=()), precision=precision)
    stir(fluids, amount=0.7, speed=1.0)
    before, energy = total_momentum(fluids), fluids.energy().kinetic
    du = finished(fluids)
    hit = np.abs(du).max(axis=1) > 0.0
    assert hit.sum() > 5
    change = total_momentum(fluids) - before + fluids.state.impulse.numpy().sum(axis=0)
    np.testing.assert_allclose(change, 0.0, atol=tolerance(precision, 1e-12, 1e-5))
    assert fluids.energy().kinetic < energy

"""Contact of elastic bodies with walls: weight, impulse, work, and no cost without walls."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scenes import HAMILTONIAN, SPRINGS, block, scene_of
from warp_mps.run.simulation import Simulation
from warp_mps.scene import (
    Contact,
    Elasticity,
    HarmonicMotion,
    HarmonicRotation,
    Load,
    Material,
    Scene,
    Support,
    TableMotion,
    Wall,
)
from warp_mps.shapes import Box

SOFT = Material(1000.0, 1e6, 0.3)


def resting(dimension: int, **fields: object) -> Scene:
    """A damped soft block on a floor."""
    size, zero = [0.2, 0.02, 0.2][:dimension], [0.0] * (dimension - 2)
    floor = Wall(name="floor", shape=Box(size, [0.0, -0.025, *zero]), spacing=0.01)
    gravity = [0.0, -9.81, *zero]
    return scene_of(
        block(dimension, material=SOFT), dimension=dimension,
        **{"walls": (floor,), "gravity": gravity, "damping": 100.0, **fields},
    )  # fmt: skip


def pushed(motion: HarmonicMotion | TableMotion | None = None, **fields: object) -> Scene:
    """A block at rest beside a wall, which moves into it."""
    motion = motion or HarmonicMotion(amplitude=(0.01, 0.002), frequency=10.0)
    pusher = Wall(name="pusher", shape=Box((0.02, 0.06), (-0.03, 0.0)), spacing=0.01, motion=motion)
    return scene_of(block(2, material=SOFT), **{"walls": (pusher,), "duration": 0.05, **fields})


def paddled(dimension: int, **fields: object) -> Scene:
    """A paddle that turns about a point below and hits a block beside it."""
    zero = [0.0] * (dimension - 2)
    turn = HarmonicRotation(
        amplitude=0.4, frequency=8.0, phase=-0.2, pivot=[-0.04, -0.1, *zero], axis=(0.0, 0.0, -1.0)
    )  # fmt: skip
    if dimension == 2:  # about the normal, so clockwise is negative
        turn = HarmonicRotation(amplitude=-0.4, frequency=8.0, phase=-0.2, pivot=[-0.04, -0.1])
    paddle = Wall(
        name="paddle", shape=Box([0.02, 0.2, 0.06][:dimension], [-0.04, 0.0, *zero]), spacing=0.01, rotation=turn
    )
    return scene_of(
        block(dimension, material=SOFT), dimension=dimension, **{"walls": (paddle,), "duration": 0.05, **fields}
    )


@pytest.mark.parametrize("elasticity", [HAMILTONIAN, SPRINGS], ids=["hamiltonian", "springs"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_floor_carries_the_weight(dimension: int, elasticity: Elasticity) -> None:
    simulation = Simulation(resting(dimension, elasticity=elasticity))
    n = simulation.particles.elastic
    simulation.advance(int(0.6 / simulation.dt))
    weight = simulation.particles.masses[:n].sum() * 9.81
    expected = np.array([0.0, weight, 0.0][:dimension])
    np.testing.assert_allclose(simulation.contact_forces[:n].sum(axis=0), expected, atol=1e-3 * weight)
    np.testing.assert_allclose(simulation.contact_forces[n:].sum(axis=0), -expected, atol=1e-3 * weight)
    np.testing.assert_allclose(simulation.internal_forces.sum(axis=0), 0.0, atol=1e-12 * weight)
    # the floor neither moves, nor holds energy, nor is a support
    assert not simulation.displacements[n:].any()
    assert not simulation.velocities[n:].any()
    assert not simulation.reactions.any()
    assert simulation.energy.work == 0.0
    assert simulation.energy.kinetic < 1e-6 * simulation.energy.elastic


def test_a_drop_on_a_floor_keeps_its_energy() -> None:
    high = block(2, material=SOFT, shape=Box((0.04, 0.03), (0.0, 0.01)))
    scene = scene_of(high, walls=resting(2).walls, gravity=(0.0, -9.81))
    simulation = Simulation(scene)
    start = simulation.energy
    touched = False
    for _ in range(100):
        simulation.advance(20)
        touched |= simulation.energy.contact > 0.0
        assert simulation.energy.total == pytest.approx(start.total, abs=2e-3 * 12 * 9.81 * 0.01**2 * 1000 * 0.01)
    assert touched
    assert simulation.velocities[: simulation.particles.elastic, 1].mean() > 0.0


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_impulse_of_a_moving_wall_is_the_momentum_of_the_block(precision: str) -> None:
    simulation = Simulation(pushed(), precision=precision)
    n, dt = simulation.particles.elastic, simulation.dt
    impulse = -0.5 * dt * simulation.contact_forces[n:].sum(axis=0)
    for _ in range(600):
        simulation.advance(1)
        impulse -= dt * simulation.contact_forces[n:].sum(axis=0)
    impulse += 0.5 * dt * simulation.contact_forces[n:].sum(axis=0)
    momentum = simulation.particles.masses[:n] @ simulation.velocities[:n]
    assert momentum[0] > 0.5
    np.testing.assert_allclose(momentum, impulse, rtol=1e-11 if precision == "float64" else 1e-4, atol=1e-6)


@pytest.mark.parametrize("kind", ["push", "table", "turn", "turn in space"])
def test_work_of_a_moving_wall_balances_the_energy(kind: str) -> None:
    """The error is of second order in the step."""
    table = TableMotion(
        times=np.array([0.0, 0.01, 0.05]), displacements=np.array([(0.0, 0.0), (0.004, 0.0), (0.05, 0.01)]),
        interpolation="cubic",
    )  # fmt: skip

    def error(step: float) -> float:
        if kind.startswith("turn"):
            scene = paddled(3 if "space" in kind else 2, time_step=step)
        else:
            scene = pushed(table if kind == "table" else None, time_step=step)
        simulation = Simulation(scene)
        start, errors = simulation.energy.balance, []
        for _ in range(20):
            simulation.advance(round(1e-3 / step))
            errors.append(simulation.energy.balance - start)
        energy = simulation.energy
        assert energy.work > 0.5 * energy.kinetic > 1e-4
        assert energy.work == pytest.approx(energy.exchanged, rel=0.01)
        return float(np.abs(errors).max() / energy.work)

    coarse, fine = error(4e-5), error(1e-5)
    assert coarse < 0.01
    assert fine < 0.15 * coarse


@pytest.mark.parametrize("make", [pushed, lambda: paddled(2), lambda: resting(2)], ids=["push", "turn", "rest"])
def test_graphs_launches_and_threads_give_the_same_bits(make) -> None:
    states = []
    for options in ({}, {"graphs": False}, {"threads": 2}):
        simulation = Simulation(make(), **options)
        simulation.advance(333)
        states.append(simulation.state_arrays())
    for other in states[1:]:
        assert other.keys() == states[0].keys()
        for name, array in states[0].items():
            np.testing.assert_array_equal(other[name], array)


@pytest.mark.parametrize("elasticity", [HAMILTONIAN, SPRINGS], ids=["hamiltonian", "springs"])
def test_a_restored_run_is_the_continuous_one(elasticity: Elasticity) -> None:
    scene = paddled(2, elasticity=elasticity)
    simulation = Simulation(scene)
    simulation.advance(300)
    restored = Simulation(scene)
    restored.restore(simulation.state_arrays())
    for name in ("energy", "positions", "velocities", "rotations", "angular_velocities", "pressures"):
        np.testing.assert_array_equal(getattr(restored, name), getattr(simulation, name))
    simulation.advance(200)
    restored.advance(200)
    for name, array in simulation.state_arrays().items():
        np.testing.assert_array_equal(restored.state_arrays()[name], array)


def test_a_wall_out_of_reach_changes_no_bit_of_the_bodies() -> None:
    """Also with supports and loads, which count the particles."""
    held = Support(
        name="grip",
        region=Box((0.011, 1.0), (-0.015, 0.0)),
        motion=HarmonicMotion(amplitude=(0.0, 1e-3), frequency=50.0),
    )
    pull = Load(name="pull", region=Box((0.011, 1.0), (0.015, 0.0)), force=(3.0, 1.0))
    far = Wall(name="far", shape=Box((0.05, 0.05), (5.0, 0.0)), spacing=0.01)
    for elasticity in (HAMILTONIAN, SPRINGS):
        plain = scene_of(
            block(2), supports=(held,), loads=(pull,), elasticity=elasticity, contact=Contact(between="all")
        )
        one, two = Simulation(plain), Simulation(Scene(**{**vars(plain), "walls": (far,)}))
        n = two.particles.elastic
        for simulation in (one, two):
            simulation.advance(500)
        np.testing.assert_array_equal(two.displacements[:n], one.displacements)
        np.testing.assert_array_equal(two.velocities[:n], one.velocities)
        np.testing.assert_array_equal(two.rotations[:n], one.rotations)
        assert two.energy == one.energy


def test_walls_that_move_through_each_other_do_not_touch() -> None:
    motion = HarmonicMotion(amplitude=(0.05, 0.0), frequency=20.0)
    still = Wall(name="still", shape=Box((0.04, 0.04), (1.0, 0.0)), spacing=0.01)
    other = Wall(name="other", shape=Box((0.04, 0.04), (0.96, 0.0)), spacing=0.01, motion=motion)
    simulation = Simulation(scene_of(block(2), walls=(still, other), contact=Contact(between="all")))
    simulation.advance(int(0.0125 / simulation.dt))
    assert simulation.displacements[-16:, 0].min() > 0.04
    assert not simulation.contact_forces.any()
    assert np.isfinite(simulation.energy.balance)


def test_without_contact_a_wall_moves_and_touches_nothing() -> None:
    simulation = Simulation(pushed(contact=Contact(between="none")))
    simulation.advance(500)
    n = simulation.particles.elastic
    assert simulation.displacements[n:, 0].min() > 0.001
    assert not simulation.displacements[:n].any()
    assert simulation.energy.work == 0.0


@pytest.mark.parametrize("elasticity", [HAMILTONIAN, SPRINGS], ids=["hamiltonian", "springs"])
def test_what_is_seen_of_a_wall_particle(elasticity: Elasticity) -> None:
    """Every quantity has a row for it, and none of elasticity is in it."""
    simulation = Simulation(pushed(elasticity=elasticity))
    simulation.advance(200)
    n = simulation.particles.elastic
    elastic = ("pressures", "stresses", "strains", "von_mises", "strain_energy_densities", "elastic_forces")
    for name in (*elastic, "elastic_torques", "reactions"):
        values = getattr(simulation, name)
        assert len(values) == simulation.particles.count
        assert not values[n:].any()
        assert values[:n].any() or name in ("elastic_torques", "reactions")


def test_a_turned_wall_shows_its_rotation() -> None:
    simulation = Simulation(paddled(3))
    simulation.advance(100)
    n, t = simulation.particles.elastic, simulation.time
    angle = 0.4 * (np.sin(16.0 * np.pi * t - 0.2) - np.sin(-0.2))
    np.testing.assert_allclose(
        simulation.rotations[n:], [[0.0, 0.0, -angle]] * (len(simulation.rotations) - n), atol=1e-14
    )

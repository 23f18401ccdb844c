"""Friction: sliding and sticking on an incline, what it conserves and what it dissipates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import HAMILTONIAN, RUBBER, angular_momentum, block, scene_of
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Contact, HarmonicMotion, Material, Scene, Wall
from warp_mps.shapes import Box

SOFT = Material(1000.0, 1e6, 0.3)
G = 9.81


def incline(dimension: int, degrees: float, *, wall: float | None = None, **scene: object) -> Scene:
    """A block on a wall that is inclined by turning gravity, with a friction of 0.3."""
    zero = [0.0] * (dimension - 2)
    angle = np.radians(degrees)
    slope = Wall(
        name="slope", shape=Box([0.16, 0.02, 0.06][:dimension], [0.04, -0.01, *zero]), spacing=0.01, friction=wall
    )
    body = block(dimension, material=SOFT, shape=Box([0.06, 0.03, 0.04][:dimension], [0.003, 0.015, *zero]))
    fields = {
        "dimension": dimension,
        "walls": (slope,),
        "gravity": [G * np.sin(angle), -G * np.cos(angle), *zero],
        "contact": Contact(friction=0.3),
        "elasticity": HAMILTONIAN,
    }
    return scene_of(body, **{**fields, **scene})  # type: ignore[arg-type]


def mean_motion(simulation: Simulation) -> tuple[float, float]:
    """Displacement and velocity of the block along the slope [m, m/s]."""
    body = simulation.particles.bodies == 0
    return float(simulation.displacements[body, 0].mean()), float(simulation.velocities[body, 0].mean())


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_slides_down_with_what_friction_leaves_of_gravity(dimension: int) -> None:
    """Its acceleration is g (sin 30 - 0.3 cos 30)."""
    simulation = Simulation(incline(dimension, 30.0))
    start = simulation.energy.balance
    while simulation.time < 0.2:
        simulation.advance(50)
    expected = G * (0.5 - 0.3 * np.sqrt(0.75))
    assert mean_motion(simulation)[1] == pytest.approx(expected * simulation.time, rel=0.02)
    energy = simulation.energy
    assert energy.dissipated == pytest.approx(0.3 * np.sqrt(0.75) / 0.5 * -energy.potential, rel=0.03)
    assert energy.balance == pytest.approx(start, abs=3e-3 * energy.dissipated)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_sticks_below_the_angle_of_friction_and_does_not_creep(dimension: int, precision: str) -> None:
    simulation = Simulation(incline(dimension, 15.0, damping=200.0), precision=precision)
    while simulation.time < 0.15:
        simulation.advance(50)
    there = mean_motion(simulation)[0]
    while simulation.time < 0.25:
        simulation.advance(50)
    moved = mean_motion(simulation)[0]
    assert 0.0 < there < 1e-4
    assert abs(moved - there) < 1e-7
    body = simulation.particles.bodies == 0
    force, weight = simulation.contact_forces[body].sum(axis=0), simulation.particles.masses[body].sum() * G
    np.testing.assert_allclose(force[:2], [-weight * np.sin(np.pi / 12), weight * np.cos(np.pi / 12)], rtol=1e-3)


def test_a_wall_has_a_friction_of_its_own() -> None:
    speeds = []
    for friction in (0.0, None, 0.5):
        simulation = Simulation(incline(2, 30.0, wall=friction))
        simulation.advance(int(0.1 / simulation.dt))
        speeds.append(mean_motion(simulation)[1] / (G * simulation.time))
    np.testing.assert_allclose(speeds, [0.5, *(0.5 - mu * np.sqrt(0.75) for mu in (0.3, 0.5))], atol=0.01)


def test_without_friction_nothing_is_paid_for_it() -> None:
    assert Simulation(incline(2, 30.0, contact=Contact())).solid.contacts.friction is None
    assert Simulation(incline(2, 30.0, wall=0.0, contact=Contact())).solid.contacts.friction is None
    assert Simulation(incline(2, 30.0, wall=0.1, contact=Contact())).solid.contacts.friction is not None


def grazing(dimension: int, friction: float, **scene: object) -> Scene:
    """A block that falls on another one aslant."""
    rest = [0.0] * (dimension - 2)
    size = [0.04, 0.03, 0.03][:dimension]
    upper = block(dimension, name="upper", shape=Box(size, [-0.013, 0.0305, *rest]), velocity=[4.0, -3.0, *rest])
    lower = block(dimension, (8, 3, 4), name="lower", material=RUBBER)
    fields = {"dimension": dimension, "contact": Contact(friction=friction), "elasticity": HAMILTONIAN}
    return scene_of(upper, lower, **{**fields, **scene})  # type: ignore[arg-type]


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_and_angular_momentum_are_kept_and_the_balance_closes(dimension: int) -> None:
    errors, taken = [], []
    for friction, courant in ((0.0, 0.1), (0.4, 0.1), (0.4, 0.05)):
        simulation = Simulation(grazing(dimension, friction, courant=courant))
        masses = simulation.particles.masses[:, None]

        def kept(simulation: Simulation = simulation, masses: np.ndarray = masses) -> np.ndarray:
            return np.concatenate(((masses * simulation.velocities).sum(axis=0), angular_momentum(simulation)))

        start, balance, worst = kept(), simulation.energy.balance, 0.0
        while simulation.time < 4e-3:
            simulation.advance(10)
            worst = max(worst, abs(simulation.energy.balance - balance))
            np.testing.assert_allclose(kept(), start, atol=1e-12 * np.abs(start).max())
        assert not simulation.contact_forces.any()
        errors.append(worst / balance)
        taken.append(simulation.energy.dissipated / balance)
    assert taken[0] == 0.0
    assert min(taken[1:]) > 0.02
    assert taken[1] == pytest.approx(taken[2], rel=0.05)
    assert max(errors) < 5e-3
    assert errors[2] < 0.5 * errors[1]


def test_what_turns_as_a_whole_does_not_rub() -> None:
    """Two blocks that are pressed into each other are turned together, by a large angle in one step, or slid."""
    upper = block(2, name="upper", shape=Box((0.04, 0.03), (0.003, 0.0295)))
    scene = scene_of(upper, block(2, (8, 3), name="lower"), contact=Contact(friction=0.4))
    turned, slid = Simulation(scene), Simulation(scene)
    x = turned.particles.positions
    cosine, sine = np.cos(0.5), np.sin(0.5)
    moves = {"turned": x @ np.array([(cosine, sine), (-sine, cosine)]) - x, "slid": np.zeros_like(x)}
    moves["slid"][turned.particles.bodies == 0, 0] = 1e-4
    pressed = np.abs(turned.contact_forces).max()
    forces = {}
    for name, simulation in (("turned", turned), ("slid", slid)):
        state = simulation.solid.state
        state.u.assign(moves[name])
        simulation.solid.contacts.launch_force(state)
        forces[name] = np.linalg.norm(simulation.solid.contacts.arrays()["rubbed"], axis=1).max()
    assert forces["turned"] < 1e-9 * pressed
    assert forces["slid"] > 0.1 * pressed


def test_friction_is_bounded_by_the_pressing_force() -> None:
    """Of the whole block; at its ends the particles' own planes are a little aslant."""
    simulation = Simulation(incline(2, 40.0))
    body = simulation.particles.bodies == 0
    ratios = []
    for _ in range(60):
        simulation.advance(20)
        force = simulation.contact_forces[body].sum(axis=0)
        if force[1] > 0.5 * simulation.particles.masses[body].sum() * G:
            ratios.append(-force[0] / force[1])
    assert len(ratios) > 20
    assert max(ratios) < 0.3 * 1.03
    assert np.median(ratios) == pytest.approx(0.3, rel=0.02)


def test_graphs_launches_and_threads_give_the_same_bits_and_a_restored_run_too() -> None:
    scene = grazing(2, 0.4)
    states = []
    for options in ({}, {"graphs": False}, {"threads": 2}):
        simulation = Simulation(scene, **options)
        simulation.advance(150)
        states.append(simulation.state_arrays())
    middle = Simulation(scene)
    middle.advance(70)
    assert middle.energy.dissipated > 0.0
    restored = Simulation(scene)
    restored.restore(middle.state_arrays())
    assert restored.energy == middle.energy
    restored.advance(80)
    states.append(restored.state_arrays())
    for other in states[1:]:
        assert other.keys() == states[0].keys()
        for name, array in states[0].items():
            np.testing.assert_array_equal(other[name], array, err_msg=name)


def test_a_belt_does_the_work_that_it_takes() -> None:
    """A wall that is drawn along under a block: its work is what the block gains and what friction takes out."""
    errors = []
    for step in (4e-5, 2e-5):
        still = incline(2, 0.0, time_step=step)
        belt = replace(still.walls[0], motion=HarmonicMotion(amplitude=(0.02, 0.0), frequency=8.0))
        simulation = Simulation(replace(still, walls=(belt,)))
        start = simulation.energy.balance
        while simulation.time < 0.05:
            simulation.advance(50)
        energy = simulation.energy
        assert energy.dissipated > 0.2 * energy.work > 0.0
        errors.append(abs(energy.balance - start) / energy.work)
    assert max(errors) < 0.01

"""Loads: the motion that they give a body, and their work."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scenes import LENGTH, beam, block, scene_of
from warp_mps.errors import InputError
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Load
from warp_mps.shapes import Box

TIP = Box((0.05, 0.1), (LENGTH, 0.0))


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_constant_load_on_a_whole_body(dimension: int, precision: str) -> None:
    """A force and an acceleration together on a body that flies: a = F/m + g, every particle alike."""
    flight = np.array((-0.2, 0.3, 0.1)[:dimension])
    force, push = np.array((3.0, -1.0, 0.5)[:dimension]), np.array((0.5, 2.0, -1.0)[:dimension])
    load = Load(name="push", region=Box([1.0] * dimension), force=force, acceleration=push)
    simulation = Simulation(
        scene_of(block(dimension, velocity=flight), dimension=dimension, loads=(load,)), precision=precision
    )
    mass, start = simulation.particles.masses.sum(), simulation.energy.kinetic
    simulation.advance(1000)
    rounding = {"float64": 1e-11, "float32": 1e-4}[precision]
    acceleration, t = force / mass + push, simulation.time
    path = flight * t + 0.5 * acceleration * t**2
    scale = np.abs(path).max()
    np.testing.assert_allclose(simulation.displacements - path, 0.0, atol=rounding * scale)
    kinetic = 0.5 * mass * np.sum((flight + acceleration * t) ** 2)
    assert simulation.energy.kinetic == pytest.approx(kinetic, rel=rounding)
    assert simulation.energy.work == pytest.approx(kinetic - start, rel=10 * rounding)
    np.testing.assert_allclose(simulation.internal_forces, 0.0, atol=10 * rounding * np.abs(force).max())


def test_a_harmonic_load_on_a_whole_body() -> None:
    """The velocity is (a / w)(cos(phase) - cos(w t + phase)), but for the step's second order."""
    load = Load(name="push", region=Box((1.0, 1.0)), acceleration=(5.0, -3.0), frequency=40.0, phase=0.7)
    simulation = Simulation(scene_of(block(2), loads=(load,), time_step=2e-5))
    simulation.advance(2000)
    w = 2 * np.pi * 40.0
    speed = (np.cos(0.7) - np.cos(w * simulation.time + 0.7)) / w
    expected = np.broadcast_to(np.array([5.0, -3.0]) * speed, simulation.velocities.shape)
    np.testing.assert_allclose(simulation.velocities, expected, rtol=(w * 2e-5) ** 2)
    np.testing.assert_allclose(simulation.internal_forces, 0.0, atol=1e-12)
    assert simulation.energy.work == pytest.approx(simulation.energy.kinetic, rel=(w * 2e-5) ** 2)


@pytest.mark.parametrize("damping", [0.0, 50.0])
def test_work_balances_the_energy_of_a_deforming_body(damping: float) -> None:
    """The error of the balance is of second order in the step."""

    def error(steps: int) -> float:
        load = Load(name="push", region=TIP, force=(0.0, 50.0), frequency=5.0, phase=0.4)
        simulation = Simulation(beam(2, loads=(load,), damping=damping, time_step=0.05 / steps))
        simulation.advance(steps)
        assert simulation.energy.work > 0.5
        return abs(simulation.energy.balance) / simulation.energy.work

    errors = np.array([error(steps) for steps in (2500, 5000, 10000)])
    print(f"relative errors of the balance: {errors}")
    assert errors[0] < 1e-4
    assert (errors[:-1] / errors[1:] > 3.5).all()


def test_loads_act_on_their_region_and_bodies_and_add_up() -> None:
    bodies = [block(2, name=name, shape=Box((0.04, 0.03), (x, 0.0))) for name, x in (("a", 0.0), ("b", 0.05))]
    loads = (
        Load(name="one", region=Box((1.0, 1.0)), force=(0.0, 6.0), bodies=("b",)),
        Load(name="two", region=Box((0.02, 1.0), (0.06, 0.0)), force=(0.0, 6.0), bodies=("b",)),
    )
    simulation = Simulation(scene_of(*bodies, loads=loads))
    force = simulation.solid.state.force.numpy()
    x = simulation.particles.positions[:, 0]
    np.testing.assert_allclose(force[:, 1], np.where(x < 0.03, 0.0, 0.5) + np.where(x > 0.05, 1.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(simulation.internal_forces, 0.0, atol=1e-15)


def test_a_load_that_acts_on_nothing_is_refused() -> None:
    load = Load(name="push", region=Box((0.01, 0.01), (9.0, 0.0)), force=(1.0, 0.0))
    with pytest.raises(InputError, match="load 'push' region: the load holds no particle"):
        Simulation(beam(2, loads=(load,)))

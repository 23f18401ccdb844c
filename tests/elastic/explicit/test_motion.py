"""The time integration: energy, momenta, order, and motions with a formula."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scenes import LENGTH, angular_momentum, beam, block, random, scene_of
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Scene, VelocityField
from warp_mps.shapes import Box, Points

GRAVITY = {2: (1.0, -9.81), 3: (1.0, -9.81, 2.0)}


def bending(amplitude: float) -> Body:
    """The paper's beam of 2 layers, in its first free mode but for the particles' rotation."""
    field = VelocityField(
        kind="free_free_beam", amplitude=(0.0, amplitude), axis=(1.0, 0.0), origin=(0.0, 0.0), length=LENGTH
    )
    (body,) = beam(2).bodies
    return Body(**{**body.__dict__, "velocity_field": field})


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_energy_of_twenty_periods(precision: str) -> None:
    """A beam that bends by a third of its thickness.

    Its particles start unrotated, which also sets off the fastest motion there is, their rotation; that is what the
    error of a moment is made of. The error does not grow.
    """
    simulation = Simulation(beam(2, bodies=(bending(3.0),)), precision=precision)
    start = simulation.energy
    balances, elastic = [], []
    while simulation.time < 20 * 2 * np.pi / 400.0:
        simulation.advance(32)
        balances.append(simulation.energy.balance)
        elastic.append(simulation.energy.elastic)
    error = np.array(balances) / start.balance - 1.0
    drift = error[-len(error) // 10 :].mean() - error[: len(error) // 10].mean()
    print(f"{precision}: largest error {np.abs(error).max():.2e}, drift {drift:.2e} over {simulation.step} steps")
    assert max(elastic) > 0.8 * start.balance
    assert np.abs(error).max() < 2.5e-3
    assert abs(drift) < 1e-4


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_integrator_is_of_second_order(dimension: int) -> None:
    """Positions, rotations and energy of a body that spins and vibrates by some percent, against a fine step."""

    def after(steps: int) -> tuple[np.ndarray, float]:
        simulation = Simulation(tumbling(dimension, duration=2e-3, time_step=2e-3 / steps))
        energy = simulation.energy.balance
        simulation.advance(steps)
        return np.hstack((simulation.displacements, 0.01 * simulation.rotations)), simulation.energy.balance - energy

    exact, _ = after(8192)
    errors = np.array([[np.abs(motion - exact).max(), abs(gain)] for motion, gain in map(after, (256, 512, 1024))])
    orders = np.log2(errors[:-1] / errors[1:])
    print(f"{dimension}-D orders of motion and energy:\n{orders.round(2)}")
    assert orders == pytest.approx(2.0, abs=0.1)


def tumbling(dimension: int, **scene: object) -> Scene:
    """A block that flies, spins and vibrates, every particle with a velocity of its own."""
    box = block(dimension)
    positions = np.stack(np.meshgrid(*[np.arange(n) * 0.01 for n in (4, 3, 2)[:dimension]]), axis=-1)
    positions = positions.reshape(-1, dimension)
    shape = Points(positions, random(len(positions), dimension))
    spin = 200.0 if dimension == 2 else (100.0, -50.0, 200.0)
    flight = (3.0, -2.0, 1.0)[:dimension]
    body = Body(name="a", shape=shape, material=box.material, spacing=0.01, velocity=flight, angular_velocity=spin)
    return scene_of(body, dimension=dimension, **scene)


@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_momenta_are_kept_to_rounding(dimension: int, normalization: str) -> None:
    simulation = Simulation(tumbling(dimension, elasticity=Elasticity(model="springs", normalization=normalization)))
    particles = simulation.particles

    def momenta() -> tuple[np.ndarray, np.ndarray]:
        return (particles.masses[:, None] * simulation.velocities).sum(axis=0), angular_momentum(simulation)

    start = momenta()
    simulation.advance(2000)
    assert np.abs(simulation.rotations).max() > 0.5
    for before, now in zip(start, momenta(), strict=True):
        np.testing.assert_allclose(now, before, atol=1e-12 * np.abs(before).max())


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_rest_stays_rest(dimension: int, precision: str) -> None:
    apart = [
        block(dimension, name=name, shape=Box([0.03] * dimension, [x] + [0.0] * (dimension - 1)))
        for name, x in (("a", 0.0), ("b", 0.05))
    ]
    simulation = Simulation(scene_of(*apart, dimension=dimension), precision=precision)
    simulation.advance(200)
    for values in (simulation.displacements, simulation.velocities, simulation.angular_velocities):
        assert (values == 0.0).all()
    assert simulation.energy.total == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_that_touch_at_rest_stay_there(dimension: int) -> None:
    """Neighbours across the joint are one spacing apart but for rounding."""
    apart = [
        block(dimension, name=name, shape=Box([0.03] * dimension, [x] + [0.1] * (dimension - 1)))
        for name, x in (("a", 0.1), ("b", 0.13))
    ]
    simulation = Simulation(scene_of(*apart, dimension=dimension))
    simulation.advance(500)
    np.testing.assert_allclose(simulation.displacements, 0.0, atol=1e-13 * 0.01)


@pytest.mark.parametrize("dimension", [2, 3])
def test_free_fall(dimension: int) -> None:
    flight = (0.3, 0.2, -0.1)[:dimension]
    simulation = Simulation(
        scene_of(block(dimension, velocity=flight), dimension=dimension, gravity=GRAVITY[dimension])
    )
    start = simulation.energy.balance
    simulation.advance(3000)
    t, g = simulation.time, np.array(GRAVITY[dimension])
    fall = np.array(flight) * t + 0.5 * g * t**2
    np.testing.assert_allclose(
        simulation.displacements, np.broadcast_to(fall, simulation.displacements.shape), rtol=1e-11
    )
    np.testing.assert_allclose(
        simulation.velocities, np.broadcast_to(flight + g * t, simulation.velocities.shape), rtol=1e-11
    )
    assert simulation.energy.balance == pytest.approx(start, rel=1e-10)
    weights = simulation.particles.masses.sum() * g
    np.testing.assert_allclose(simulation.internal_forces.sum(axis=0), 0.0, atol=1e-12 * np.abs(weights).max())


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_damping_slows_a_free_body_exponentially(dimension: int, precision: str) -> None:
    flight = np.array((3.0, -2.0, 1.0)[:dimension])
    scene = scene_of(block(dimension, velocity=flight), dimension=dimension, damping=40.0)
    simulation = Simulation(scene, precision=precision)
    start = simulation.energy
    simulation.advance(2000)
    slower = np.exp(-40.0 * simulation.time)
    assert slower < 0.5
    # every step multiplies twice by a factor that is rounded
    tolerance = 4000 * {"float64": 1.1e-16, "float32": 6e-8}[precision]
    np.testing.assert_allclose(
        simulation.velocities, np.broadcast_to(flight * slower, simulation.velocities.shape), rtol=tolerance
    )
    assert simulation.energy.kinetic == pytest.approx(start.kinetic * slower**2, rel=2 * tolerance)
    assert simulation.energy.dissipated == pytest.approx(start.kinetic * (1.0 - slower**2), rel=10 * tolerance)


def test_damping_of_a_vibrating_body_keeps_the_balance() -> None:
    simulation = Simulation(beam(2, bodies=(bending(3.0),), damping=30.0))
    start = simulation.energy.balance
    simulation.advance(3000)
    energy = simulation.energy
    assert energy.dissipated > 0.5 * start
    assert energy.total < 0.5 * start
    assert energy.balance == pytest.approx(start, rel=1e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_damping_slows_the_rotation_of_particles(dimension: int) -> None:
    """A single particle turns with nothing to hold it."""
    spin = 10.0 if dimension == 2 else (0.0, 6.0, 8.0)
    body = block(dimension, (1, 1, 1), angular_velocity=spin)
    simulation = Simulation(scene_of(body, dimension=dimension, damping=5.0, time_step=1e-4))
    start = simulation.energy
    simulation.advance(1000)
    slower = np.exp(-5.0 * simulation.time)
    np.testing.assert_allclose(np.linalg.norm(simulation.angular_velocities, axis=1), 10.0 * slower, rtol=1e-12)
    angle = 10.0 / 5.0 * (1.0 - slower)
    np.testing.assert_allclose(np.linalg.norm(simulation.rotations, axis=1), angle, rtol=1e-6)
    assert simulation.energy.balance == pytest.approx(start.balance, rel=1e-12)

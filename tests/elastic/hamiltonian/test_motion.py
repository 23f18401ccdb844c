"""Runs of the Hamiltonian model: energy, momenta, spins, the same bits, and the oscillating plate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.bits import assert_same_bits, states
from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.elastic.states import rigid_displacement, strain
from tests.run.test_simulation import everything
from tests.scenes import HAMILTONIAN, angular_momentum, block, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.run.simulation import Simulation
from warp_mps.run.steps import BLOCK
from warp_mps.scene import LAWS, Body, Material, Scene, Support, VelocityField
from warp_mps.shapes import Box

KINDS = [(dimension, precision) for dimension in (2, 3) for precision in ("float64", "float32")]
WIDTH = 0.02
PERIOD = 0.2551  # s: the oscillating plate by 2-D elasticity


def plate(layers: int, tip_speed: float, *, length: float = 0.2, law: str = LAWS[0]) -> Scene:
    """The plate of Gray, Monaghan and Swift (2001), from its clamp at x = 0 on, and two columns of particles in it.

    Args:
        layers: Particles through the thickness.
        tip_speed: Velocity of the tip in the first mode at the start [m/s].
        length: Length [m].
        law: Law of the material.
    """
    grip = 2 * WIDTH / layers
    field = VelocityField(
        kind="clamped_free_beam", amplitude=(0.0, tip_speed), axis=(1.0, 0.0), origin=(0.0, 0.0), length=length
    )
    shape = Box((length + grip, WIDTH), (0.5 * (length - grip), 0.0))
    material = Material(1000.0, 2e6, 0.3975, law)
    body = Body(name="plate", shape=shape, material=material, spacing=WIDTH / layers, velocity_field=field)
    clamp = Support(name="clamp", region=Box((2 * grip, 2 * WIDTH), (-grip, 0.0)))
    return scene_of(body, supports=(clamp,), elasticity=HAMILTONIAN)


def swing(simulation: Simulation, duration: float, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and mean deflections of the end section [m]."""
    x = simulation.particles.positions[:, 0]
    tip, times, deflections = x == x.max(), [0.0], [0.0]
    while simulation.time < duration:
        simulation.advance(every)
        times.append(simulation.time)
        deflections.append(simulation.displacements[tip, 1].mean())
    return np.array(times), np.array(deflections)


def period_of(times: np.ndarray, deflections: np.ndarray) -> float:
    """Time of the last passage through zero upwards, over the number of them [s]; the first is the start."""
    k = np.flatnonzero((deflections[1:-1] <= 0.0) & (deflections[2:] > 0.0)) + 1
    crossings = times[k] - deflections[k] * (times[k + 1] - times[k]) / (deflections[k + 1] - deflections[k])
    return float(crossings[-1] / len(crossings))


@pytest.mark.parametrize(
    ("layers", "periods", "tolerance"),
    [
        (5, 2, 0.01),
        pytest.param(10, 1, 0.01, marks=pytest.mark.long),
        pytest.param(20, 1, 0.01, marks=pytest.mark.slow),
    ],
)
def test_oscillating_plate(layers: int, periods: int, tolerance: float) -> None:
    """Amplitude 0.115 of the length: a tip speed of 0.01 c0, c0 = 57.0 m/s."""
    simulation = Simulation(plate(layers, 0.57), threads=2 if layers > 10 else 1)
    times, deflections = swing(simulation, (periods + 0.05) * PERIOD, 128)
    period, amplitude = period_of(times, deflections), np.abs(deflections).max() / 0.2
    # the last particles stand half a spacing before the tip, whose slope is 1.3765 times its deflection over the length
    amplitude /= 1.0 - 1.3765 * 0.5 * (WIDTH / layers) / 0.2
    print(f"{layers} particles: {period:.5f} s ({100 * (period / PERIOD - 1):+.2f} %), amplitude {amplitude:.4f} L")
    assert period == pytest.approx(PERIOD, rel=tolerance)
    assert amplitude == pytest.approx(0.115, rel=0.01)


def test_the_plate_is_as_long_as_it_is_drawn() -> None:
    """The clamp acts at its face, half a spacing in front of its last particles."""
    errors = []
    for layers in (5, 10):
        scene = plate(layers, 0.57)
        particles = fill_scene(scene)
        held = np.repeat(particles.positions[:, :1] < 0.0, 2, axis=1)
        (omega,), _ = linear_hamiltonian(scene, particles, held, face=0.0).modes(1)
        errors.append(2 * np.pi / omega / PERIOD - 1.0)
    assert 100 * np.array(errors) == pytest.approx([0.51, 0.32], abs=0.02)


@pytest.mark.parametrize("law", LAWS)
def test_energy_of_a_cantilever_over_twenty_periods(law: str) -> None:
    """It swings by a tenth of its length, 5 times its thickness."""
    simulation = Simulation(plate(4, 1.0, length=0.1, law=law))
    start, balances = simulation.energy.balance, []
    period = PERIOD * 0.25
    x = simulation.particles.positions[:, 0]
    deflection = 0.0
    while simulation.time < 20 * period:
        simulation.advance(96)
        balances.append(simulation.energy.balance)
        deflection = max(deflection, np.abs(simulation.displacements[x == x.max(), 1]).max())
    error = np.array(balances) / start - 1.0
    drift = error[-len(error) // 10 :].mean() - error[: len(error) // 10].mean()
    print(f"{law}: deflection {deflection / 0.1:.3f} L, error {np.abs(error).max():.1e}, drift {drift:.1e}")
    assert 0.09 < deflection / 0.1 < 0.12
    assert np.abs(error).max() < 1e-3
    assert abs(drift) < 1e-4


def spinning(
    dimension: int, *, speed: float = 30.0, law: str = LAWS[0], noise: float = 0.0, cells: tuple[int, ...] = (4, 3, 2)
) -> Simulation:
    """A block that flies and spins, and vibrates where there is noise: a velocity of each particle's own [m/s]."""
    spin = speed if dimension == 2 else speed * np.array([2.0, -1.0, 2.0]) / 3
    flight = (0.3, -0.2, 0.1)[:dimension]
    body = block(dimension, cells, angular_velocity=spin, velocity=flight)
    body = replace(body, material=replace(body.material, law=law))
    simulation = Simulation(scene_of(body, dimension=dimension, elasticity=HAMILTONIAN))
    simulation.solid.state.v.assign(simulation.velocities + noise * random(simulation.particles.count, dimension))
    return simulation


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_and_angular_momentum_are_kept(dimension: int, law: str) -> None:
    """A block that spins once and vibrates by some percent."""
    simulation = spinning(dimension, speed=200.0, law=law, noise=5.0)
    masses = simulation.particles.masses
    simulation.advance(1)
    momentum, moment = masses @ simulation.velocities, angular_momentum(simulation)
    energy = simulation.energy.balance
    simulation.advance(round(2 * np.pi / 200.0 / simulation.dt))
    assert simulation.energy.elastic > 0.01 * energy
    np.testing.assert_allclose(masses @ simulation.velocities, momentum, rtol=1e-11)
    np.testing.assert_allclose(angular_momentum(simulation), moment, atol=1e-11 * np.abs(moment).max())
    assert simulation.energy.balance == pytest.approx(energy, rel=2e-2)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_ten_turns_leave_no_stress(dimension: int, law: str) -> None:
    """The spin strains the block by rho (omega R)^2 / E; that is the same in the last turn as in the first."""
    # a cube keeps its axis of rotation
    simulation = spinning(dimension, law=law, cells=(3, 3, 3))
    turn = 2 * np.pi / 30.0
    peaks, every = [], round(0.05 * turn / simulation.dt)
    total = simulation.energy.total
    for _ in range(10):
        energies = []
        while len(energies) < 20:
            simulation.advance(every)
            energies.append(simulation.energy.elastic)
        peaks.append(max(energies))
    print(f"{dimension}-D {law}: elastic energy {peaks[0] / total:.1e} to {peaks[-1] / total:.1e} of the whole")
    assert simulation.time == pytest.approx(10 * turn, rel=0.01)
    # half of it is of order rho (omega R)^2 / E = 6e-5, R the half diagonal
    assert max(peaks) < 3e-5 * total
    assert max(peaks[5:]) < 1.2 * max(peaks[:5])
    axis = np.array([1.0] if dimension == 2 else [2 / 3, -1 / 3, 2 / 3])
    left_over = (30.0 * simulation.time) % (2 * np.pi)
    left_over -= 2 * np.pi * (left_over > np.pi)
    expected = np.broadcast_to(left_over * axis, simulation.rotations.shape)
    np.testing.assert_allclose(simulation.rotations, expected, atol=5e-3)


@pytest.mark.parametrize(("precision", "limit"), [("float64", 3e-14), ("float32", 2e-5)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_pressure_after_ten_turns_placed(dimension: int, precision: str, limit: float) -> None:
    """Particles placed where ten turns and a bit bring them: strains of some roundings remain."""
    held = strain(scene_of(block(dimension), dimension=dimension, elasticity=HAMILTONIAN), precision)
    axis = np.array([1.0]) if dimension == 2 else np.array([2.0, -1.0, 2.0]) / 3
    held.put(rigid_displacement(held.particles, (20 * np.pi + 0.7) * axis))
    largest = np.abs(held.model.pressures()).max() / 1e7
    print(f"{dimension}-D {precision}: pressure {largest:.1e} E")
    assert largest < limit


def hamiltonian(dimension: int) -> Scene:
    """Bodies in contact, shaken, pushed and damped, of both laws, the first nearly incompressible."""
    scene = everything(dimension)
    first, *others = scene.bodies
    material = replace(first.material, law="neo_hookean", poissons_ratio=0.47, retardation_time=1e-6)
    return replace(scene, bodies=(replace(first, material=material), *others), elasticity=HAMILTONIAN, plane="strain")


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_graphs_kernels_and_threads_give_the_same_bits(dimension: int, precision: str) -> None:
    chunks, scene = (1, BLOCK + 1, 60), hamiltonian(dimension)
    expected = states(Simulation(scene, precision=precision), *chunks)
    assert expected[1]["contact"].any()
    for options in ({"graphs": False}, {"threads": 2}):
        assert_same_bits(states(Simulation(scene, precision=precision, **options), *chunks), expected)


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_a_restored_run_continues_to_the_same_bits(dimension: int, precision: str) -> None:
    scene = hamiltonian(dimension)
    simulation = Simulation(scene, precision=precision)
    simulation.advance(50)
    saved, seen = simulation.state_arrays(), (simulation.pressures, simulation.rotations, simulation.energy)
    later = states(simulation, 45, 80)
    restored = Simulation(scene, precision=precision)
    restored.advance(3)
    restored.restore(saved)
    np.testing.assert_array_equal(restored.pressures, seen[0])
    np.testing.assert_array_equal(restored.rotations, seen[1])
    assert restored.energy == seen[2]
    assert_same_bits(states(restored, 45, 80), later)

"""The theta rule: its frequency and damping, balances, what may be prescribed, and going back in time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.bits import assert_restored_goes_on, assert_same_bits
from tests.elastic.implicit.plates import DEFLECTION, plate
from tests.scenes import angular_momentum, block
from warp_mps.core.device import load_modules, open_device
from warp_mps.core.types import numeric_types
from warp_mps.elastic.declare_kernels import declare_kernels
from warp_mps.elastic.implicit.kernels import declare_implicit
from warp_mps.elastic.implicit.solid import ImplicitSolid
from warp_mps.errors import RunError
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.selection import select
from warp_mps.results.sinusoid_fit import dominant, fit
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, HarmonicMotion, Load, Material, Scene, Support, TableMotion, VelocityField
from warp_mps.shapes import Box

EDGE = Box((0.012, 1.0), center=(-0.05, 0.0))
TIP = Box((0.012, 1.0), center=(0.05, 0.0))


def rod(**scene: object) -> Scene:
    """A bar of rubber of 10 by 3 cm that is held at its left end, in implicit steps of 10 microseconds."""
    body = block(2, (10, 3))
    fields = {"supports": (Support(name="clamp", region=EDGE),), "integrator": "implicit", "time_step": 1e-5}
    return Scene(**{"bodies": (body,), "duration": 1.0, **fields, **scene})  # type: ignore[arg-type]


def implicit(simulation: Simulation) -> ImplicitSolid:
    solid = simulation.solid
    assert isinstance(solid, ImplicitSolid)
    return solid


def deflections(scene: Scene, steps: int) -> tuple[Simulation, np.ndarray]:
    """Mean deflection of the tip after every step, from a first bending velocity."""
    simulation = Simulation(scene)
    tip = select(simulation.particles, TIP)
    found = []
    for _ in range(steps):
        simulation.advance(1)
        found.append(simulation.displacements[tip, 1].mean())
    return simulation, np.array(found)


BENDING = VelocityField(
    kind="clamped_free_beam", amplitude=(0.0, 0.05), axis=(1.0, 0.0), origin=(-0.045, 0.0), length=0.095
)


@pytest.mark.parametrize("theta", [0.5, 0.55, 1.0])
def test_frequency_and_damping_are_those_of_the_rule(theta: float) -> None:
    """A small vibration in 50 steps a period, whose frequency short explicit steps give.

    Each step multiplies an oscillation exp(i omega t) by (1 + (1 - theta) z)/(1 - theta z), z = i omega dt.
    """
    body = block(2, (10, 3), velocity_field=BENDING)
    exact = rod(bodies=(body,), integrator="explicit", time_step=2e-6)
    simulation, (times, values) = Simulation(exact), ([], [])
    tip = select(simulation.particles, TIP)
    for step in range(1, 401):
        simulation.advance(20)
        times.append(step * 40e-6)
        values.append(simulation.displacements[tip, 1].mean())
    omega = dominant(np.array(times), np.array(values))
    dt = 2.0 * np.pi / omega / 50.0
    _, found = deflections(rod(bodies=(body,), time_step=dt, theta=theta), 100)
    factor = (1.0 + (1.0 - theta) * 1j * omega * dt) / (1.0 - theta * 1j * omega * dt)
    steps = np.arange(1, 101)
    grown = found / np.abs(factor) ** steps
    assert dominant(steps * dt, grown) == pytest.approx(np.angle(factor) / dt, rel=2e-3)
    halves = [np.hypot(*fit(steps[k : k + 50], grown[k : k + 50], [np.angle(factor)])[0][:2]) for k in (0, 50)]
    assert halves[1] == pytest.approx(halves[0], rel=0.02)


@pytest.mark.parametrize("theta", [0.5, 0.55, 1.0])
def test_energy_is_accounted_for(theta: float) -> None:
    """What the rule takes out is counted; the midpoint rule takes nothing."""
    body = block(2, (10, 3), velocity_field=BENDING)
    simulation = Simulation(rod(bodies=(body,), time_step=2e-4, theta=theta, gravity=(0.0, -9.81), damping=3.0))
    start = simulation.energy
    simulation.advance(60)
    energy = simulation.energy
    assert energy.balance == pytest.approx(start.balance, abs=2e-3 * start.kinetic)
    free = Simulation(rod(bodies=(body,), time_step=2e-4, theta=theta))
    free.advance(60)
    if theta == 0.5:
        assert free.energy.dissipated == 0.0
    else:
        assert 0.05 * start.kinetic < free.energy.dissipated < start.kinetic


def test_steps_far_beyond_the_explicit_limit_are_stable() -> None:
    """A stiff bar in steps 1000 times as long as explicit ones may be, until it rests in its equilibrium."""
    metal = Material(2700.0, 67.5e9, 0.34)
    body = block(2, (10, 3), material=metal)
    limit = Simulation(rod(bodies=(body,), integrator="explicit", time_step=1e-9)).longest_step[1]
    scene = rod(bodies=(body,), time_step=1000.0 * limit, gravity=(0.0, -9.81))
    moving, found = deflections(scene, 60)
    still = Simulation(replace(scene, integrator="explicit", analysis="static"))
    still.advance(still.total_steps)
    sag = still.displacements[select(still.particles, TIP), 1].mean()
    assert found[0] < 0.0
    assert np.abs(found).max() < 2.1 * abs(sag)
    assert found[-1] == pytest.approx(sag, rel=1e-3)
    assert moving.energy.kinetic < 1e-3 * moving.energy.elastic


def middle_of(scene: Scene, steps: int) -> np.ndarray:
    """Deflection of the plate's middle after every step [m]."""
    simulation = Simulation(scene)
    middle = np.abs(simulation.particles.positions[:, 0]) < 0.006
    found = []
    for _ in range(steps):
        simulation.advance(1)
        found.append(simulation.displacements[middle, 1].mean())
    return np.array(found)


def test_a_plate_of_metal_rings_and_settles() -> None:
    """At 269 Hz, by finite elements, and in steps of 0.5 ms, 400 times the explicit ones, at rest."""
    dt = 1e-4
    ringing = middle_of(plate(5, integrator="implicit", time_step=dt, theta=0.5), 100)
    assert dominant(dt * np.arange(100), ringing) / (2.0 * np.pi) == pytest.approx(269.0, rel=0.015)
    settling = middle_of(plate(5, integrator="implicit", time_step=5e-4, theta=1.0), 40)
    assert settling[-1] == pytest.approx(DEFLECTION, rel=0.02)
    assert settling.min() > 2.03 * DEFLECTION


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_free_body_keeps_its_momenta(dimension: int, theta: float) -> None:
    """It flies and turns by 0.1 rad a step; the midpoint rule keeps angular momentum as well, in large rotation."""
    spin = 20.0 if dimension == 2 else (10.0, 20.0, -5.0)
    velocity = (1.0, 0.5, 0.2)[:dimension]
    body = block(dimension, velocity=velocity, angular_velocity=spin)
    scene = Scene(bodies=(body,), dimension=dimension, duration=1.0, integrator="implicit", time_step=5e-3, theta=theta)
    simulation = Simulation(scene)
    masses = simulation.particles.masses
    before, turning = masses @ simulation.velocities, angular_momentum(simulation)
    simulation.advance(30)
    np.testing.assert_allclose(masses @ simulation.velocities, before, rtol=1e-7)
    centre = masses @ simulation.displacements / masses.sum()
    np.testing.assert_allclose(centre, 0.15 * np.array(velocity), rtol=1e-7)
    if theta == 0.5:
        np.testing.assert_allclose(angular_momentum(simulation), turning, rtol=1e-5, atol=1e-6 * np.abs(turning).max())


@pytest.mark.parametrize("theta", [0.5, 0.55])
def test_loads_and_moving_supports_do_work(theta: float) -> None:
    """Along a table and in harmonic motion; the balance is kept, and supports are where they should be."""
    times = np.linspace(0.0, 0.02, 5)
    way = np.column_stack((0.004 * np.sin(150.0 * times), 0.002 * times / 0.02))
    motions = [
        TableMotion(times=times, displacements=way, interpolation="cubic"),
        HarmonicMotion(amplitude=(0.001, 0.002), frequency=40.0, phase=0.3),
    ]
    push = Load(name="push", region=TIP, force=(20.0, -50.0), frequency=30.0, phase=0.4)
    for motion in motions:
        clamp = Support(name="clamp", region=EDGE, motion=motion)
        scene = rod(supports=(clamp,), loads=(push,), time_step=2e-5, theta=theta, gravity=(0.0, -9.81))
        simulation = Simulation(scene)
        start = simulation.energy
        simulation.advance(800)
        energy = simulation.energy
        assert abs(energy.work) > 0.05
        assert energy.balance - start.balance == pytest.approx(0.0, abs=1e-5 * energy.exchanged)
        held = simulation.solid.boundary.held
        short = Simulation(replace(scene, integrator="explicit", time_step=2e-6))
        short.advance(8000)
        np.testing.assert_allclose(simulation.displacements[held], short.displacements[held], atol=1e-12)
        np.testing.assert_allclose(simulation.velocities[held], short.velocities[held], atol=1e-9)
        assert energy.work == pytest.approx(short.energy.work, rel=0.03)
        difference = simulation.displacements - short.displacements
        assert np.abs(difference).max() < 0.05 * np.abs(short.displacements).max()


def test_damping_is_that_of_the_explicit_rule() -> None:
    body = block(2, (10, 3), velocity=(0.0, 1.0))
    scene = rod(bodies=(body,), supports=(), damping=7.0, time_step=1e-3, theta=0.5)
    simulation = Simulation(scene)
    simulation.advance(100)
    np.testing.assert_allclose(simulation.velocities[:, 1], np.exp(-0.7), rtol=1e-4)
    assert simulation.energy.balance == pytest.approx(0.15e-2 / 0.5 * 0.5 * 1000.0, rel=1e-6)


def test_a_saved_state_comes_back_and_leads_to_the_same_end() -> None:
    """With other forces in between, as a coupling tries them: where the search begins is all that they change."""
    simulation = Simulation(rod(gravity=(0.0, -9.81), time_step=5e-4))
    solid = implicit(simulation)
    simulation.advance(3)
    force = np.zeros(solid.state.u.numpy().shape)
    force[select(simulation.particles, TIP), 1] = 30.0

    def end(value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        solid.restore()
        solid.external.assign(value)
        solid.advance(4 * 5e-4)
        return solid.state.u.numpy().copy(), solid.state.v.numpy().copy()

    solid.save()
    before = {name: values.copy() for name, values in solid.arrays().items()}
    first, pushed, again = end(0.0 * force), end(force), end(0.0 * force)
    for k in range(2):
        np.testing.assert_allclose(first[k], again[k], rtol=0.0, atol=1e-7 * np.abs(first[k]).max())
    assert (pushed[0] - first[0])[force[:, 1] > 0.0, 1].min() > 1e-6
    assert np.abs(pushed[1] - first[1]).max() > 1e-3
    solid.restore()
    after = solid.arrays()
    # what the solver learned is not of the state, and its statistics count all that it did
    kept = {name for name in before if name == "pace" or name.startswith("coarse") or name.endswith("statistics")}
    learned = {name: before[name] for name in kept}
    assert_same_bits([{**after, **learned}], [before])


def test_an_external_force_is_as_good_as_a_load() -> None:
    """In displacements, reactions and work."""
    loaded = Simulation(rod(loads=(Load(name="tip", region=TIP, force=(3.0, -40.0)),), time_step=1e-4))
    pushed = Simulation(rod(time_step=1e-4))
    there = select(pushed.particles, TIP)
    force = np.zeros((pushed.particles.count, 2))
    force[there] = np.array([3.0, -40.0]) / len(there)
    implicit(pushed).external.assign(force)
    for simulation in (loaded, pushed):
        simulation.advance(20)
    np.testing.assert_allclose(pushed.displacements, loaded.displacements, atol=1e-9)
    np.testing.assert_allclose(pushed.reactions, loaded.reactions, atol=1e-5)
    np.testing.assert_allclose(pushed.internal_forces, loaded.internal_forces, atol=1e-5)
    assert pushed.energy.work == pytest.approx(loaded.energy.work, rel=1e-6)


def test_a_restored_run_goes_on_to_the_same_bits() -> None:
    motion = HarmonicMotion(amplitude=(0.001, 0.002), frequency=40.0)
    supports = (Support(name="clamp", region=EDGE, motion=motion),)
    push = Load(name="push", region=TIP, force=(20.0, -50.0), frequency=30.0)
    scene = rod(gravity=(0.0, -9.81), time_step=5e-4, supports=supports, loads=(push,), damping=2.0)
    assert_restored_goes_on(scene, 5, 3)


def test_a_step_that_cannot_be_solved_leaves_the_state() -> None:
    """As one with a force that is no number."""
    simulation = Simulation(rod(time_step=1e-3))
    simulation.advance(1)
    solid = implicit(simulation)
    before = solid.arrays()
    force = np.zeros(solid.state.u.numpy().shape)
    force[:, 0] = np.nan
    solid.external.assign(force)
    with pytest.raises(RunError, match=r"the step from 0.001 to 0.002 s was not solved"):
        solid.advance(0.002)
    solid.external.zero_()
    for name in ("u", "v"):
        assert (solid.arrays()[name] == before[name]).all()


def test_a_body_that_floats_is_solved_far_from_where_it_began() -> None:
    """Its weight and what carries it do far more work in a step than what changes: they round the potential."""
    foam = Material(density=600.0, youngs_modulus=2e6, poissons_ratio=0.3)
    body = Body(name="plate", shape=Box((0.2, 0.02)), material=foam, spacing=0.005, velocity=(0.0, -1.0))
    lift = Load(name="lift", region=Box((0.2, 0.005), center=(0.0, -0.0075)), force=(0.0, 600.0 * 0.2 * 0.02 * 9.81))
    dt = 6.667e-4
    fields: dict[str, Any] = {"integrator": "implicit", "time_step": dt, "contact": Contact(between="none")}
    scene = Scene(bodies=(body,), loads=(lift,), gravity=(0.0, -9.81), duration=1.0, **fields)
    numbers, device = numeric_types(2, "float64"), open_device("cpu")
    load_modules(declare_kernels(numbers) + declare_implicit(numbers), device, print)
    solid = ImplicitSolid(scene, fill_scene(scene), dt=dt, types=numbers, device=device)
    solid.start()
    for step in range(1, 21):
        solid.advance(step * dt, tolerance=1e-9)
    assert solid.velocities()[:, 1].mean() == pytest.approx(-1.0, abs=1e-9)
    assert solid.newton.statistics.most_iterations <= 4

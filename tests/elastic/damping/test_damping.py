"""Kelvin-Voigt damping: its forces, what it leaves alone, how fast modes die out, and what becomes of the energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from tests.bits import assert_same_bits, states
from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.elastic.hamiltonian.test_kernels import PLANES, irregular, strained_state
from tests.elastic.states import rigid_displacement, strain
from tests.run.test_simulation import everything
from tests.scenes import HAMILTONIAN, RUBBER, angular_momentum, beam, block, cross, random, scene_of
from warp_mps.core.device import open_device
from warp_mps.core.types import numeric_types
from warp_mps.elastic.damping.model import Viscosity, make_viscosity
from warp_mps.elastic.explicit.time_step import stable_time_step
from warp_mps.particles.filling import fill_scene
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import LAWS, HarmonicMotion, Scene, Support
from warp_mps.shapes import Box

TAU = 1e-3


def viscous(scene: Scene, tau: float = TAU) -> Scene:
    """The same scene with damping in every material."""
    bodies = tuple(replace(body, material=replace(body.material, retardation_time=tau)) for body in scene.bodies)
    return replace(scene, bodies=bodies)


class Damped:
    """A model with viscosity, whose particles are placed and moved by the test."""

    def __init__(self, scene: Scene, precision: str = "float64") -> None:
        self.held = strain(viscous(scene), precision)
        self.particles, numbers = self.held.particles, numeric_types(scene.dimension, precision)
        made = make_viscosity(viscous(scene), self.particles, self.held.model, types=numbers, device=open_device("cpu"))
        assert isinstance(made, Viscosity)
        self.viscosity = made

    def force(self, displacements: np.ndarray, velocities: np.ndarray, dt: float = 0.0) -> np.ndarray:
        """Viscous forces [N], shape [n, d], at displacements that were reached with these velocities."""
        held, n = self.held.put(displacements), self.particles.count
        held.state.v.assign(velocities)
        for _, launch in self.viscosity.passes(dt):
            launch(held.state, 0, n)
        return self.viscosity.force.numpy().astype(float)


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_at_rest_the_force_is_that_of_the_rate_of_displacement(dimension: int, plane: str, law: str, nu: float) -> None:
    """It is tau times the elastic force that the velocities make in a unit of time, with all that controls modes."""
    damped = Damped(irregular(dimension, plane=plane, law=law, nu=nu))
    velocities = random(damped.particles.count, dimension, seed=2)
    found = damped.force(np.zeros_like(velocities), velocities)
    elastic = damped.held.put(1e-9 * velocities).forces
    np.testing.assert_allclose(found, TAU * elastic / 1e-9, atol=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_momenta_are_kept_and_energy_only_lost(dimension: int, plane: str, nu: float) -> None:
    damped = Damped(irregular(dimension, plane=plane, nu=nu))
    displacements = strained_state(damped.held)
    for seed in range(5):
        velocities = random(*displacements.shape, seed=seed)
        force = damped.force(displacements, velocities)
        moments = cross(damped.particles.positions + displacements, force)
        np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-13 * np.abs(force).sum())
        np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-13 * np.abs(moments).sum())
        assert np.sum(force * velocities) < 0.0


@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-11), ("float32", 1e-3)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_step_of_a_rigid_rotation_gives_no_force(dimension: int, precision: str, rounding: float) -> None:
    """However far a step turns the body: its velocities are then those of the chords."""
    damped = Damped(irregular(dimension), precision)
    scale = np.abs(damped.force(0.0 * damped.particles.positions, random(*damped.particles.positions.shape))).max()
    axis = np.ones(1) if dimension == 2 else np.array([2.0, -1.0, 2.0]) / 3.0
    for before, after in ((0.0, 0.01), (1.0, 1.5), (2.0, 5.0)):
        ends = [rigid_displacement(damped.particles, angle * axis, 0.05) for angle in (before, after)]
        force = damped.force(ends[1], (ends[1] - ends[0]) / 0.1, 0.1)
        np.testing.assert_allclose(force, 0.0, atol=rounding * scale)
    shifted = damped.force(ends[1], np.ones_like(ends[1]))
    np.testing.assert_allclose(shifted, 0.0, atol=rounding * scale)


@pytest.mark.parametrize(("ratio", "mode"), [(0.03, 0), (0.1, 2)])
def test_damping_ratio_of_a_free_beam(ratio: float, mode: int) -> None:
    """It is tau omega / 2: of the first bending and the first axial mode, from the decay of their amplitudes."""
    # the lag of the rates is of first order in the step: a small one
    scene = beam(4, elasticity=HAMILTONIAN, courant=0.1)
    particles = fill_scene(scene)
    found, shapes = linear_hamiltonian(scene, particles).modes(3, rigid=3)
    omega, shape = found[mode], shapes[mode].reshape(-1, 2)
    simulation = Simulation(viscous(scene, 2.0 * ratio / omega))
    arrays = simulation.state_arrays()
    arrays["v"] = 1e-4 * shape
    simulation.restore(arrays)
    times, amplitudes = [], []
    while simulation.time < 4.2 * 2 * np.pi / omega:
        simulation.advance(8)
        times.append(simulation.time)
        amplitudes.append(np.sum(particles.masses[:, None] * shape * simulation.displacements))
    time, amplitude = np.array(times), np.array(amplitudes)
    assert amplitude == pytest.approx(decaying(time, 1e-4, omega, ratio), abs=2e-3 * amplitude.max())
    fitted, _ = curve_fit(lambda t, w, z: decaying(t, 1e-4, w, z), time, amplitude, (omega, ratio))
    print(f"mode {mode}: ratio {fitted[1]:.5f}, expected {ratio} ({100 * (fitted[1] / ratio - 1):+.2f} %)")
    assert fitted == pytest.approx((omega, ratio), rel=5e-3)


def decaying(time: np.ndarray, speed: float, omega: float, ratio: float) -> np.ndarray:
    """Displacement of a damped oscillator that starts with a speed."""
    damped = omega * np.sqrt(1.0 - ratio**2)
    return speed / damped * np.exp(-ratio * omega * time) * np.sin(damped * time)


@pytest.mark.parametrize(("dimension", "precision"), [(2, "float64"), (2, "float32"), (3, "float64")])
def test_the_energy_that_is_lost_is_accounted_for(dimension: int, precision: str) -> None:
    """Also the work of a moving support; the error falls with the square of the step."""
    size = [0.06, 0.03, 0.03][:dimension]
    body = block(dimension, shape=Box(size), velocity=[0.0, 1.0, 0.5][:dimension])
    wall = Box([0.031] + [1.0] * (dimension - 1), [-0.03] + [0.0] * (dimension - 1))
    shake = HarmonicMotion(amplitude=[0.0, 1e-4, 0.0][:dimension], frequency=300.0)
    held = Support(name="wall", region=wall, motion=shake)
    scene = viscous(scene_of(body, dimension=dimension, elasticity=HAMILTONIAN, supports=(held,)), 3e-4)
    worst = []
    for share in (0.8, 0.4):
        simulation = Simulation(replace(scene, time_step=share * Clock(scene).dt_limit), precision=precision)
        first, off = simulation.energy, []
        while simulation.time < 6e-3:
            simulation.advance(32)
            off.append(abs(simulation.energy.balance - first.balance) / first.kinetic)
        worst.append(max(off))
        assert simulation.energy.dissipated > first.kinetic
    print(f"{dimension}-D {precision}: off by {worst[0]:.1e} and {worst[1]:.1e} of the energy at the start")
    assert worst[0] < 1e-3
    assert worst[1] < 0.3 * worst[0]


def test_a_spinning_body_keeps_spinning() -> None:
    """Stretched by its rotation to begin with, it is damped to a rigid rotation and then loses nothing."""
    body = block(2, cells=(4, 4), angular_velocity=40.0)
    simulation = Simulation(viscous(scene_of(body, elasticity=HAMILTONIAN), 3e-4))
    spin = angular_momentum(simulation)
    simulation.advance(3000)
    settled = simulation.energy
    simulation.advance(3000)
    assert angular_momentum(simulation) == pytest.approx(spin, rel=1e-9)
    assert simulation.energy.dissipated - settled.dissipated < 1e-9 * settled.kinetic
    assert simulation.energy.kinetic == pytest.approx(settled.kinetic, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_same_bits_however_it_is_run(dimension: int) -> None:
    """Graphs, kernels and threads; and a continued run."""
    scene = viscous(replace(everything(dimension), elasticity=HAMILTONIAN), 1e-4)
    runs = [Simulation(scene), Simulation(scene, graphs=False), Simulation(scene, threads=2)]
    found = [states(run, 1, 70, 20) for run in runs]
    assert "viscous" in found[0][0]
    assert_same_bits(found[0], found[1])
    assert_same_bits(found[0], found[2])
    resumed = Simulation(scene)
    resumed.restore(found[0][1])
    assert_same_bits(states(resumed, 20), found[0][2:])


def test_without_it_nothing_is_done() -> None:
    simulation = Simulation(scene_of(block(2), elasticity=HAMILTONIAN))
    assert simulation.solid.parts.viscosity is None
    assert [phase.name for phase in simulation.solid.phases] == ["drift", "stress", "force", "kick"]
    assert "viscous" not in simulation.state_arrays()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("share", [0.1, 1.0, 10.0])
def test_the_limit_of_the_step_is_stable(dimension: int, share: float) -> None:
    """Whether the fastest mode is damped weakly or far beyond its critical damping, noise does not grow."""
    plain = scene_of(block(dimension), dimension=dimension, elasticity=HAMILTONIAN)
    tau = share * stable_time_step(plain.bodies[0], plain)
    scene = viscous(plain, tau)
    limit = stable_time_step(scene.bodies[0], scene)
    assert limit < stable_time_step(plain.bodies[0], plain)
    simulation = Simulation(replace(scene, time_step=limit))
    arrays = simulation.state_arrays()
    arrays["v"] = 1e-3 * random(*arrays["v"].shape)
    simulation.restore(arrays)
    before = simulation.energy
    simulation.advance(1000)
    assert simulation.energy.total < before.total


def test_the_step_is_shortened_by_it() -> None:
    plain = scene_of(block(2), elasticity=HAMILTONIAN, frame_rate=1.0)
    limit = stable_time_step(plain.bodies[0], plain)
    share = np.sqrt(1.0 + 0.5**2) - 0.5
    damped = viscous(plain, 0.5 * limit)
    assert stable_time_step(damped.bodies[0], damped) == pytest.approx(share * limit)
    damped = viscous(plain, 10.0 * limit)
    assert 0.5 * Clock(damped).dt_limit < Clock(damped).dt < Clock(damped).dt_limit < 0.06 * limit
    assert RUBBER.retardation_time == 0.0

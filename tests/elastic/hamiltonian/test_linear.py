"""The Hamiltonian model against its linearised form: small forces, and the eigenfrequencies that runs show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.elastic.springs.linear import LinearSystem
from tests.elastic.states import strain
from tests.scenes import HAMILTONIAN, LENGTH, RUBBER, STEEL, bar, beam, block, ends, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.run.simulation import Simulation
from warp_mps.scene import LAWS, Elasticity, Scene, Support
from warp_mps.shapes import Box

ALUMINIUM = replace(RUBBER, density=2700.0, youngs_modulus=67.5e9, poissons_ratio=0.34)


@pytest.mark.parametrize("control", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("radius", [1.5, 2.1])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), [(2, "stress"), (2, "strain"), (3, "strain")])
def test_small_forces_are_the_matrix_times_the_motion(
    dimension: int, plane: str, law: str, radius: float, control: float
) -> None:
    """Two bonded bodies of different materials."""
    rest = [0.0] * (dimension - 1)
    size = [0.03, 0.04, 0.02][:dimension]
    soft, hard = replace(RUBBER, law=law), replace(STEEL, law=law)
    left = block(dimension, name="left", shape=Box(size, [-0.015, *rest]), material=soft, bonded_to=("right",))
    right = block(dimension, name="right", shape=Box(size, [0.015, *rest]), material=hard)
    elasticity = Elasticity(effective_radius=radius, control=control)
    scene = scene_of(left, right, dimension=dimension, plane=plane, elasticity=elasticity)
    held = strain(scene)
    motion = 1e-10 * random(held.particles.count, dimension)
    stiffness = linear_hamiltonian(scene, held.particles).stiffness
    expected = -(stiffness @ motion.ravel()).reshape(motion.shape)
    held.put(motion)
    # the second order is that of the strains, 1e-8
    np.testing.assert_allclose(held.forces, expected, atol=1e-6 * np.abs(expected).max())
    assert held.energy == pytest.approx(0.5 * motion.ravel() @ (stiffness @ motion.ravel()), rel=1e-6)


@pytest.mark.parametrize("mode", [0, 1])
def test_supported_beam_on_rollers(mode: int) -> None:
    rollers = tuple(
        Support(name=name, region=region, axes=(1,)) for name, region in zip(("left", "right"), ends(), strict=True)
    )
    scene = beam(4, nodes=True, supports=rollers, elasticity=HAMILTONIAN)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 2), bool)
    held[np.isin(particles.positions[:, 0].round(9), (0.0, LENGTH)), 1] = True
    assert held.sum() == 8
    check_mode(scene, particles, linear_hamiltonian(scene, particles, held), mode=mode, rigid=1)


def test_clamped_beam() -> None:
    scene = beam(4, supports=(Support(name="clamp", region=ends(0.01)[0]),), elasticity=HAMILTONIAN)
    particles = fill_scene(scene)
    held = np.repeat(particles.positions[:, :1] < 0.01, 2, axis=1)
    assert held.sum() == 2 * 4 * 2
    check_mode(scene, particles, linear_hamiltonian(scene, particles, held, face=0.01))


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_free_beam(plane: str, law: str, precision: str) -> None:
    scene = beam(4, plane=plane, elasticity=Elasticity(effective_radius=2.1))
    scene = replace(scene, bodies=(replace(scene.bodies[0], material=replace(RUBBER, law=law)),))
    particles = fill_scene(scene)
    check_mode(scene, particles, linear_hamiltonian(scene, particles), rigid=3, precision=precision)


@pytest.mark.parametrize("law", LAWS)
def test_free_bar_in_space(law: str) -> None:
    scene = bar(2, elasticity=HAMILTONIAN)
    scene = replace(scene, bodies=(replace(scene.bodies[0], material=replace(scene.bodies[0].material, law=law)),))
    particles = fill_scene(scene)
    check_mode(scene, particles, linear_hamiltonian(scene, particles), rigid=6)


def check_mode(
    scene: Scene,
    particles: Particles,
    system: LinearSystem,
    *,
    mode: int = 0,
    rigid: int = 0,
    precision: str = "float64",
) -> None:
    """Start a run with the velocities of a mode, and see that it swings in that mode at its frequency."""
    omegas, shapes = system.modes(mode + 1, rigid=rigid)
    shape = shapes[mode].reshape(particles.count, -1)
    # amplitudes so small that the model is linear to 1e-8, in single precision to 1e-3
    strength = {"float64": 1e-6, "float32": 1e-3}[precision] * particles.spacings[0] / np.abs(shape).max()
    simulation = Simulation(scene, precision=precision)
    start = strength * omegas[mode] * shape
    simulation.solid.state.v.assign(start.astype(simulation.solid.state.v.numpy().dtype))
    every = round(1.25 * 2 * np.pi / omegas[mode] / simulation.dt / 40)
    times, swing = np.zeros(40), np.zeros(40)
    for k in range(40):
        simulation.advance(every)
        times[k], swing[k] = simulation.time, simulation.displacements.ravel() @ (system.masses * shape.ravel())
    swing /= strength
    (found, size), _ = curve_fit(lambda t, w, a: a * np.sin(w * t), times, swing, p0=[omegas[mode], 1.0])
    # what velocity Verlet makes of a frequency
    expected = 2.0 / simulation.dt * np.arcsin(0.5 * omegas[mode] * simulation.dt)
    tolerance = {"float64": 1e-6, "float32": 1e-3}[precision]
    assert found == pytest.approx(expected, rel=tolerance)
    assert found == pytest.approx(omegas[mode], rel=3e-3)
    # the start of the swing is the whole motion, and it stays in the mode
    assert size == pytest.approx(1.0, abs=100 * tolerance)
    np.testing.assert_allclose(swing, size * np.sin(found * times), atol=10 * tolerance)


def test_aluminium_at_a_strain_of_1e_5() -> None:
    """A stiff bar in its first axial mode for two periods, against A sin(omega t): x - X, not x, is what is integrated.

    The strain of particles of 5 mm, 1e-5, is 5e-8 m.
    """
    scene = beam(4, elasticity=HAMILTONIAN)
    scene = replace(scene, bodies=(replace(scene.bodies[0], material=ALUMINIUM),))
    particles = fill_scene(scene)
    omegas, shapes = linear_hamiltonian(scene, particles).modes(3, rigid=3)
    shape = shapes[2].reshape(-1, 2) / np.abs(shapes[2]).max()
    assert np.abs(shape[:, 0]).max() == 1.0
    # u = A cos(pi x / L) has a strain of A pi / L
    amplitude = 1e-5 * LENGTH / np.pi
    double, single = runs = [Simulation(scene, precision=precision) for precision in ("float64", "float32")]
    for simulation in runs:
        start = amplitude * omegas[2] * shape
        simulation.solid.state.v.assign(start.astype(simulation.solid.state.v.numpy().dtype))
    # velocity Verlet's swing: its frequency, and its amplitude
    half_turn = np.arcsin(0.5 * omegas[2] * double.dt)
    errors, differences = [], []
    while double.time < 4 * np.pi / omegas[2]:
        for simulation in runs:
            simulation.advance(10)
        exact = amplitude / np.cos(half_turn) * np.sin(2.0 * half_turn * double.step) * shape
        errors.append(np.abs(double.displacements - exact).max() / amplitude)
        differences.append(np.abs(single.displacements - double.displacements).max() / amplitude)
    print(
        f"largest error {max(errors):.1e} of the amplitude, of single precision {max(differences):.1e}, {double.step}"
    )
    # the second order of the strains, which adds up over the time
    assert max(errors) < 5e-5
    assert max(differences) < 1e-4

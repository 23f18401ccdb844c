"""The kernels against the linearised model: small loads, and the eigenfrequencies that runs show."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit

from tests.core.rotors import rotors_of
from tests.elastic.springs.linear import LinearSystem, linear_system
from tests.elastic.states import hold
from tests.scenes import LENGTH, STEEL, bar, beam, block, corners, ends, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Elasticity, Scene, Support
from warp_mps.shapes import Box


@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize("radius", [1.5, 2.1])
@pytest.mark.parametrize(("dimension", "plane"), [(2, "stress"), (2, "strain"), (3, "strain")])
def test_small_loads_are_the_matrix_times_the_motion(
    dimension: int, plane: str, radius: float, normalization: str
) -> None:
    """Two bonded bodies of different materials."""
    rest = [0.0] * (dimension - 1)
    size = [0.03, 0.04, 0.02][:dimension]
    left = block(dimension, name="left", shape=Box(size, [-0.015, *rest]), bonded_to=("right",))
    right = block(dimension, name="right", shape=Box(size, [0.015, *rest]), material=STEEL)
    elasticity = Elasticity(model="springs", effective_radius=radius, normalization=normalization)
    scene = scene_of(left, right, dimension=dimension, plane=plane, elasticity=elasticity)
    held = hold(scene)
    spins = 2 * dimension - 3
    motion = 1e-8 * random(held.particles.count, dimension + spins)
    motion[:, :dimension] *= 0.01
    loads = np.hstack(held.put(motion[:, :dimension], rotors_of(motion[:, dimension:])).loads())
    expected = -(linear_system(scene, held.particles).stiffness @ motion.ravel()).reshape(loads.shape)
    # the second order is 1e-8; in u_ij, x - X keeps 1e-16 of 1e-2 spacings where motion is 1e-8 of them
    for columns in (slice(0, dimension), slice(dimension, None)):
        scale = np.abs(expected[:, columns]).max()
        np.testing.assert_allclose(loads[:, columns], expected[:, columns], atol=1e-6 * scale)


@pytest.mark.parametrize("mode", [0, 1])
def test_supported_beam_on_rollers(mode: int) -> None:
    rollers = tuple(
        Support(name=name, region=region, axes=(1,)) for name, region in zip(("left", "right"), ends(), strict=True)
    )
    scene = beam(4, nodes=True, supports=rollers)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 3), bool)
    held[np.isin(particles.positions[:, 0].round(9), (0.0, LENGTH)), 1] = True
    assert held.sum() == 8
    check_mode(scene, particles, linear_system(scene, particles, held), mode=mode, rigid=1)


@pytest.mark.parametrize("mode", [0, 1])
def test_supported_beam_pinned_at_two_corners(mode: int) -> None:
    pins = tuple(
        Support(name=name, region=region, hold_rotation=False)
        for name, region in zip(("left", "right"), corners(4), strict=True)
    )
    scene = beam(4, supports=pins)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 3), bool)
    x, y = particles.positions.T
    held[(y == y.min()) & ((x == x.min()) | (x == x.max())), :2] = True
    assert held.sum() == 4
    check_mode(scene, particles, linear_system(scene, particles, held), mode=mode)


def test_clamped_beam() -> None:
    scene = beam(4, supports=(Support(name="clamp", region=ends(0.01)[0]),))
    particles = fill_scene(scene)
    held = np.repeat(particles.positions[:, :1] < 0.01, 3, axis=1)
    assert held.sum() == 2 * 4 * 3
    check_mode(scene, particles, linear_system(scene, particles, held, face=0.01))


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_free_beam(plane: str, normalization: str, precision: str) -> None:
    scene = beam(
        4, plane=plane, elasticity=Elasticity(model="springs", effective_radius=2.1, normalization=normalization)
    )
    particles = fill_scene(scene)
    check_mode(scene, particles, linear_system(scene, particles), rigid=3, precision=precision)


def test_free_bar_in_space() -> None:
    scene = bar(2)
    particles = fill_scene(scene)
    # bending along z and along y; the two are degenerate, and any mix of them is a mode
    check_mode(scene, particles, linear_system(scene, particles), rigid=6)


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
    d = particles.dimension
    # amplitudes so small that the model is linear to 1e-8, in single precision to 1e-3
    strength = {"float64": 1e-6, "float32": 1e-3}[precision] * particles.spacings[0] / np.abs(shape[:, :d]).max()
    simulation = Simulation(scene, precision=precision)
    simulation.solid.state.v.assign(strength * omegas[mode] * shape[:, :d])
    simulation.solid.model.rotation.omega.assign(strength * omegas[mode] * shape[:, d:])
    every = round(1.25 * 2 * np.pi / omegas[mode] / simulation.dt / 40)
    times, swing = np.zeros(40), np.zeros(40)
    for k in range(40):
        simulation.advance(every)
        motion = np.hstack((simulation.displacements, simulation.rotations)).ravel()
        times[k], swing[k] = simulation.time, motion @ (system.masses * shape.ravel()) / strength
    (found, size), _ = curve_fit(lambda t, w, a: a * np.sin(w * t), times, swing, p0=[omegas[mode], 1.0])
    # what velocity Verlet makes of a frequency
    expected = 2.0 / simulation.dt * np.arcsin(0.5 * omegas[mode] * simulation.dt)
    tolerance = {"float64": 1e-6, "float32": 1e-3}[precision]
    assert found == pytest.approx(expected, rel=tolerance)
    assert found == pytest.approx(omegas[mode], rel=3e-3)
    # the start of the swing is the whole motion, and it stays in the mode
    assert size == pytest.approx(1.0, abs=100 * tolerance)
    np.testing.assert_allclose(swing, size * np.sin(found * times), atol=10 * tolerance)

"""Clamps act at their drawn faces, wherever these lie between the particles."""

from __future__ import annotations

import numpy as np
import pytest

from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.elastic.states import strain
from tests.scenes import HAMILTONIAN, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.selection import select_held
from warp_mps.scene import Body, Material, Scene, Support
from warp_mps.shapes import Box

# rad/s: a beam of 4 by 1 m, E 1 Pa, nu 0.3, 1 kg/m^3, plane strain, by 16 x 64 quadratic finite elements
FREQUENCY = 0.0636067


def cantilever(rows: int, offset: float, *, dimension: int = 2, length: float = 4.0, nu: float = 0.3) -> Scene:
    """A beam 1 m high whose last held column stands so many spacings behind the face x = 0 of its clamp."""
    spacing = 1.0 / rows
    left, columns = -(offset + 2.5) * spacing, round(length * rows + offset - 0.5) + 3
    shape = Box((columns * spacing, 1.0, 0.5)[:dimension], (left + 0.5 * columns * spacing, 0.0, 0.0)[:dimension])
    clamp = Support(name="clamp", region=Box((4.0, 3.0, 3.0)[:dimension], (-2.0, 0.0, 0.0)[:dimension]))
    body = Body(name="beam", shape=shape, material=Material(1.0, 1.0, nu), spacing=spacing)
    return scene_of(body, dimension=dimension, plane="strain", supports=(clamp,), elasticity=HAMILTONIAN)


@pytest.mark.parametrize("offset", [0.5, 0.3, 0.0, -0.3, 0.6])
def test_frequency_of_a_beam_of_eight_rows(offset: float) -> None:
    """Within 0.5 %; a clamp at the last held column makes it 3.8 % low at an offset of 1/2."""
    scene = cantilever(8, offset)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 2), bool)
    held[select_held(particles, scene.supports[0])] = True
    (omega,), _ = linear_hamiltonian(scene, particles, held, face=0.0).modes(1)
    length = particles.positions[:, 0].max() + 1.0 / 16.0
    assert omega * (length / 4.0) ** 2 == pytest.approx(FREQUENCY, rel=0.005)


@pytest.mark.parametrize("offset", [0.5, 0.3, 0.0, -0.3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_uniform_strain_up_to_the_face_gives_no_force(dimension: int, offset: float) -> None:
    scene = cantilever(4, offset, dimension=dimension, length=2.0, nu=0.0)
    held = strain(scene)
    x = held.particles.positions[:, 0]
    fixed = np.zeros(len(x), bool)
    fixed[select_held(held.particles, scene.supports[0])] = True
    stretch = np.zeros_like(held.particles.positions)
    stretch[~fixed, 0] = 1e-7 * x[~fixed]
    held.put(stretch)
    inner = ~fixed & (x < 1.2)
    # the rows at free surfaces have other shape tensors than their neighbours: 0.4 % of a particle's share of the force
    assert np.abs(held.forces[inner]).max() < 4e-3 * 1e-7 * 0.25 ** (dimension - 1)
    # the clamp takes what the free end gives
    np.testing.assert_allclose(held.forces.sum(axis=0), 0.0, atol=1e-9 * np.abs(held.forces).max())
    axial = 1e-7 * (1.0 if dimension == 2 else 0.5)
    assert held.forces[fixed, 0].sum() == pytest.approx(axial, rel=1e-3)


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_at_a_face_are_the_gradient_of_the_energy(dimension: int, nu: float) -> None:
    held = strain(cantilever(4, 0.3, dimension=dimension, length=1.0, nu=nu))
    n = held.particles.count
    state, way = 0.02 * random(n, dimension), 1e-6 * random(n, dimension, seed=1)
    gain = held.put(state + way).energy - held.put(state - way).energy
    assert gain == pytest.approx(-2.0 * np.sum(held.put(state).forces * way), rel=1e-5)

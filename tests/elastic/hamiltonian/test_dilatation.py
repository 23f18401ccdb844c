"""The mean dilatation of nearly incompressible materials: its forces, its stresses, and bending without locking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from tests.elastic.hamiltonian.linear import balanced, linear_hamiltonian
from tests.elastic.hamiltonian.test_kernels import PLANES, irregular, strained_state
from tests.elastic.springs.linear import pairs_of
from tests.elastic.states import Strained, strain
from tests.scenes import HAMILTONIAN, RUBBER, block, cross, random, scene_of
from warp_mps.elastic.materials.constants import law_constants, mean_lame
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import LAWS, Body, Elasticity, Material, Scene
from warp_mps.shapes import Box

NU = 0.49
SPACES = [(2, "strain"), (3, "strain")]

every_law = pytest.mark.parametrize("law", LAWS)
every_space = pytest.mark.parametrize(("dimension", "plane"), SPACES)


def differences(held: Strained, displacements: np.ndarray, step: float = 1e-7) -> np.ndarray:
    """Minus the gradient of the energy by central differences [N], shape [n, d]."""
    expected = np.zeros_like(displacements)
    for place in np.ndindex(expected.shape):
        change = np.zeros_like(displacements)
        change[place] = step
        ends = [held.put(displacements + sign * change).energy for sign in (1.0, -1.0)]
        expected[place] = (ends[1] - ends[0]) / (2 * step)
    return expected


@pytest.mark.parametrize(("nu", "share"), [(0.3, 0.0), (0.4, 0.0), (0.45, 5.0 / 9.0), (0.49, 45.0 / 49.0)])
def test_lambda_beyond_four_mu_acts_on_the_mean(nu: float, share: float) -> None:
    """The ratio lambda / mu is 2 nu / (1 - 2 nu); in plane stress nothing keeps the volume."""
    material = Material(1000.0, 1e7, nu)
    lame, _ = law_constants(material, 3, "strain")
    assert mean_lame(material, 3, "strain") / lame == pytest.approx(share, abs=1e-12)
    assert mean_lame(material, 2, "stress") == 0.0
    assert (mean_lame(material, 2, "strain") == 0.0) == (nu <= 0.4)


@every_law
@every_space
def test_forces_are_minus_the_gradient_of_the_energy(dimension: int, plane: str, law: str) -> None:
    held = strain(irregular(dimension, plane=plane, law=law, nu=NU))
    displacements = strained_state(held)
    expected = differences(held, displacements)
    forces = held.put(displacements).forces
    np.testing.assert_allclose(forces, expected, atol=1e-6 * np.abs(expected).max())
    moments = cross(held.particles.positions + displacements, forces)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * np.abs(forces).sum())
    np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-13 * np.abs(moments).sum())


@every_law
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_small_forces_are_the_matrix_times_the_motion(dimension: int, plane: str, law: str) -> None:
    scene = irregular(dimension, plane=plane, law=law, nu=NU)
    held = strain(scene)
    motion = 1e-10 * random(held.particles.count, dimension)
    expected = -(linear_hamiltonian(scene, held.particles).stiffness @ motion.ravel()).reshape(motion.shape)
    np.testing.assert_allclose(held.put(motion).forces, expected, atol=1e-6 * np.abs(expected).max())


@every_law
@every_space
def test_a_uniform_deformation_has_the_energy_and_stress_of_the_law(dimension: int, plane: str, law: str) -> None:
    """Inside and at the surface alike; the formulas are those of the laws, in NumPy."""
    material = replace(RUBBER, law=law, poissons_ratio=NU)
    held = strain(scene_of(block(dimension, material=material), dimension=dimension, elasticity=HAMILTONIAN))
    f = np.eye(dimension) + 0.1 * random(dimension, dimension, seed=6)
    held.put(held.particles.positions @ (f - np.eye(dimension)).T)
    lame, mu = law_constants(material, dimension, plane)
    j, one = np.linalg.det(f), np.eye(dimension)
    if law == "st_venant_kirchhoff":
        e = 0.5 * (f.T @ f - one)
        kirchhoff = f @ (2 * mu * e + lame * np.trace(e) * one) @ f.T
        density = mu * np.sum(e * e) + 0.5 * lame * np.trace(e) ** 2
        across = lame * np.trace(e)
    else:
        kirchhoff = mu * (f @ f.T - one) + lame * np.log(j) * one
        density = 0.5 * mu * (np.sum(f * f) - dimension - 2 * np.log(j)) + 0.5 * lame * np.log(j) ** 2
        across = lame * np.log(j)
    stresses = held.model.stress_fields(held.state).stresses
    np.testing.assert_allclose(stresses[:, :dimension, :dimension], [kirchhoff / j] * len(stresses), rtol=1e-10)
    if dimension == 2:
        np.testing.assert_allclose(stresses[:, 2, 2], across / j, rtol=1e-10)
    np.testing.assert_allclose(held.model.pressures(), -np.trace(kirchhoff) / j / dimension, rtol=1e-10)
    np.testing.assert_allclose(held.model.energy_densities(held.state), density, rtol=1e-10)
    volume = held.particles.count * 0.01**dimension
    assert held.energy == pytest.approx(volume * density, rel=1e-10)


@every_law
def test_single_precision_gives_the_same_forces(law: str) -> None:
    scene = irregular(3, law=law, nu=NU)
    double, single = strain(scene), strain(scene, "float32")
    forces = [held.put(strained_state(held) - 0.1).forces for held in (double, single)]
    np.testing.assert_allclose(forces[1], forces[0], atol=2e-5 * np.abs(forces[0]).max())


def test_means_are_of_neighbours_of_the_same_material() -> None:
    """A stiff neighbour that keeps its volume does not dilute the mean."""
    scene = irregular(2, nu=NU)
    held = strain(scene)
    held.put(strained_state(held))
    own, mean = held.model.dilatation.dilatation.numpy(), held.model.dilatation.mean.numpy()
    left = held.particles.bodies == 0
    i, j, _, w = pairs_of(scene, held.particles)
    same = left[i] & left[j]
    weights = sp.csr_matrix((w[same], (i[same], j[same])), (len(own), len(own)))
    np.testing.assert_allclose(mean[left], (balanced(weights) @ own)[left], rtol=1e-12)
    assert (mean[~left] == 0.0).all()
    assert np.ptp(mean[left]) < 0.8 * np.ptp(own[left])


def deflection(rows: int, nu: float, *, aspect: int = 20, control: float = 0.5) -> float:
    """Deflection of a clamped plate under a load at its end in plane strain, over that of a beam with shear [-]."""
    height, youngs = 0.02, 1e7
    spacing = height / rows
    material = Material(1000.0, youngs, nu)
    shape = Box((aspect * height, height), (0.5 * aspect * height, 0.0))
    body = Body(name="plate", shape=shape, material=material, spacing=spacing, node_axes=(0,))
    scene: Scene = scene_of(body, elasticity=Elasticity(control=control), plane="strain")
    particles = fill_scene(scene)
    stiffness = linear_hamiltonian(scene, particles).stiffness
    x = particles.positions[:, 0]
    free = np.repeat(x > 1e-9, 2)
    tip = np.isclose(x, x.max())
    force = np.zeros(stiffness.shape[0])
    force[1::2][tip] = 1.0 / rows
    found = sla.spsolve(stiffness[free][:, free].tocsc(), force[free])
    u = np.zeros(len(force))
    u[free] = found
    length, mu, bending = aspect * height, 0.5 * youngs / (1 + nu), youngs / (1 - nu**2) * height**3 / 12
    return float(u[1::2][tip].mean() / (length**3 / (3 * bending) + 1.2 * length / (mu * height)))


# 0.99 is what a fine plate has: its clamp is stiffer than that of a beam
@pytest.mark.parametrize("nu", [0.3, 0.42, 0.45, 0.47, 0.49, 0.499])
@pytest.mark.parametrize("rows", [3, 4, 5, 6])
def test_a_thin_plate_does_not_lock(rows: int, nu: float) -> None:
    assert deflection(rows, nu) == pytest.approx(0.994, rel=0.03)

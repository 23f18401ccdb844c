"""Stresses, strains and energy densities of the particles: uniform deformations by hand, and under rotation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.bits import assert_same_bits
from tests.core.rotors import rotors_of
from tests.elastic.hamiltonian.test_kernels import irregular, rotation, strained_state
from tests.elastic.states import hold, random_state, strain
from tests.scenes import HAMILTONIAN, RUBBER, beam, block, random, scene_of
from warp_mps.elastic.materials.constants import lame_constants
from warp_mps.elastic.output.stresses import StressFields, von_mises
from warp_mps.run.simulation import Simulation
from warp_mps.scene import LAWS, Elasticity, Material

PLANES = [(2, "strain"), (2, "stress"), (3, "strain")]
MU, LAME = 1e7 / 2.6, 0.3e7 / (1.3 * 0.4)


def shear(dimension: int) -> np.ndarray:
    """Simple shear by 0.2."""
    return np.eye(dimension) + 0.2 * np.outer(np.eye(dimension)[0], np.eye(dimension)[1])


def stretch(dimension: int) -> np.ndarray:
    """Stretch by 1.1 along x and nothing across it."""
    return np.eye(dimension) + 0.1 * np.outer(np.eye(dimension)[0], np.eye(dimension)[0])


def anything(dimension: int) -> np.ndarray:
    """Any deformation."""
    return np.eye(dimension) + 0.1 * random(dimension, dimension, seed=6)


def spatial(f: np.ndarray, plane: str, law: str) -> np.ndarray:
    """F in three dimensions: in a plane with the stretch across it that the plane asks for."""
    whole = np.eye(3)
    whole[: len(f), : len(f)] = f
    if len(f) == 2 and plane == "stress":

        def across(b: float) -> float:
            whole[2, 2] = b
            return kirchhoff(whole, law)[2, 2]

        whole[2, 2] = brentq(across, 0.5, 1.5, xtol=1e-15, rtol=1e-15)
    return whole


def kirchhoff(f: np.ndarray, law: str) -> np.ndarray:
    """J sigma of a three-dimensional F, by the formulas of the laws."""
    one = np.eye(3)
    if law == "neo_hookean":
        return MU * (f @ f.T - one) + LAME * np.log(np.linalg.det(f)) * one
    e = 0.5 * (f.T @ f - one)
    return f @ (2 * MU * e + LAME * np.trace(e) * one) @ f.T


def expected_fields(f: np.ndarray, plane: str, law: str) -> StressFields:
    whole = spatial(f, plane, law)
    # in plane stress per reference depth, so that J is that of the plane
    stress = kirchhoff(whole, law) / np.linalg.det(f)
    return StressFields(stress, 0.5 * (whole.T @ whole - np.eye(3)))


@pytest.mark.parametrize("deformation", [stretch, shear, anything])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_a_uniform_deformation(dimension: int, plane: str, law: str, deformation: object) -> None:
    """Every particle has the stress of the formulas, at surfaces and in corners as well; rotated, it is rotated."""
    body = block(dimension, material=replace(RUBBER, law=law))
    held = strain(scene_of(body, dimension=dimension, plane=plane, elasticity=HAMILTONIAN))
    f = deformation(dimension)  # type: ignore[operator]
    stress, green = expected_fields(f, plane, law)
    for turn in (np.eye(dimension), rotation(dimension, 2.5)):
        held.put(held.particles.positions @ (turn @ f - np.eye(dimension)).T)
        fields = held.model.stress_fields(held.state)
        whole = np.eye(3)
        whole[:dimension, :dimension] = turn
        turned = np.broadcast_to(whole @ stress @ whole.T, fields.stresses.shape)
        np.testing.assert_allclose(fields.stresses, turned, atol=3e-12 * np.abs(stress).max())
        np.testing.assert_allclose(fields.strains, np.broadcast_to(green, fields.strains.shape), atol=1e-13)
        assert np.trace(fields.stresses[:, :dimension, :dimension], axis1=1, axis2=2) / -dimension == pytest.approx(
            held.model.pressures(), rel=1e-9
        )


@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_springs_have_the_stress_of_the_linear_law(dimension: int, plane: str, normalization: str) -> None:
    """Also at surfaces, whatever rotation the particles have of their own."""
    elasticity = Elasticity(model="springs", normalization=normalization)
    held = hold(scene_of(block(dimension), dimension=dimension, plane=plane, elasticity=elasticity))
    f = rotation(dimension, 0.7) @ anything(dimension)
    n = held.particles.count
    rotors = rotors_of(0.7 + 0.1 * random(n, 2 * dimension - 3, seed=5))
    held.put(held.particles.positions @ (f - np.eye(dimension)).T, rotors)
    fields, expected = held.model.stress_fields(held.state), expected_fields(f, plane, "st_venant_kirchhoff")
    scale = np.abs(expected.stresses).max()
    np.testing.assert_allclose(fields.stresses, np.broadcast_to(expected.stresses, (n, 3, 3)), atol=1e-11 * scale)
    np.testing.assert_allclose(fields.strains, np.broadcast_to(expected.strains, (n, 3, 3)), atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_row_of_springs_has_no_strain_across_itself(dimension: int) -> None:
    row = block(dimension, cells=(4, 1, 1))
    held = hold(scene_of(row, dimension=dimension, elasticity=Elasticity(model="springs")))
    turn = rotation(dimension, 0.7)
    axis = np.array([1.0]) if dimension == 2 else np.array([2.0, -1.0, 2.0]) / 3.0
    f = turn @ stretch(dimension)
    rotors = rotors_of(np.tile(0.7 * axis, (held.particles.count, 1)))
    held.put(held.particles.positions @ (f - np.eye(dimension)).T, rotors)
    fields, expected = held.model.stress_fields(held.state), expected_fields(f, "strain", "st_venant_kirchhoff")
    np.testing.assert_allclose(fields.strains, np.broadcast_to(expected.strains, fields.strains.shape), atol=1e-8)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_energy_densities_are_the_energy_but_for_the_control(dimension: int, plane: str, law: str) -> None:
    held = strain(irregular(dimension, plane=plane, law=law))
    volumes = held.particles.spacings**dimension
    held.put(held.particles.positions @ (0.1 * random(dimension, dimension, seed=4)).T)
    assert volumes @ held.model.energy_densities(held.state) == pytest.approx(held.energy, rel=1e-12)
    held.put(strained_state(held))
    assert 0.0 < volumes @ held.model.energy_densities(held.state) < held.energy


@pytest.mark.parametrize("dimension", [2, 3])
def test_energy_densities_of_springs_are_the_energy(dimension: int) -> None:
    held = hold(scene_of(block(dimension), dimension=dimension))
    held.put(*random_state(held.particles))
    assert 0.01**dimension * held.model.energy_densities(held.state).sum() == pytest.approx(held.energy(), rel=1e-12)


def test_von_mises_of_known_states() -> None:
    uniaxial, pressure, pure = np.diag([3.0, 0.0, 0.0]), -2.0 * np.eye(3), np.zeros((3, 3))
    pure[0, 1] = pure[1, 0] = 1.0
    found = von_mises(np.array([uniaxial, pressure, pure, uniaxial + pressure]))
    np.testing.assert_allclose(found, [3.0, 0.0, np.sqrt(3.0), 3.0], atol=1e-15)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_von_mises_takes_the_stress_across_the_plane(plane: str) -> None:
    """Small uniaxial strain: sigma_zz = nu (sigma_xx + sigma_yy) in plane strain and 0 in plane stress."""
    material = Material(1000.0, 1e7, 0.3)
    held = strain(scene_of(block(2, material=material), plane=plane, elasticity=HAMILTONIAN))
    eps = 1e-8
    held.put(eps * held.particles.positions * np.array([1.0, 0.0]))
    lame, mu = lame_constants(material, 2, plane)
    xx, yy = (lame + 2 * mu) * eps, lame * eps
    zz = 0.3 * (xx + yy) if plane == "strain" else 0.0
    expected = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2))
    np.testing.assert_allclose(von_mises(held.model.stress_fields(held.state).stresses), expected, rtol=1e-6)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("elasticity", [HAMILTONIAN, Elasticity(model="springs")])
def test_a_simulation_shows_them(elasticity: Elasticity, precision: str) -> None:
    """Looking changes nothing, and a restored state shows the same."""
    runs = [Simulation(beam(2, elasticity=elasticity, gravity=(0.0, -9.81)), precision=precision) for _ in range(2)]
    for run in runs:
        run.advance(5)
    seen = (runs[0].stresses, runs[0].strains, runs[0].von_mises, runs[0].strain_energy_densities)
    n = runs[0].particles.count
    assert [values.shape for values in seen] == [(n, 3, 3), (n, 3, 3), (n,), (n,)]
    for run in runs:
        run.advance(5)
    assert_same_bits([runs[0].state_arrays()], [runs[1].state_arrays()])
    restored = Simulation(runs[0].scene, precision=precision)
    restored.restore(runs[0].state_arrays())
    for name in ("stresses", "strains", "von_mises", "strain_energy_densities", "elastic_forces", "elastic_torques"):
        np.testing.assert_array_equal(getattr(restored, name), getattr(runs[0], name))

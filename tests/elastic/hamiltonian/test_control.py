"""The hourglass control: weaker in nearly incompressible materials, stronger where a neighbourhood is compressed."""

from __future__ import annotations

import numpy as np
import pytest

from tests.elastic.hamiltonian.test_dilatation import differences
from tests.elastic.hamiltonian.test_kernels import PLANES, irregular, rotation
from tests.elastic.states import Strained, strain
from tests.scenes import HAMILTONIAN, block, random, scene_of
from warp_mps.elastic.hamiltonian.control import control_share
from warp_mps.elastic.materials.constants import lame_constants, mean_lame
from warp_mps.scene import LAWS, Material


def compressed(held: Strained, stretch: float = 0.6) -> np.ndarray:
    """Displacements by a compression along x with random moves of a tenth of a spacing, and a rotation of it all."""
    n, d = held.particles.positions.shape
    moved = held.particles.positions * np.array([stretch, 1.05, 1.05])[:d] + 0.001 * random(n, d, seed=1)
    return moved @ rotation(d, 2.0).T - held.particles.positions


def test_the_control_is_weaker_where_lambda_acts_on_means() -> None:
    """Its factor is 1 - 0.22 (1 - 4 mu/lambda)^2."""
    for nu, expected in ((0.3, 1.0), (0.4, 1.0), (0.45, 1 - 0.22 * (5 / 9) ** 2), (0.49, 1 - 0.22 * (45 / 49) ** 2)):
        material = Material(1000.0, 1e7, nu)
        lame, _ = lame_constants(material, 3, "strain")
        share = control_share(np.array([mean_lame(material, 3, "strain")]), np.array([lame]))
        assert share == pytest.approx(expected, rel=1e-12)
        assert nu > 0.4 or share == 1.0


@pytest.mark.parametrize("stretch", [0.95, 0.8, 0.5, 0.1])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_control_grows_below_nine_tenths_of_the_volume(dimension: int, stretch: float) -> None:
    """Its stiffness is multiplied by 1 + 30 (0.9 - J)^3."""
    held = strain(scene_of(block(dimension), dimension=dimension, elasticity=HAMILTONIAN))
    flat = np.diag([stretch, 1.0, 1.0][:dimension]) - np.eye(dimension)
    held.put(held.particles.positions @ flat)
    expected = held.model.kappa.numpy() * (1.0 + 30.0 * max(0.9 - stretch, 0.0) ** 3)
    np.testing.assert_allclose(held.model.resistance.numpy(), expected, rtol=1e-12)


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_compressed_forces_are_minus_the_gradient_of_the_energy(
    dimension: int, plane: str, law: str, nu: float
) -> None:
    held = strain(irregular(dimension, plane=plane, law=law, nu=nu))
    displacements = compressed(held)
    expected = differences(held, displacements)
    assert (held.model.resistance.numpy() > 1.1 * held.model.kappa.numpy()).mean() > 0.5
    forces = held.put(displacements).forces
    np.testing.assert_allclose(forces, expected, atol=1e-6 * np.abs(expected).max())


def test_where_nothing_is_compressed_the_control_is_as_at_rest() -> None:
    held = strain(irregular(2))
    wide = held.put(0.2 * held.particles.positions)
    np.testing.assert_array_equal(wide.model.resistance.numpy(), wide.model.kappa.numpy())

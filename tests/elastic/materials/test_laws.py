"""The constitutive laws: stress and energy against each other, linear elasticity, and closed forms."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from tests.scenes import random
from warp_mps.core.device import open_device
from warp_mps.core.types import NumericTypes, numeric_types
from warp_mps.elastic.materials.constants import law_constants
from warp_mps.elastic.materials.laws import law_funcs
from warp_mps.scene import LAWS, Material

YOUNGS, NU = 1e7, 0.3
SHEAR = YOUNGS / (2 * (1 + NU))
LAME = NU * YOUNGS / ((1 + NU) * (1 - 2 * NU))
KINDS = [(dimension, plane, law) for dimension, plane in ((2, "strain"), (2, "stress"), (3, "strain")) for law in LAWS]
every_kind = pytest.mark.parametrize(("dimension", "plane", "law"), KINDS)


@functools.cache
def evaluator(numbers: NumericTypes) -> SimpleNamespace:
    """A kernel that evaluates a law for many displacement gradients."""
    laws = law_funcs(numbers)
    stress, density = laws.stress, laws.energy_density
    real, mat = numbers.real, numbers.mat

    @wp.kernel(module=f"tests.laws.{numbers.dimension}d.{numbers.precision}", enable_backward=False)
    def evaluate(
        law: wp.int32,
        lame: real,
        mu: real,
        plane_stress: wp.int32,
        h: wp.array(dtype=mat),
        stress_out: wp.array(dtype=mat),
        density_out: wp.array(dtype=real),
    ):
        i = wp.tid()
        stress_out[i] = stress(law, h[i], lame, mu, plane_stress)
        density_out[i] = density(law, h[i], lame, mu, plane_stress)

    return SimpleNamespace(evaluate=evaluate)


def apply(
    h: np.ndarray, plane: str, law: str, *, nu: float = NU, precision: str = "float64"
) -> tuple[np.ndarray, np.ndarray]:
    """First Piola-Kirchhoff stresses [Pa], shape [n, d, d], and energy densities [J/m^3], shape [n]."""
    device, d = open_device("cpu"), h.shape[-1]
    numbers = numeric_types(d, precision)
    lame, mu = law_constants(Material(1000.0, YOUNGS, nu, law), d, plane)
    stresses = wp.zeros(len(h), dtype=numbers.mat, device=device)
    densities = wp.zeros(len(h), dtype=numbers.real, device=device)
    gradients = wp.array(h, dtype=numbers.mat, device=device)
    inputs = [LAWS.index(law), lame, mu, int(d == 2 and plane == "stress"), gradients]
    wp.launch(evaluator(numbers).evaluate, len(h), inputs, [stresses, densities], device=device)
    return stresses.numpy().astype(float), densities.numpy().astype(float)


def gradients(dimension: int, size: float, count: int = 20) -> np.ndarray:
    """Random displacement gradients of some size."""
    return size * random(count, dimension, dimension, seed=3)


def turns(dimension: int, count: int = 20) -> np.ndarray:
    """Random rotation matrices."""
    matrices = Rotation.random(count, random_state=5).as_matrix()
    if dimension == 3:
        return matrices
    angles = np.linspace(-3.0, 3.0, count)
    return np.array([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]]).transpose(2, 0, 1)


@every_kind
def test_stress_is_the_gradient_of_the_energy(dimension: int, plane: str, law: str) -> None:
    h, step = gradients(dimension, 0.3), 1e-5
    stresses, _ = apply(h, plane, law)
    for place in np.ndindex(dimension, dimension):
        change = np.zeros((dimension, dimension))
        change[place] = step
        ends = [apply(h + sign * change, plane, law)[1] for sign in (1.0, -1.0)]
        slope = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(stresses[(slice(None), *place)], slope, atol=1e-8 * YOUNGS)


@pytest.mark.parametrize(("precision", "tolerance"), [("float64", 1e-7), ("float32", 2e-6)])
@pytest.mark.parametrize("size", [1e-8, 1e-7])
@every_kind
def test_small_strains_are_linear_elasticity(
    dimension: int, plane: str, law: str, size: float, precision: str, tolerance: float
) -> None:
    """The tolerance is relative: neither law subtracts nearly equal numbers, even in single precision."""
    h = gradients(dimension, size)
    strain = 0.5 * (h + h.transpose(0, 2, 1))
    lame = NU * YOUNGS / (1 - NU**2) if plane == "stress" else LAME
    trace = np.trace(strain, axis1=1, axis2=2)
    expected = 2 * SHEAR * strain + lame * trace[:, None, None] * np.eye(dimension)
    stresses, densities = apply(h, plane, law, precision=precision)
    # the second order is that of the strains
    tolerance += 10 * size
    np.testing.assert_allclose(stresses, expected, atol=tolerance * np.abs(expected).max())
    np.testing.assert_allclose(densities, 0.5 * np.einsum("nij,nij->n", expected, strain), rtol=tolerance)


@every_kind
def test_rotation_after_the_deformation_changes_nothing(dimension: int, plane: str, law: str) -> None:
    f, q = np.eye(dimension) + gradients(dimension, 0.3), turns(dimension)
    stresses, densities = apply(f - np.eye(dimension), plane, law)
    turned, same = apply(q @ f - np.eye(dimension), plane, law)
    np.testing.assert_allclose(same, densities, rtol=1e-12)
    np.testing.assert_allclose(turned, q @ stresses, atol=1e-13 * YOUNGS)


@every_kind
def test_rotation_before_the_deformation_changes_nothing(dimension: int, plane: str, law: str) -> None:
    """The material is isotropic."""
    f, q = np.eye(dimension) + gradients(dimension, 0.3), turns(dimension)
    _, densities = apply(f - np.eye(dimension), plane, law)
    _, same = apply(f @ q - np.eye(dimension), plane, law)
    np.testing.assert_allclose(same, densities, rtol=1e-12)


@every_kind
def test_cauchy_stress_is_symmetric(dimension: int, plane: str, law: str) -> None:
    f = np.eye(dimension) + turns(dimension) @ gradients(dimension, 0.3)
    stresses, _ = apply(f - np.eye(dimension), plane, law)
    cauchy = stresses @ f.transpose(0, 2, 1)
    np.testing.assert_allclose(cauchy, cauchy.transpose(0, 2, 1), atol=1e-14 * YOUNGS)
    assert np.abs(cauchy).max() > 0.1 * YOUNGS


@every_kind
def test_a_pure_rotation_has_neither_stress_nor_energy(dimension: int, plane: str, law: str) -> None:
    stresses, densities = apply(turns(dimension) - np.eye(dimension), plane, law)
    np.testing.assert_allclose(stresses, 0.0, atol=1e-14 * YOUNGS)
    np.testing.assert_allclose(densities, 0.0, atol=1e-15 * YOUNGS)


def test_plane_strain_is_space_without_strain_across() -> None:
    for law in LAWS:
        h = gradients(2, 0.3)
        stresses, densities = apply(h, "strain", law)
        in_space, same = apply(np.pad(h, ((0, 0), (0, 1), (0, 1))), "strain", law)
        np.testing.assert_allclose(stresses, in_space[:, :2, :2], atol=1e-14 * YOUNGS)
        np.testing.assert_allclose(densities, same, rtol=1e-12)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.49])
def test_neo_hookean_plane_stress_leaves_no_stress_across(nu: float) -> None:
    """The stretch across that makes the 3-D stress there vanish is sought, and the 3-D law evaluated at it."""
    h = np.concatenate((gradients(2, 0.3), gradients(2, 0.01), gradients(2, 0.6, 5)))
    # strongly compressed, a material of nu < 0 has no such stretch
    h = h[np.linalg.det(np.eye(2) + h) > 0.5]
    stresses, densities = apply(h, "stress", "neo_hookean", nu=nu)
    in_space = np.pad(h, ((0, 0), (0, 1), (0, 1)))

    def across(stretch: float, gradient: np.ndarray) -> float:
        gradient[2, 2] = stretch - 1.0
        return apply(gradient[None], "strain", "neo_hookean", nu=nu)[0][0, 2, 2]

    for gradient in in_space:
        gradient[2, 2] = brentq(across, 0.5, 5.0, args=(gradient,), xtol=1e-14) - 1.0
    expected, same = apply(in_space, "strain", "neo_hookean", nu=nu)
    np.testing.assert_allclose(expected[:, 2, 2], 0.0, atol=1e-10 * YOUNGS)
    np.testing.assert_allclose(stresses, expected[:, :2, :2], atol=1e-10 * YOUNGS)
    np.testing.assert_allclose(densities, same, rtol=1e-10)


@pytest.mark.parametrize("stretch", [0.4, 0.8, 1.3, 2.0])
def test_neo_hookean_tension_of_a_rod(stretch: float) -> None:
    """A rod free at its sides, of lambda = 0 (nu = 0): P = mu (s - 1/s), and W = mu/2 (s^2 - 1 - 2 ln s)."""
    shear = 0.5 * YOUNGS
    expected = shear * (stretch - 1 / stretch)
    energy = 0.5 * shear * (stretch**2 - 1 - 2 * np.log(stretch))
    for dimension, plane in ((2, "strain"), (2, "stress"), (3, "strain")):
        h = np.zeros((1, dimension, dimension))
        h[0, 0, 0] = stretch - 1
        stresses, densities = apply(h, plane, "neo_hookean", nu=0.0)
        assert stresses[0, 0, 0] == pytest.approx(expected, rel=1e-13)
        assert np.abs(stresses[0]).sum() == pytest.approx(abs(expected), rel=1e-13)
        assert densities[0] == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("stretch", [0.5, 0.8, 1.3, 2.0])
def test_neo_hookean_tension_of_a_rod_that_thins(stretch: float) -> None:
    """Stretched by s, at the sides by b: mu (b^2 - 1) + lambda ln(s b^2) = 0 there, and so P = mu (s^2 - b^2)/s."""
    side = brentq(lambda b: SHEAR * (b**2 - 1) + LAME * np.log(stretch * b**2), 0.1, 3.0, xtol=1e-15)
    expected = SHEAR * (stretch**2 - side**2) / stretch
    for dimension, plane in ((2, "stress"), (3, "strain")):
        h = np.diag([stretch - 1, *[side - 1] * (dimension - 1)])[None]
        stresses, _ = apply(h, plane, "neo_hookean")
        np.testing.assert_allclose(stresses[0], np.diag([expected, *[0.0] * (dimension - 1)]), atol=1e-12 * YOUNGS)


def test_st_venant_kirchhoff_tension() -> None:
    """Sides held: P = s (2 mu + lambda) (s^2 - 1)/2."""
    for dimension in (2, 3):
        h = np.zeros((1, dimension, dimension))
        h[0, 0, 0] = 0.4
        stresses, densities = apply(h, "strain", "st_venant_kirchhoff")
        assert stresses[0, 0, 0] == pytest.approx(1.4 * (2 * SHEAR + LAME) * 0.48, rel=1e-13)
        assert densities[0] == pytest.approx(0.5 * (2 * SHEAR + LAME) * 0.48**2, rel=1e-13)


@every_kind
def test_single_precision(dimension: int, plane: str, law: str) -> None:
    h = gradients(dimension, 0.3)
    (stresses, densities), (rounded, near) = (
        apply(h, plane, law, precision=precision) for precision in ("float64", "float32")
    )
    np.testing.assert_allclose(rounded, stresses, atol=1e-6 * np.abs(stresses).max())
    np.testing.assert_allclose(near, densities, rtol=1e-4)

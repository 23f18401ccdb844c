"""The algebra of particles' rotations against SciPy's, through kernels made for the test."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation, Slerp

from tests.core.rotors import matrices_of, rotors_of, turned
from tests.scenes import random
from warp_mps.core.device import open_device
from warp_mps.core.rotation import identity_rotors, rotation_funcs, rotation_vectors
from warp_mps.core.types import NumericTypes, numeric_types

METHOD = "rotation_test"
KITS = [numeric_types(dimension, precision) for dimension in (2, 3) for precision in ("float64", "float32")]
DOUBLE = [numbers for numbers in KITS if numbers.precision == "float64"]
COUNT = 50
# some roundings of each precision
ROUNDING = {"float64": 2e-15, "float32": 1e-6}


@functools.cache
def pair_kernels(types: NumericTypes) -> SimpleNamespace:
    """A kernel for each function of rotations."""
    funcs = rotation_funcs(types, METHOD)
    mean_rotor, turn, torque_share, cross = funcs.mean_rotor, funcs.turn, funcs.torque_share, funcs.cross
    advance = funcs.advance
    rotor, vec, axial, real = types.rotor, types.vec, types.axial, types.real

    @types.kernel(METHOD)
    def turn_pairs(
        q: wp.array(dtype=rotor), q_other: wp.array(dtype=rotor), x: wp.array(dtype=vec), out: wp.array(dtype=vec)
    ):
        i = wp.tid()
        out[i] = turn(mean_rotor(q[i], q_other[i]), x[i])

    @types.kernel(METHOD)
    def share_torque(
        q: wp.array(dtype=rotor),
        q_other: wp.array(dtype=rotor),
        x: wp.array(dtype=vec),
        force: wp.array(dtype=vec),
        total_out: wp.array(dtype=axial),
        share_out: wp.array(dtype=axial),
    ):
        i = wp.tid()
        m = mean_rotor(q[i], q_other[i])
        total_out[i] = cross(x[i] + turn(m, x[i]), force[i])
        share_out[i] = torque_share(q[i], m, total_out[i])

    @types.kernel(METHOD)
    def rotate(q: wp.array(dtype=rotor), omega: wp.array(dtype=axial), dt: real, steps: wp.int32):
        i = wp.tid()
        for _ in range(steps):
            q[i] = advance(q[i], omega[i], dt)

    return SimpleNamespace(turn_pairs=turn_pairs, share_torque=share_torque, rotate=rotate)


@pytest.fixture(scope="module", autouse=True)
def _device() -> None:
    open_device("cpu")


def vectors(numbers: NumericTypes, size: float, seed: int = 0) -> np.ndarray:
    """Random rotation vectors, no longer than a size [rad]."""
    return random(COUNT, 2 * numbers.dimension - 3, seed=seed) * size / np.sqrt(2 * numbers.dimension - 3)


def turn(numbers: NumericTypes, q: np.ndarray, q_other: np.ndarray, x: np.ndarray) -> np.ndarray:
    """R X - X of the mean rotations, shape [n, d]."""
    out = wp.zeros(len(x), dtype=numbers.vec)
    inputs = [wp.array(q, dtype=numbers.rotor), wp.array(q_other, dtype=numbers.rotor), wp.array(x, dtype=numbers.vec)]
    wp.launch(pair_kernels(numbers).turn_pairs, len(x), inputs, [out])
    return out.numpy().astype(float)


def mean_vectors(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rotation vectors half way between two."""
    if a.shape[1] == 1:
        return 0.5 * (a + b)
    ends = [Rotation.from_rotvec(np.stack(pair)) for pair in zip(a, b, strict=True)]
    return np.array([Slerp([0.0, 1.0], pair)(0.5).as_rotvec() for pair in ends])


@pytest.mark.parametrize("numbers", KITS, ids=str)
def test_a_pair_turns_by_its_mean_rotation(numbers: NumericTypes) -> None:
    a = vectors(numbers, 2.0)
    b = a + vectors(numbers, 0.6, seed=1)
    x = random(COUNT, numbers.dimension, seed=2)
    found = turn(numbers, rotors_of(a), rotors_of(b), x)
    expected = np.einsum("nab,nb->na", matrices_of(rotors_of(mean_vectors(a, b))), x) - x
    np.testing.assert_allclose(found, expected, atol=4 * ROUNDING[numbers.precision])


@pytest.mark.parametrize("numbers", KITS, ids=str)
def test_small_rotations_keep_their_digits(numbers: NumericTypes) -> None:
    """R X - X of 1e-6 rad is 1e-6 X, to the precision's digits of that and not of X."""
    small = vectors(numbers, 1e-6)
    x = random(COUNT, numbers.dimension, seed=2)
    found = turn(numbers, rotors_of(small), rotors_of(small), x)
    arms = np.column_stack((-x[:, 1], x[:, 0])) * small if numbers.dimension == 2 else np.cross(small, x)
    # the second order is 1e-12
    np.testing.assert_allclose(found, arms, atol=1e-6 * ROUNDING[numbers.precision] + 1e-12)


@pytest.mark.parametrize("numbers", DOUBLE, ids=str)
def test_torque_shares_are_the_gradient_of_the_mean_rotation(numbers: NumericTypes) -> None:
    """Turning one of two particles by e changes f . R X by (its share of the torque) . e."""
    a = rotors_of(vectors(numbers, 2.0))
    b = turned(a, vectors(numbers, 0.6, seed=1))
    x, force = random(COUNT, numbers.dimension, seed=2), random(COUNT, numbers.dimension, seed=3)
    total, share = shares(numbers, a, b, x, force)
    step = 1e-5
    for axis in range(2 * numbers.dimension - 3):
        by = np.zeros((COUNT, 2 * numbers.dimension - 3))
        by[:, axis] = step
        ends = [turn(numbers, turned(a, sign * by), b, x) for sign in (1.0, -1.0)]
        slope = np.sum(force * (ends[0] - ends[1]), axis=1) / (2 * step)
        # differences: step^2 and rounding / step
        np.testing.assert_allclose(share[:, axis], slope, atol=1e-9)
    _, other = shares(numbers, b, a, x, force)
    np.testing.assert_allclose(share + other, total, atol=1e-14)


def shares(numbers: NumericTypes, a: np.ndarray, b: np.ndarray, x: np.ndarray, force: np.ndarray) -> list[np.ndarray]:
    """Torque of a force at R X on the pair, and the share of the first particle."""
    out = [wp.zeros(len(x), dtype=numbers.axial) for _ in range(2)]
    types = (numbers.rotor, numbers.rotor, numbers.vec, numbers.vec)
    inputs = [wp.array(values, dtype=dtype) for values, dtype in zip((a, b, x, force), types, strict=True)]
    wp.launch(pair_kernels(numbers).share_torque, len(x), inputs, out)
    return [array.numpy() for array in out]


def spun(numbers: NumericTypes, omega: np.ndarray, dt: float, steps: int) -> np.ndarray:
    """Rotors after some steps at constant angular velocities, from rest."""
    q = wp.array(identity_rotors(len(omega), numbers.dimension), dtype=numbers.rotor)
    wp.launch(pair_kernels(numbers).rotate, len(omega), [q, wp.array(omega, dtype=numbers.axial), dt, steps])
    return q.numpy().astype(float)


@pytest.mark.parametrize("numbers", KITS, ids=str)
def test_ten_turns_keep_length_and_angle(numbers: NumericTypes) -> None:
    steps = 2000
    omega = vectors(numbers, 1.0)
    omega *= 2 * np.pi / np.linalg.norm(omega, axis=1, keepdims=True)
    q = spun(numbers, omega, 10.0 / steps, steps)
    rounding = np.sqrt(steps) * ROUNDING[numbers.precision]
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=rounding)
    # the Cayley map falls short of an angle a by a^3 / 12 in 3-D, by a^3 / 48 in 2-D
    angle = 20 * np.pi / steps
    lag = steps * angle**3 / (48 if numbers.dimension == 2 else 12)
    expected = turned(identity_rotors(COUNT, numbers.dimension), omega * (10.0 - lag / (2 * np.pi)))
    np.testing.assert_allclose(matrices_of(q), matrices_of(expected), atol=10 * rounding + lag * angle**2)


@pytest.mark.parametrize("numbers", DOUBLE, ids=str)
def test_advance_is_of_second_order_over_a_given_time(numbers: NumericTypes) -> None:
    omega = vectors(numbers, 2.0)
    exact = matrices_of(rotors_of(omega))
    errors = [np.abs(matrices_of(spun(numbers, omega, 1.0 / steps, steps)) - exact).max() for steps in (10, 20, 40)]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([2.0, 2.0], abs=0.05)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 3.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_rotation_vectors_come_back(dimension: int, size: float) -> None:
    given = vectors(numeric_types(dimension), size)
    np.testing.assert_allclose(rotation_vectors(rotors_of(given)), given, rtol=1e-12, atol=1e-15 * size)
    # a quaternion and its opposite are one rotation
    if dimension == 3:
        np.testing.assert_allclose(rotation_vectors(-rotors_of(given)), given, rtol=1e-12, atol=1e-15 * size)


def test_a_plane_rotor_counts_more_than_one_turn() -> None:
    assert rotation_vectors(rotors_of(np.array([[3 * np.pi], [-3 * np.pi]])))[:, 0] == pytest.approx(
        [3 * np.pi, -3 * np.pi]
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_unrotated_particles_have_no_rotation(dimension: int) -> None:
    assert (rotation_vectors(identity_rotors(3, dimension)) == 0.0).all()

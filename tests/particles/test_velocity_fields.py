"""Initial velocity fields: beam modes against their frequency equations, their ends and their orthogonality."""

from __future__ import annotations

import math

import numpy as np
import pytest

from warp_mps.particles.velocity_fields import beam_root, velocity
from warp_mps.scene import VelocityField


def shape(kind: str, mode: int, along: np.ndarray) -> np.ndarray:
    """Values of a mode at fractions of the length, through a beam of 2 m along y whose middle is the origin."""
    field = VelocityField(kind=kind, amplitude=(3.0, 0.0), axis=(0.0, 5.0), origin=(0.0, -1.0), length=2.0, mode=mode)
    values = velocity(field, np.column_stack((np.full_like(along, 7.0), 2.0 * along - 1.0)))
    np.testing.assert_array_equal(values[:, 1], 0.0)
    return values[:, 0] / 3.0


@pytest.mark.parametrize(
    ("ends", "roots"),
    [
        ("free_free_beam", [4.730041, 7.853205, 10.995608, 14.137165]),
        ("clamped_free_beam", [1.875104, 4.694091, 7.854757, 10.995541]),
    ],
)
def test_roots_of_the_frequency_equations(ends: str, roots: list[float]) -> None:
    """Rao, Mechanical Vibrations, table 8.4."""
    assert [beam_root(ends, mode) for mode in (1, 2, 3, 4)] == pytest.approx(roots, rel=1e-6)
    sign = 1.0 if ends == "free_free_beam" else -1.0
    for mode in (1, 2, 5):
        root = beam_root(ends, mode)
        assert math.cos(root) * math.cosh(root) == pytest.approx(sign, abs=1e-9 * math.cosh(root))


def derivatives(kind: str, mode: int, at: float) -> tuple[float, float, float]:
    """Value, slope and curvature of a mode at a fraction of the length, from inside, by one-sided differences."""
    inward = 1.0 if at < 0.5 else -1.0
    step = 1e-3
    f = shape(kind, mode, at + inward * step * np.arange(5))
    slope = inward * (-25 * f[0] + 48 * f[1] - 36 * f[2] + 16 * f[3] - 3 * f[4]) / (12 * step)
    curvature = (35 * f[0] - 104 * f[1] + 114 * f[2] - 56 * f[3] + 11 * f[4]) / (12 * step**2)
    return float(f[0]), float(slope), float(curvature)


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_a_free_end_has_no_bending_moment(mode: int) -> None:
    root = beam_root("free_free_beam", mode)
    for end in (0.0, 1.0):
        value, _, curvature = derivatives("free_free_beam", mode, end)
        assert abs(value) == pytest.approx(1.0, rel=1e-9)
        assert curvature == pytest.approx(0.0, abs=1e-3 * root**2)
    assert derivatives("clamped_free_beam", mode, 1.0)[2] == pytest.approx(0.0, abs=1e-3 * root**2)


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_a_clamped_end_has_no_deflection_and_no_slope(mode: int) -> None:
    value, slope, curvature = derivatives("clamped_free_beam", mode, 0.0)
    assert value == pytest.approx(0.0, abs=1e-12)
    assert slope == pytest.approx(0.0, abs=1e-5)
    assert abs(curvature) > 1.0


@pytest.mark.parametrize("kind", ["sine", "free_free_beam", "clamped_free_beam"])
def test_modes_are_orthogonal(kind: str) -> None:
    along = (np.arange(4000) + 0.5) / 4000
    modes = np.array([shape(kind, mode, along) for mode in (1, 2, 3)])
    products = modes @ modes.T / len(along)
    # free and clamped beams: the mean square of a mode that is 1 at its end is 1/4
    np.testing.assert_allclose(np.diag(products), 0.5 if kind == "sine" else 0.25, rtol=1e-5)
    np.testing.assert_allclose(products - np.diag(np.diag(products)), 0.0, atol=1e-6)


@pytest.mark.parametrize("mode", [1, 2, 5])
def test_free_modes_carry_no_momentum(mode: int) -> None:
    along = (np.arange(4000) + 0.5) / 4000
    values = shape("free_free_beam", mode, along)
    assert values.mean() == pytest.approx(0.0, abs=1e-6)
    assert (values * (along - 0.5)).mean() == pytest.approx(0.0, abs=1e-6)


def test_sine_by_hand() -> None:
    np.testing.assert_allclose(
        shape("sine", 2, np.array([0.0, 0.125, 0.25, 0.75])), [0.0, 0.5**0.5, 1.0, -1.0], atol=1e-15
    )


def test_a_field_in_space() -> None:
    field = VelocityField(
        kind="sine", amplitude=(0.0, 1.0, 2.0), axis=(1.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0), length=2.0
    )
    np.testing.assert_allclose(velocity(field, np.array([[1.0, 4.0, 5.0]])), [[0.0, 1.0, 2.0]])


@pytest.mark.parametrize("mode", [1, 2])
def test_a_twist_by_hand(mode: int) -> None:
    """At half of the length, beside an axis along y through (1, 2, 3): omega x r, and nothing on the axis."""
    field = VelocityField(kind="twist", rate=4.0, axis=(0.0, 3.0, 0.0), origin=(1.0, 2.0, 3.0), length=6.0, mode=mode)
    positions = np.array([(1.5, 5.0, 3.0), (1.0, 5.0, 3.25), (1.0, 7.0, 3.0), (1.5, 2.0, 3.5)])
    omega = 4.0 * np.sin((mode - 0.5) * np.pi / 2.0)
    expected = [(0.0, 0.0, -0.5 * omega), (0.25 * omega, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    np.testing.assert_allclose(velocity(field, positions), expected, atol=1e-15)


@pytest.mark.parametrize("kind", ["free_free_beam", "clamped_free_beam"])
@pytest.mark.parametrize("mode", [8, 12, 400])
def test_high_modes_keep_their_digits(kind: str, mode: int) -> None:
    """Far from both ends a high mode is a plain wave of amplitude sqrt(2)/2 beside its unit end."""
    field = VelocityField(kind=kind, amplitude=(0.0, 1.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=1.0, mode=mode)
    along = np.linspace(0.4, 0.6, 20_001)
    values = velocity(field, np.column_stack((along, 0.0 * along)))[:, 1]
    assert np.abs(values).max() == pytest.approx(np.sqrt(0.5), rel=1e-3)
    assert velocity(field, np.array([[1.0, 0.0]]))[0, 1] == pytest.approx(1.0)


def flow_field(kind: str, dimension: int) -> VelocityField:
    """A flow of a liquid, turned so that no axis of the scene is one of its own."""
    axis = np.array((0.8, 0.6, 0.0) if dimension == 2 else (2.0, 1.0, 2.0))[:dimension]
    across = np.array((-0.6, 0.8) if dimension == 2 else (1.0, 2.0, -2.0))
    fields: dict[str, object] = {"kind": kind, "axis": axis, "origin": [0.2, -0.1, 0.4][:dimension]}
    if kind == "stagnation":
        return VelocityField(**fields, rate=-3.0)  # type: ignore[arg-type]
    depth = {"depth": 0.7} if kind == "standing_wave" else {}
    return VelocityField(**fields, amplitude=0.5 * across, length=1.3, **depth)  # type: ignore[arg-type]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", ["stagnation", "taylor_green", "standing_wave"])
def test_flows_have_no_divergence(kind: str, dimension: int) -> None:
    field, step = flow_field(kind, dimension), 1e-4
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (50, dimension))
    shifts = step * np.eye(dimension)
    gradients = [(velocity(field, points + shift) - velocity(field, points - shift)) / (2 * step) for shift in shifts]
    divergence = sum(gradient[:, axis] for axis, gradient in enumerate(gradients))
    assert np.abs(divergence).max() < 1e-5 * np.abs(gradients).max()


def test_stagnation_by_hand() -> None:
    field = VelocityField(kind="stagnation", rate=-100.0, axis=(1.0, 0.0), origin=(0.0, 1.0))
    np.testing.assert_allclose(velocity(field, np.array([[0.5, 1.25]])), [[-50.0, 25.0]])
    field = VelocityField(kind="stagnation", rate=2.0, axis=(0.0, 0.0, 3.0), origin=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(velocity(field, np.array([[1.0, 2.0, 3.0]])), [[-1.0, -2.0, 6.0]])


def test_taylor_green_by_hand() -> None:
    """As in the books: u = -U cos(2 pi x/L) sin(2 pi y/L), v = U sin(2 pi x/L) cos(2 pi y/L)."""
    field = VelocityField(kind="taylor_green", amplitude=(0.0, 3.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=2.0)
    x, y = np.random.default_rng(0).uniform(-2.0, 2.0, (2, 20))
    u = -3.0 * np.cos(np.pi * x) * np.sin(np.pi * y)
    v = 3.0 * np.sin(np.pi * x) * np.cos(np.pi * y)
    np.testing.assert_allclose(velocity(field, np.column_stack((x, y))), np.column_stack((u, v)), atol=1e-14)


def test_standing_wave_by_hand() -> None:
    """Nothing crosses the bottom, the crests have the amplitude, and deep water does not overflow."""
    field = VelocityField(
        kind="standing_wave", amplitude=(0.0, 0.5), axis=(1.0, 0.0), origin=(0.0, -0.4), length=1.0, depth=0.4
    )
    k, x = 2.0 * np.pi, np.linspace(0.0, 1.0, 9)
    bottom = velocity(field, np.column_stack((x, np.full(9, -0.4))))
    surface = velocity(field, np.column_stack((x, np.zeros(9))))
    np.testing.assert_allclose(bottom[:, 1], 0.0, atol=1e-15)
    np.testing.assert_allclose(bottom[:, 0], -0.5 * np.sin(k * x) / np.sinh(0.4 * k), atol=1e-14)
    np.testing.assert_allclose(surface[:, 1], 0.5 * np.cos(k * x), atol=1e-14)
    np.testing.assert_allclose(surface[:, 0], -0.5 * np.sin(k * x) / np.tanh(0.4 * k), atol=1e-14)
    deep = VelocityField(
        kind="standing_wave", amplitude=(0.0, 1.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=0.01, depth=10.0
    )
    np.testing.assert_allclose(velocity(deep, np.array([[0.0, 10.0], [0.0025, 10.0]])), [[0, 1], [-1, 0]], atol=1e-12)

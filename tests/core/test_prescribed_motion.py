"""Prescribed motion on the device: the formulas in NumPy, and its derivatives against SciPy's spline."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp
from scipy.interpolate import CubicSpline

from warp_mps.core.prescribed_motion import prescribed_motion_functions
from warp_mps.core.types import PRECISIONS, numeric_types
from warp_mps.scene.spline import clamped_slopes, table_values

TIMES = np.array([0.0, 0.1, 0.25, 0.3, 0.55])
ROWS = np.array([(0.0, 0.0), (0.1, -0.2), (0.15, 0.1), (0.1, 0.0), (0.4, 0.3)])
# before the table, on its rows, between them and after it
INSTANTS = np.array([-0.2, 0.0, 0.03, 0.1, 0.2, 0.27, 0.5, 0.55, 0.9])


@functools.cache
def kernels(precision: str) -> SimpleNamespace:
    """Kernels that evaluate the two functions at many times."""
    types = numeric_types(2, precision)
    real, vec = types.real, types.vec
    functions = prescribed_motion_functions(real, vec, f"test_prescribed_motion.{precision}")
    harmonic_motion, table_motion = functions.harmonic_motion, functions.table_motion

    @wp.kernel(module=f"test_prescribed_motion.{precision}", enable_backward=False)
    def harmonic(
        t: wp.array(dtype=wp.float64),
        amplitude: vec,
        frequency: wp.float64,
        phase: wp.float64,
        out: wp.array(dtype=vec, ndim=2),
    ):
        i = wp.tid()
        value, rate, second = harmonic_motion(t[i], amplitude, frequency, phase)
        out[0, i] = value
        out[1, i] = rate
        out[2, i] = second

    @wp.kernel(module=f"test_prescribed_motion.{precision}", enable_backward=False)
    def table(
        t: wp.array(dtype=wp.float64),
        first: wp.int32,
        last: wp.int32,
        times: wp.array(dtype=wp.float64),
        rows: wp.array(dtype=vec),
        slopes: wp.array(dtype=vec),
        cubic: wp.int32,
        out: wp.array(dtype=vec, ndim=2),
    ):
        i = wp.tid()
        value, rate, second = table_motion(t[i], first, last, times, rows, slopes, cubic)
        out[0, i] = value
        out[1, i] = rate
        out[2, i] = second

    return SimpleNamespace(harmonic=harmonic, table=table, vec=vec)


def evaluate_table(precision: str, *, cubic: bool, ahead: int = 0) -> np.ndarray:
    """Value, rate and second derivative at `INSTANTS`, shape [3, instants, 2]; `ahead` rows stand before the table."""
    made = kernels(precision)
    out = wp.zeros((3, len(INSTANTS)), dtype=made.vec, device="cpu")
    times = wp.array(np.concatenate((np.arange(ahead), TIMES)), dtype=wp.float64, device="cpu")
    pad = np.full((ahead, 2), 7.0)
    rows, slopes = (
        wp.array(np.concatenate((pad, part)), dtype=made.vec, device="cpu")
        for part in (ROWS, clamped_slopes(TIMES, ROWS))
    )
    at = wp.array(INSTANTS, dtype=wp.float64, device="cpu")
    inputs = [at, ahead, ahead + len(TIMES) - 1, times, rows, slopes, int(cubic)]
    wp.launch(made.table, len(INSTANTS), inputs, [out], device="cpu")
    return out.numpy().astype(float)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("ahead", [0, 3])
@pytest.mark.parametrize("cubic", [False, True])
def test_a_table_is_that_of_the_host(precision: str, ahead: int, cubic: bool) -> None:
    kind = "cubic" if cubic else "linear"
    expected = [table_values(TIMES, ROWS, kind, float(t)) for t in INSTANTS]
    found = evaluate_table(precision, cubic=cubic, ahead=ahead)[0]
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7 if precision == "float32" else 1e-14)


def test_derivatives_of_a_cubic_table_are_those_of_the_clamped_spline() -> None:
    """They are 0 outside the table."""
    spline = CubicSpline(TIMES, ROWS, bc_type="clamped")
    inside = (TIMES[0] <= INSTANTS) & (TIMES[-1] > INSTANTS)
    found = evaluate_table("float64", cubic=True)
    for order in (1, 2):
        expected = np.where(inside[:, None], spline(INSTANTS, order), 0.0)
        # at a row of the table the second derivative is that of either side, for it is continuous there
        np.testing.assert_allclose(found[order], expected, rtol=1e-10, atol=1e-10)


def test_a_linear_table_moves_at_the_slope_of_the_interval() -> None:
    found = evaluate_table("float64", cubic=False)
    between = INSTANTS.tolist().index(0.2)
    np.testing.assert_allclose(found[1, between], (ROWS[2] - ROWS[1]) / (TIMES[2] - TIMES[1]))
    assert (found[2] == 0.0).all()
    assert (found[1:, INSTANTS < 0.0] == 0.0).all()


@pytest.mark.parametrize("precision", PRECISIONS)
def test_a_harmonic_motion_starts_at_0_and_has_its_own_derivatives(precision: str) -> None:
    made, t = kernels(precision), np.array([0.0, 0.1, 0.37])
    out = wp.zeros((3, len(t)), dtype=made.vec, device="cpu")
    amplitude, omega, phase = np.array([0.3, -0.2]), 2.0 * np.pi * 3.0, 0.4
    inputs = [wp.array(t, dtype=wp.float64, device="cpu"), made.vec(*amplitude), 3.0, phase]
    wp.launch(made.harmonic, len(t), inputs, [out], device="cpu")
    angle = (omega * t + phase)[:, None]
    expected = [
        (np.sin(angle) - np.sin(phase)) * amplitude,
        omega * np.cos(angle) * amplitude,
        -(omega**2) * np.sin(angle) * amplitude,
    ]
    np.testing.assert_allclose(out.numpy(), expected, rtol=2e-6, atol=1e-5 if precision == "float32" else 1e-12)
    assert (out.numpy()[0, 0] == 0.0).all()

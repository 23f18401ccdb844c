"""The spline of prescribed motions, against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from warp_mps.scene.spline import clamped_slopes, table_values


@pytest.mark.parametrize("count", [2, 3, 4, 50])
def test_slopes_and_values_are_those_of_a_clamped_spline(count: int) -> None:
    rng = np.random.default_rng(count)
    times, rows = np.cumsum(rng.uniform(0.1, 2.0, count)), rng.normal(size=(count, 3))
    spline = CubicSpline(times, rows, bc_type="clamped")
    np.testing.assert_allclose(clamped_slopes(times, rows), spline(times, 1), atol=1e-12)
    for t in np.linspace(times[0], times[-1], 7):
        np.testing.assert_allclose(table_values(times, rows, "cubic", float(t)), spline(t), atol=1e-12)
        linear = [np.interp(t, times, column) for column in rows.T]
        np.testing.assert_allclose(table_values(times, rows, "linear", float(t)), linear, atol=1e-12)
    for kind in ("cubic", "linear"):
        np.testing.assert_array_equal(table_values(times, rows, kind, -9.0), rows[0])
        np.testing.assert_array_equal(table_values(times, rows, kind, 999.0), rows[-1])

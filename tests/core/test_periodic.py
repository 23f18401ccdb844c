"""The minimum-image displacement against NumPy."""

import numpy as np
import pytest
import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import numeric_types


@pytest.mark.parametrize("dimension", [2, 3])
def test_displacements_are_the_shortest_along_periodic_axes(dimension: int) -> None:
    types = numeric_types(dimension, "float64")
    displacement, vec = displacement_function(types), types.vec

    @wp.kernel(module="unique", enable_backward=False)
    def displace(x: wp.array(dtype=vec), period: vec, x_out: wp.array(dtype=vec)):
        x_out[wp.tid()] = displacement(x[0], x[wp.tid()], period)

    points = np.random.default_rng(2).uniform(-1.5, 1.5, (50, dimension))
    period = np.array([0.0, 1.1, 0.7][:dimension])
    x = wp.array(points, dtype=vec, device="cpu")
    found = wp.zeros_like(x)
    wp.launch(displace, len(points), [x, vec(*period)], [found], device="cpu")
    expected = points - points[0]
    images = np.arange(-4, 5)
    for axis in np.flatnonzero(period):
        candidates = expected[:, axis, None] + images * period[axis]
        expected[:, axis] = candidates[np.arange(50), np.abs(candidates).argmin(axis=1)]
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-14)
    assert np.abs(found.numpy()[:, 0]).max() > 1.5

"""Particle shifting."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import (
    L0,
    finished,
    fluids_of,
    pairs,
    stir,
    tank,
    wall_count,
)
from warp_mps.fluid.shifting import LARGEST_SHIFT, SHIFT
from warp_mps.scene import Flow


@pytest.mark.parametrize("dimension", [2, 3])
def test_shifts_even_out_the_particles_inside_and_leave_the_surface(dimension: int) -> None:
    scene = tank((16, 16) if dimension == 2 else (9, 9, 6), gravity=(), flow=Flow(scheme="corrected"))
    fluids = fluids_of(scene)
    stir(fluids, amount=0.05, speed=0.0)
    w = wall_count(fluids)
    gap, r, weights = pairs(fluids)
    before = fluids.state.x.numpy()[w:].copy()
    dense = weights[w:].sum(axis=1) >= 0.97 * fluids.model.operators.number_density
    fluids.step.pressure.surface.assign((~dense).astype(np.int32))
    fluids.step.time_step.displacement.assign([0.1 * L0])
    finished(fluids)
    moved = fluids.state.x.numpy()[w:] - before
    slope = np.einsum("nm,nmd->nd", (weights / r)[w:], gap[w:]) / fluids.model.operators.number_density
    shift = -SHIFT * 0.1 * L0 * slope
    length = np.linalg.norm(shift, axis=1)[:, None]
    shift *= np.minimum(1.0, LARGEST_SHIFT * L0 / length)
    still = ~moved.any(axis=1)
    np.testing.assert_allclose(moved[~still], shift[~still], atol=1e-12 * L0)
    beside = (weights[w:, w:] > 0.0) @ ~dense > 0
    np.testing.assert_array_equal(still, ~dense | beside)
    assert 0 < still.sum() < len(still)

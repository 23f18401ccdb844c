"""The faces of walls: where they are found, and what water does along them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import L0, fluids_of, small, stir, tank, until, wall_count
from warp_mps.fluid.fluids import Fluids
from warp_mps.fluid.mirror_planes import LEAST_DEPTH
from warp_mps.scene import Flow

G = 9.81


def planes(fluids: Fluids) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions of the fluid's particles, normals of the walls beside them, and their distances from the faces."""
    fluids.step.pressure.find_planes()
    return (
        fluids.state.x.numpy()[wall_count(fluids) :],
        fluids.step.pressure.normal.numpy(),
        fluids.step.pressure.depth.numpy(),
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_flat_wall_is_found_where_it_is(dimension: int) -> None:
    """Its face, wherever the water lies; no face where there are corners, and none out of reach."""
    cells = (14, 8) if dimension == 2 else (9, 6, 9)
    fluids = fluids_of(tank(cells))
    stir(fluids, amount=0.2)
    x, normal, depth = planes(fluids)
    reach, high = fluids.model.operators.radius, L0 * np.array(cells, float)
    others = [axis for axis in range(dimension) if axis != 1]
    open_floor = np.all([(x[:, k] > reach) & (x[:, k] < high[k] - reach) for k in others], axis=0)
    beside = open_floor & (x[:, 1] < 1.2 * L0)
    assert beside.any()
    down = np.zeros(dimension)
    down[1] = -1.0
    # a wall's particles lie on a lattice, of which one more or less may be in reach on a side
    assert np.all(normal[beside] @ down > 0.98)
    np.testing.assert_allclose(depth[beside], np.maximum(x[beside, 1], LEAST_DEPTH * L0), atol=0.2 * L0)
    corner = (x[:, 0] < 1.5 * L0) & (x[:, 1] < 1.5 * L0)
    assert corner.any()
    assert not depth[corner].any()
    assert not depth[open_floor & (x[:, 1] > reach)].any()


def test_beside_an_edge_there_is_no_face() -> None:
    """Water above the end of a step sees too little of it."""
    fluids = fluids_of(tank((14, 8)))
    x, w = fluids.state.x.numpy(), wall_count(fluids)
    # the walls' particles beyond x = 7 spacings are taken away
    x[:w][x[:w, 0] > 7 * L0] = [0.0, 10.0]
    fluids.state.x.assign(x)
    fluids.step.renew_neighbours()
    x, _, depth = planes(fluids)
    row = x[:, 1] < L0
    assert not depth[row & (x[:, 0] > 6 * L0)].any()
    assert depth[row & (x[:, 0] > 3.1 * L0) & (x[:, 0] < 4.6 * L0)].all()


def test_between_two_walls_there_is_no_face() -> None:
    """In the middle of a gap on their lattice, the normal is what rounding makes of none."""
    fluids = fluids_of(tank((3, 8), room=(3, 14)))
    x, _, depth = planes(fluids)
    middle = (np.abs(x[:, 0] - 1.5 * L0) < 0.1 * L0) & (x[:, 1] > 4 * L0)
    assert middle.any()
    assert not depth[middle].any()
    fluids.advance(0.01)
    assert np.isfinite(fluids.pressures()).all()
    assert np.isfinite(fluids.velocities()).all()


@pytest.mark.parametrize("scheme", ["corrected", "koshizuka_oka"])
def test_other_schemes_do_not_look_for_faces(scheme: str) -> None:
    fluids = fluids_of(tank(small(2), flow=Flow(scheme=scheme)))
    assert not planes(fluids)[2].any()


def test_a_column_sets_off_along_the_floor_as_its_series_says() -> None:
    """Accelerations and pressures of the first rows, away from the foot of the face, where the series has no bound.

    Without images the row on the floor has three quarters of its acceleration (Pohle 1950 for the series).
    """
    n, steps = 24, 60
    fluids = fluids_of(tank((n, 2 * n), room=(4 * n, 2 * n + 2)))
    w, width, height, dt = wall_count(fluids), n * L0, 2 * n * L0, 1e-5
    start, speeds = fluids.readings.positions()[w:], []

    def look(_: float) -> None:
        speeds.append(fluids.velocities()[w:])

    until(fluids, steps * dt, dt, look)
    # the first steps find the pressures
    found = (speeds[-1] - speeds[steps // 3]) / ((steps - 1 - steps // 3) * dt)
    inside = (start[:, 1] < 3 * L0) & (start[:, 0] < width - 5 * L0) & (start[:, 0] > 4 * L0)
    k = (np.arange(2000) + 0.5) * np.pi / height
    x, y = start[inside, :1], start[inside, 1:]
    grown = np.exp(k * (x - width)) / (1.0 + np.exp(-2.0 * k * width))
    falling = np.exp(-k * (x + width)) / (1.0 + np.exp(-2.0 * k * width))
    across = (2.0 * G / (height * k) * np.cos(k * y) * (grown - falling)).sum(axis=1)
    down = -(2.0 * G / (height * k) * np.sin(k * y) * (grown + falling)).sum(axis=1)
    np.testing.assert_allclose(found[inside, 0], across, rtol=0.03)
    np.testing.assert_allclose(found[inside, 1], down, atol=0.03 * across.max())
    excess = (2.0 * G / (height * k**2) * np.cos(k * y) * (1.0 - grown - falling)).sum(axis=1)
    np.testing.assert_allclose(fluids.pressures()[w:][inside], 1000.0 * excess, rtol=0.04)

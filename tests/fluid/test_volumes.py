"""Volumes that particles take up: of lattices, swollen, strained and stirred ones, drops, and lost particles."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import KINDS, L0, fluids_of, pairs, periodic_box, scene_of, small, stir, tank, tolerance, water
from tests.fluid.scenes import wall_count as walls_of
from warp_mps.fluid.pressure.density import SURFACE_DENSITY, SURFACE_NEIGHBOURS
from warp_mps.fluid.volumes import AIR
from warp_mps.scene import Flow


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_volumes_against_numpy(dimension: int, precision: str) -> None:
    fluids = fluids_of(tank(small(dimension), room=tuple(n + 2 for n in small(dimension))), precision=precision)
    stir(fluids, amount=0.1)
    lost = fluids.state.lost.numpy()
    lost[-1] = 1
    fluids.state.lost.assign(lost)
    fluids.step.renew_neighbours()
    w, ops, cell = walls_of(fluids), fluids.model.operators, L0**dimension
    _, r, weights = pairs(fluids)
    weights[:, -1] = weights[-1] = 0.0
    s = 1.0 + np.where(weights > 0.0, (1.0 - (r / ops.radius) ** 2) ** 4, 0.0)[w:].sum(axis=1)
    n, near = weights[w:].sum(axis=1) / ops.number_density, (weights[w:] > 0.0).sum(axis=1)
    inside = (n >= SURFACE_DENSITY) | (near >= SURFACE_NEIGHBOURS * ops.neighbours)
    airy = s < AIR * ops.smooth_density
    expected = np.where(inside & ~airy, cell * ops.smooth_density / s, cell)
    expected[-1] = 0.0
    assert 0 < inside.sum() < len(inside)
    found = fluids.volumes()
    np.testing.assert_allclose(found[w:], expected, rtol=tolerance(precision))
    assert not found[:w].any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_lattice_takes_up_its_cells(dimension: int) -> None:
    """Where it repeats itself; third from a surface neighbours are missed that hardly count."""
    for scene, near in ((periodic_box((11,) * dimension), 1e-9), (tank(small(dimension)), 0.005)):
        fluids = fluids_of(scene)
        volumes = fluids.volumes()[walls_of(fluids) :]
        np.testing.assert_allclose(volumes, L0**dimension, rtol=near)


def test_a_swelling_is_seen_and_spray_keeps_its_volume() -> None:
    fluids = fluids_of(scene_of(water([0.0, 0.0], [20 * L0, 20 * L0])))
    whole = fluids.volumes().sum()
    assert whole == pytest.approx(400 * L0**2, rel=5e-4)
    x = fluids.state.x.numpy().copy()
    middle = np.all(np.abs(x - 10 * L0) < 6 * L0, axis=1)
    for growth in (0.99, 1.01, 1.03):
        fluids.state.x.assign(growth * x)
        fluids.step.renew_neighbours()
        swollen = fluids.volumes()[middle].mean() / L0**2 - 1.0
        assert swollen == pytest.approx(growth**2 - 1.0, rel=0.01)
    fluids.state.x.assign(3.2 * x)
    fluids.step.renew_neighbours()
    assert fluids.volumes().sum() == pytest.approx(400 * L0**2)


@pytest.mark.parametrize(("dimension", "most"), [(2, 5e-4), (3, 2e-3)])
def test_a_lattice_that_is_drawn_out_keeps_its_volume(dimension: int, most: float) -> None:
    """By a twentieth, along an axis that its surface is far away from."""
    strain = np.array([1.05, 1.0 / 1.05, 1.0][:dimension])
    cells = (14,) * dimension
    fluids = fluids_of(scene_of(water([0.0] * dimension, [n * L0 for n in cells]), dimension=dimension))
    x = fluids.state.x.numpy().copy()
    middle = np.all(np.abs(x - 7 * L0) < 3 * L0, axis=1)
    fluids.state.x.assign(strain * x)
    fluids.step.renew_neighbours()
    assert fluids.volumes()[middle].mean() == pytest.approx(L0**dimension, rel=most)


@pytest.mark.parametrize("scheme", ["conservative", "corrected"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_water_in_disorder_takes_up_what_it_has(dimension: int, scheme: str) -> None:
    """Stirred in a box that repeats itself; by its number density it would take up 1 to 6 % less.

    Without shifts it gathers in clumps, where in 3-D a few particles seem to have air beside them: 1.4 to 1.9 %.
    """
    clumps = scheme == "conservative"
    fluids = fluids_of(periodic_box((24,) * 2 if dimension == 2 else (10,) * 3, flow=Flow(scheme=scheme)))
    stir(fluids, amount=0.25, speed=0.1)
    fluids.advance(0.8)
    assert fluids.volumes().mean() == pytest.approx(L0**dimension, rel=0.02 if clumps and dimension == 3 else 2e-3)

"""The front of a dam break against potential flow, to which that of water of ever smaller particles must tend."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import L0, fluids_of, tank, until
from tests.fluid.scenes import wall_count as walls_of
from tests.validation.potential_flow import GRAVITY, Collapse, collapse, velocities
from warp_mps.scene import Flow

HEIGHT = 2.0
FRONTS = (1.252, 1.474, 1.892, 2.292, 2.615)
G = 9.81


@pytest.fixture(scope="module")
def inviscid() -> Collapse:
    return collapse(end=2.1, longest=0.08, shortest=0.02)


def arrivals(count: int, scheme: str = "conservative") -> np.ndarray:
    """Times T at which the front of a column so many particles wide comes to places."""
    width = count * L0
    fluids = fluids_of(tank((count, 2 * count), room=(4 * count, 2 * count + 2), flow=Flow(scheme=scheme)))
    w, unit = walls_of(fluids), float(np.sqrt(0.5 * width / G))
    times, fronts = [0.0], [1.0]

    def look(t: float) -> None:
        times.append(t / unit)
        fronts.append((fluids.readings.positions()[w:, 0].max() + 0.5 * L0) / width)

    until(fluids, 2.3 * unit, 0.01 * unit, look)
    return np.interp(FRONTS, np.maximum.accumulate(fronts), times)


def test_boundary_elements_give_the_velocities_of_a_harmonic_potential() -> None:
    angle = np.linspace(0.5 * np.pi, 0.0, 101)
    x = np.column_stack((1.3 * np.cos(angle), 0.9 * np.sin(angle)))
    u, _ = velocities(x, x[:, 0] ** 2 - x[:, 1] ** 2)
    np.testing.assert_allclose(u, x * (2.0, -2.0), atol=1e-3)


def test_the_column_starts_as_its_series_says() -> None:
    """Horizontal acceleration of its face, and downwards of its top (Pohle 1950)."""
    face = np.column_stack((np.ones(161), np.linspace(HEIGHT, 0.0, 161)))
    top = np.column_stack((np.linspace(0.0, 1.0, 81), np.full(81, HEIGHT)))
    x = np.vstack((top[:-1], face))
    u, _ = velocities(x, -GRAVITY * x[:, 1])
    k = (np.arange(4000) + 0.5) * np.pi / HEIGHT
    for y in (0.1, 0.5, 1.0, 1.5):
        expected = np.sum(2.0 * GRAVITY / (HEIGHT * k) * np.tanh(k) * np.cos(k * y))
        found = np.interp(y, face[::-1, 1], u[80:][::-1, 0])
        assert found == pytest.approx(expected, rel=0.01)


@pytest.mark.long
def test_potential_flow_keeps_volume_and_energy(inviscid: Collapse) -> None:
    np.testing.assert_allclose(inviscid.volumes, inviscid.volumes[0], rtol=3e-3)
    np.testing.assert_allclose(inviscid.energies, inviscid.energies[0], rtol=5e-3)
    assert np.all(np.diff(inviscid.fronts) > 0.0)
    assert np.all(np.diff(inviscid.heights) < 0.0)


@pytest.mark.long
def test_fronts_of_potential_flow_do_not_depend_on_the_elements(inviscid: Collapse) -> None:
    fine = collapse(end=1.4, longest=0.06, shortest=0.01)
    for front in FRONTS[:3]:
        assert inviscid.arrival(front) == pytest.approx(fine.arrival(front), rel=0.005)


@pytest.mark.validation
@pytest.mark.long
@pytest.mark.parametrize("scheme", ["conservative", "koshizuka_oka"])
def test_the_front_tends_to_that_of_potential_flow(scheme: str, inviscid: Collapse) -> None:
    """It is late by about one spacing, two without images in the floor, from the start on, and then as fast."""
    expected = np.array([inviscid.arrival(front) for front in FRONTS])
    coarse, fine = (arrivals(count, scheme) - expected for count in (12, 24))
    assert np.all(fine > 0.0)
    assert np.all(fine < (0.06 if scheme == "conservative" else 0.12))
    assert np.all(fine < 0.75 * coarse)

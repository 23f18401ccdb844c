"""What the water sees of bodies: places, velocities and masses of markers, and the forces that go back."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.coupling.scenes import SOFT, lump, pool, system_of
from tests.fluid.scenes import KINDS, L0, tolerance
from warp_mps.core.types import numeric_types
from warp_mps.coupling.hydroelastic import Hydroelastic
from warp_mps.coupling.interface import Markers
from warp_mps.scene import Body, Material


def two_bodies(dimension: int, ratio: int, **fields: Any) -> Hydroelastic:
    """The system of a pool with two blocks, whose lattices do not begin where the water's cells do."""
    high = [3] * (dimension - 2)
    heavy = Material(3000.0, 5e5, 0.3)
    one = lump([1, 2, 1][:dimension], [3, 2, *high], ratio=ratio, **fields)
    other = lump([5, 2, 1][:dimension], [2, 3, *high], ratio=ratio, name="other", material=heavy)
    return system_of(pool(one, other, cells=(9, 8, 5)[:dimension]))


def members(markers: Markers) -> list[np.ndarray]:
    """The particles of each marker."""
    return [np.flatnonzero(markers.of_particle == j) for j in range(markers.count)]


@pytest.mark.parametrize("ratio", [1, 2, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_marker_stands_for_the_particles_of_a_cell(dimension: int, ratio: int) -> None:
    system = two_bodies(dimension, ratio)
    markers, particles = system.markers, system.particles
    cells = (3 * 2 + 2 * 3) * 3 ** (dimension - 2)
    assert (markers.count, markers.elastic) == (cells, cells * ratio**dimension)
    groups = members(markers)
    assert sorted(np.concatenate(groups)) == list(range(particles.elastic))
    for j, group in enumerate(groups):
        assert len(group) == ratio**dimension
        assert set(particles.bodies[group]) == {markers.bodies[j]}
        assert markers.masses[j] == pytest.approx(particles.masses[group].sum())
        assert np.ptp(particles.positions[group], axis=0).max() < L0
    x = markers.particles.positions[:cells]
    np.testing.assert_allclose(x / L0 % 1.0, 0.5, atol=1e-9)
    assert len(np.unique(np.round(x / L0, 6), axis=0)) == cells
    expected = 1000.0 * L0**dimension * 3 ** (dimension - 2) * np.array([6.0, 18.0])
    np.testing.assert_allclose(np.bincount(markers.bodies, markers.masses), expected)
    assert markers.particles.elastic == cells
    assert (markers.particles.spacings == L0).all()
    assert markers.particles.ranges[-1][1] == markers.particles.count == cells + particles.count - particles.elastic
    np.testing.assert_array_equal(markers.particles.positions[cells:], particles.positions[particles.elastic :])


@pytest.mark.parametrize("dimension", [2, 3])
def test_cells_lie_along_a_turned_lattice(dimension: int) -> None:
    """As those of the same bodies that are not turned do."""
    system = two_bodies(dimension, 2)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(dimension, dimension)))
    turned = replace(system.particles, positions=system.particles.positions @ turn.T)
    numbers = numeric_types(dimension, "float64")
    markers = Markers(turned, L0, types=numbers, device="cpu")
    assert {tuple(group) for group in members(markers)} == {tuple(group) for group in members(system.markers)}


def test_cells_in_the_middle_hold_what_is_left_over() -> None:
    """Five and three particles along cells of two: the water sees the faces where they are."""
    shape = lump([2, 2], [1, 1]).shape
    body = Body(name="odd", shape=type(shape)((5 * L0 / 2, 3 * L0 / 2), (0.1, 0.1)), material=SOFT, spacing=L0 / 2)
    markers = system_of(pool(body, cells=(9, 9))).markers
    sizes = [len(group) for group in members(markers)]
    assert sorted(sizes) == [1, 2, 2, 2, 4, 4]
    np.testing.assert_allclose(markers.masses, np.array(sizes) * (L0 / 2) ** 2 * 1000.0)
    along = np.unique(np.round((markers.particles.positions[: markers.count, 0] - 0.1) / L0, 6))
    np.testing.assert_allclose(along, [-0.75, 0.0, 0.75])


@pytest.mark.parametrize("ratio", [1, 2, 3])
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_places_and_velocities_are_means_now_and_ahead(dimension: int, precision: str, ratio: int) -> None:
    body = lump([2, 2, 1][:dimension], [3, 2, 3][:dimension], ratio=ratio)
    system = system_of(pool(body, cells=(8, 7, 5)[:dimension]), precision=precision)
    markers, solid, state = system.markers, system.solid.state, system.fluids.state
    rng, near = np.random.default_rng(ratio), tolerance(precision, 1e-12, 1e-5)
    u, v = (rng.uniform(-1.0, 1.0, solid.u.numpy().shape).astype(solid.u.numpy().dtype) for _ in range(2))
    solid.u.assign(0.01 * u)
    solid.v.assign(v)
    e = markers.elastic
    groups, x = members(markers), system.particles.positions[:e] + solid.u.numpy()[:e]
    for ahead in (0.0, 1e-3):
        markers.transfer_motion(solid, wp.array([ahead], dtype=wp.float64, device="cpu"), state.x, state.u)
        places, speeds = (array.numpy()[: markers.count] for array in (state.x, state.u))
        mean = np.array([v[group].mean(axis=0) for group in groups])
        np.testing.assert_allclose(speeds, mean, atol=near)
        expected = np.array([x[group].mean(axis=0) for group in groups]) + ahead * mean
        np.testing.assert_allclose(places, expected, atol=near)
    before = wp.zeros_like(solid.v)
    markers.find_accelerations(wp.array([0.02], dtype=wp.float64, device="cpu"), before, solid, state.a)
    np.testing.assert_allclose(state.a.numpy()[: markers.count], mean / 0.02, rtol=10.0 * near, atol=near)


@pytest.mark.parametrize("ratio", [1, 2, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_force_goes_to_the_particles_with_its_moment(dimension: int, ratio: int) -> None:
    """About the marker's place, whatever the deformation; and what a marker's values share is all of them."""
    system = two_bodies(dimension, ratio)
    markers, solid, state = system.markers, system.solid.state, system.fluids.state
    rng = np.random.default_rng(0)
    solid.u.assign(0.005 * rng.uniform(-1.0, 1.0, solid.u.numpy().shape))
    system.step.place_markers()
    force = rng.normal(size=(markers.count, dimension))
    system.step.passes.force.assign(force)
    markers.transfer_forces(system.step.passes.force, system.structure.external)
    external = system.structure.external.numpy()[: markers.elastic]
    np.testing.assert_allclose(external, markers.distribute(force), rtol=1e-12)
    x = system.particles.positions[: markers.elastic] + solid.u.numpy()[: markers.elastic]
    places = state.x.numpy()[: markers.count]
    for j, group in enumerate(members(markers)):
        np.testing.assert_allclose(external[group].sum(axis=0), force[j], rtol=1e-12)
        tensor = (x[group] - places[j]).T @ external[group]
        np.testing.assert_allclose(tensor, 0.0, atol=1e-15)

"""Gaps between bodies, walls and fluids, wet sides, and lattices in their shapes."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.particles.filling import fill_scene
from warp_mps.run.inventory.case_check import check
from warp_mps.run.inventory.gaps import gaps
from warp_mps.run.inventory.surfaces import nearest_offsets, surface_particles
from warp_mps.scene import Body, Contact, Fluid, Material, Scene, Wall, tank
from warp_mps.shapes import Box, Sphere, fill

RUBBER = Material(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.3)


def test_the_surface_of_a_block_is_its_outermost_layer() -> None:
    positions = fill(Box((0.5, 0.4, 0.3)).turned(0.4, axis=(1.0, 1.0, 0.0)), 0.1, 3)
    assert surface_particles(positions, 0.1).sum() == 5 * 4 * 3 - 3 * 2 * 1


def test_the_nearest_of_random_points() -> None:
    random = np.random.default_rng(1)
    queries, points = random.random((200, 3)), random.random((300, 3))
    found = nearest_offsets(queries, points, 0.1)
    offsets = points[None] - queries[:, None]
    lengths = np.linalg.norm(offsets, axis=2)
    nearest = offsets[np.arange(200), lengths.argmin(axis=1)]
    near = lengths.min(axis=1) <= 0.1
    assert 0 < near.sum() < 200
    np.testing.assert_array_equal(found[near], nearest[near])
    assert np.isnan(found[~near]).all()


def test_water_in_a_tank_is_beside_its_walls() -> None:
    walls = tank((0.0, 0.0), (0.2, 0.1), 0.01)
    water = Fluid(name="water", shape=Box.from_corners((0.0, 0.0), (0.2, 0.05)), spacing=0.01)
    found = check(Scene(fluids=(water,), walls=walls, gravity=(0.0, -9.81), duration=0.1))
    beside = {gap.side: gap for gap in found.item("water").gaps}
    assert sorted(beside) == ["+x", "-x", "-y"]
    assert all(gap.gap == pytest.approx(0.0, abs=1e-6) for gap in beside.values())
    assert beside["-y"].particles == 20
    assert beside["-y"].area == pytest.approx(0.2)
    wet = {item.name: item.wet_sides for item in found.items if item.kind == "wall"}
    assert sorted(wet.values()) == [("+x",), ("+y",), ("-x",)]


def test_a_gap_between_bodies_is_told_in_spacings() -> None:
    low = Body(name="low", shape=Box((0.2, 0.1), (0.0, 0.05)), material=RUBBER, spacing=0.01)
    high = Body(name="high", shape=Box((0.1, 0.1), (0.0, 0.163)), material=RUBBER, spacing=0.01)
    scene = Scene(bodies=(low, high), duration=0.1, contact=Contact(between="bodies"))
    (below,), (above,) = gaps(fill_scene(scene))
    assert (below.neighbour, below.side, above.neighbour, above.side) == ("high", "+y", "low", "-y")
    assert below.gap == above.gap == pytest.approx(1.3)
    assert not below.wet
    apart = Body(name="high", shape=Box((0.1, 0.1), (0.0, 0.2)), material=RUBBER, spacing=0.01)
    assert gaps(fill_scene(Scene(bodies=(low, apart), duration=0.1))) == [(), ()]


def test_what_lies_across_a_corner_is_not_faced() -> None:
    low = Wall(name="low", shape=Box.from_corners((0.0, 0.0), (0.1, 0.1)), spacing=0.01)
    drop = Fluid(name="drop", shape=Box.from_corners((0.11, 0.11), (0.2, 0.2)), spacing=0.01)
    assert check(Scene(fluids=(drop,), walls=(low,), gravity=(0.0, -9.81), duration=0.1)).item("low").gaps == ()


def test_a_lattice_that_does_not_fit_is_told() -> None:
    bar = Body(name="bar", shape=Box((0.123, 0.05)), material=RUBBER, spacing=0.01)
    ball = Body(name="ball", shape=Sphere(0.05, (0.0, 0.5)), material=RUBBER, spacing=0.01)
    found = check(Scene(bodies=(bar, ball), duration=0.1))
    lattice = found.item("bar").lattice
    assert lattice is not None
    assert lattice.across == (12, 5)
    assert lattice.steps == (1.0, 1.0)
    np.testing.assert_allclose(lattice.misfit, [[-0.15, -0.15], [0.0, 0.0]], atol=1e-9)
    assert lattice.worst == pytest.approx(-0.15)
    round_one = found.item("ball").lattice
    assert round_one is not None
    assert round_one.across == (10, 10)

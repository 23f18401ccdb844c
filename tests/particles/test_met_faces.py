"""Walls and water whose size is no whole number of spacings: their particles begin at the faces that meet something."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warp_mps.particles.filling import count_particles, fill_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Flow, Fluid, Scene, Wall
from warp_mps.shapes import Box, fill

L0 = 0.05


def wall(name: str, low: list[float], high: list[float]) -> Wall:
    """A wall between two corners, in spacings."""
    return Wall(name=name, shape=cells(low, high), spacing=L0)


def cells(low: list[float], high: list[float]) -> Box:
    """A box between two corners, in spacings."""
    return Box.from_corners((L0 * np.array(low)).tolist(), (L0 * np.array(high)).tolist())


def tank(thickness: float, width: float, depth: float, *more: Wall, **fields: Any) -> Scene:
    """Water at rest between walls of a thickness, all in spacings; the sides stand on the floor."""
    t, top = thickness, depth + 6.0
    walls = (
        wall("floor", [-t, -t], [width + t, 0.0]),
        wall("left", [-t, 0.0], [0.0, top]),
        wall("right", [width, 0.0], [width + t, top]),
    )
    water = Fluid(name="water", shape=cells([0.0, 0.0], [width, depth]), spacing=L0)
    given: dict[str, Any] = {"fluids": (water,), "walls": (*walls, *more), "gravity": (0.0, -9.81), "duration": 1.0}
    return Scene(**{**given, **fields})


def rows(scene: Scene, name: str) -> np.ndarray:
    """Positions of the particles of a wall or a fluid, in spacings."""
    particles = fill_scene(scene)
    first, last = particles.ranges[particles.names.index(name)]
    expected = count_particles(scene)[name]
    assert last - first == expected or not all(isinstance(item.shape, Box) for item in scene.filled)
    return particles.positions[first:last] / L0


@pytest.mark.parametrize("thickness", [3.0, 3.2, 3.45, 3.5, 3.8])
def test_the_first_rows_of_walls_lie_half_a_spacing_behind_their_wet_faces(thickness: float) -> None:
    """And the next ones a spacing further on, in columns that face those of the water, with no gap in the corner."""
    scene = tank(thickness, 20.0, 10.0)
    floor, left, right, water = (rows(scene, name) for name in ("floor", "left", "right", "water"))
    for depth in (-floor[:, 1], -left[:, 0], right[:, 0] - 20.0):
        levels = np.unique(depth.round(6))
        np.testing.assert_allclose(levels, 0.5 + np.arange(len(levels)), atol=1e-6)
        assert thickness - 1.0 < len(levels) <= thickness + 0.5
    assert left[:, 1].min() == pytest.approx(0.5)
    for solid, axis in ((floor, 0), (left, 1), (right, 1)):
        phases = (solid[:, axis] - water[0, axis]).round(6) % 1.0
        np.testing.assert_allclose(phases, 0.0, atol=1e-6)
    assert floor[:, 0].min() < -2.4
    assert floor[:, 0].max() > 22.4


def test_whole_numbers_of_spacings_keep_the_lattice_of_each_box_alone() -> None:
    scene = tank(3.0, 20.0, 10.0)
    for item in scene.filled:
        alone = fill(item.shape, L0, 2) / L0
        found = rows(scene, item.name)
        np.testing.assert_array_equal(found[np.lexsort(found.T)], alone[np.lexsort(alone.T)])


def test_an_obstacle_lies_on_the_floor() -> None:
    """A box of 0.161 m at a spacing of 0.05 m: 3 rows across 3.22 spacings, the outer ones half a spacing inside."""
    box = rows(tank(3.0, 24.0, 10.0, wall("box", [10.0, 0.0], [13.22, 3.22])), "box")
    for axis, low in ((0, 10.0), (1, 0.0)):
        np.testing.assert_allclose(np.unique(box[:, axis].round(6)), low + np.array([0.5, 1.61, 2.72]), atol=1e-6)


@pytest.mark.parametrize(("width", "depth", "columns", "layers"), [(24.56, 11.4, 25, 11), (12.3, 7.0, 12, 7)])
def test_water_lies_on_its_floor_and_its_walls(width: float, depth: float, columns: int, layers: int) -> None:
    """Its columns fill the width evenly, and its rows make up for the volume: 1.228 x 0.57 m, and one more tank."""
    water = rows(tank(3.45, width, depth), "water")
    assert len(water) == columns * layers
    step = width / columns
    np.testing.assert_allclose(np.unique(water[:, 0].round(6)), step * (np.arange(columns) + 0.5), atol=1e-6)
    np.testing.assert_allclose(np.unique(water[:, 1].round(6)), (np.arange(layers) + 0.5) / step, atol=1e-6)


def test_water_with_a_free_side_keeps_its_spacing_and_begins_at_the_other() -> None:
    column = Fluid(name="water", shape=cells([0.0, 0.0], [4.4, 8.4]), spacing=L0)
    water = rows(tank(3.0, 20.0, 10.0, fluids=(column,)), "water")
    np.testing.assert_allclose(np.unique(water[:, 0].round(6)), np.arange(4) + 0.5, atol=1e-6)
    np.testing.assert_allclose(np.unique(water[:, 1].round(6)), np.arange(8) + 0.5, atol=1e-6)


def test_water_fits_a_periodic_domain() -> None:
    domain = ([0.0, -1.0], [L0 * 20.4, 2.0])
    floor = wall("floor", [0.0, -3.0], [20.4, 0.0])
    scene = tank(3.0, 20.4, 10.0, walls=(floor,), flow=Flow(domain=domain, periodic=(0,)))
    for name in ("water", "floor"):
        x = np.unique(rows(scene, name)[:, 0].round(6))
        np.testing.assert_allclose(np.diff([*x, x[0] + 20.4]), 1.02, atol=1e-5)


def test_a_turned_tank_is_filled_as_a_straight_one() -> None:
    straight = tank(3.45, 12.3, 7.0)
    items = {
        kind: tuple(Fluid(name=i.name, shape=i.shape.turned(0.3), spacing=L0) for i in straight.fluids)
        if kind == "fluids"
        else tuple(Wall(name=i.name, shape=i.shape.turned(0.3), spacing=L0) for i in straight.walls)
        for kind in ("fluids", "walls")
    }
    gravity = 9.81 * np.array([np.sin(0.3), -np.cos(0.3)])
    turned = Scene(**items, gravity=gravity.tolist(), duration=1.0)  # type: ignore[arg-type]
    back = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    for item in straight.filled:
        one, other = rows(straight, item.name), rows(turned, item.name) @ back.T
        for axis in (0, 1):
            np.testing.assert_allclose(np.sort(one[:, axis]), np.sort(other[:, axis]), atol=1e-9)


def settled(thickness: float, width: float, depth: float) -> np.ndarray:
    """How far the centre of water in a tank moves in half a second, in spacings, shape [2]; none leaves the tank."""
    simulation = Simulation(tank(thickness, width, depth))
    wet = slice(simulation.particles.count - simulation.particles.liquid, None)
    start = simulation.positions[wet] / L0
    simulation.step_to(0.5)
    end = simulation.positions[wet] / L0
    assert (end > 0.0).all()
    assert (end[:, 0] < width).all()
    return (end - start).mean(axis=0)


@pytest.mark.parametrize("thickness", [3.45, 3.8])
def test_still_water_stays_still_whatever_the_walls_measure(thickness: float) -> None:
    """Its centre moves by less than 0.02 spacings."""
    assert np.abs(settled(thickness, 12.0, 6.0)).max() < 0.02


def test_water_that_does_not_fit_its_tank_settles_alike_whatever_the_walls_measure() -> None:
    """Its strained lattice comes into disorder, which may be denser by 0.1 l0^2/r_e^2 at the volume of a lattice."""
    moved = settled(3.45, 12.4, 6.3)
    np.testing.assert_allclose(moved, settled(3.0, 12.4, 6.3), atol=1e-6)
    assert np.abs(moved).max() < 0.5 * 6.3 * 0.1 / 3.1**2


@pytest.mark.long
@pytest.mark.parametrize(("thickness", "size"), [(3.45, (8.0, 6.0, 7.0)), (3.45, (8.44, 6.3, 7.56))])
def test_still_water_stays_still_in_three_dimensions(thickness: float, size: tuple[float, float, float]) -> None:
    """Walls whose lattice did not continue the water's let it settle by 0.055 spacings."""
    (w, h, d), t = size, thickness
    top = h + 5.0
    corners = {
        "floor": ([-t, -t, -t], [w + t, 0.0, d + t]),
        "left": ([-t, 0.0, -t], [0.0, top, d + t]),
        "right": ([w, 0.0, -t], [w + t, top, d + t]),
        "back": ([0.0, 0.0, -t], [w, top, 0.0]),
        "front": ([0.0, 0.0, d], [w, top, d + t]),
    }
    walls = tuple(wall(name, low, high) for name, (low, high) in corners.items())
    water = Fluid(name="water", shape=cells([0.0, 0.0, 0.0], list(size)), spacing=L0)
    scene = Scene(dimension=3, fluids=(water,), walls=walls, gravity=(0.0, -9.81, 0.0), duration=1.0)
    simulation = Simulation(scene)
    wet = slice(simulation.particles.count - simulation.particles.liquid, None)
    start = simulation.positions[wet] / L0
    simulation.step_to(0.5)
    end = simulation.positions[wet] / L0
    assert np.abs((end - start).mean(axis=0)).max() < 0.02
    assert (end > 0.0).all()
    assert (end[:, (0, 2)] < (w, d)).all()

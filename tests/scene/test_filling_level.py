"""Fluids filled to a level: boxes between walls, regions of any shape, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.shapes.surfaces import cube
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Fluid, Liquid, Scene, Wall, fill_to, tank
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, fill

L0 = 0.1
TANK = tank((0.5, -0.2), (1.3, 0.6), L0)


def corners(fluid: Fluid, dimension: int) -> tuple[list[float], list[float]]:
    """Corners of the box of a fluid, rounded."""
    assert isinstance(fluid.shape, Box)
    middle, size = np.array(fluid.shape.center)[:dimension], np.array(fluid.shape.size)[:dimension]
    return (middle - 0.5 * size).round(9).tolist(), (middle + 0.5 * size).round(9).tolist()


def test_a_tank_of_a_plane() -> None:
    oil = Liquid(density=900.0)
    water = fill_to(0.2, TANK, liquid=oil, name="oil")
    assert corners(water, 2) == ([0.5, -0.2], [1.3, 0.2])
    assert (water.name, water.liquid, water.spacing) == ("oil", oil, L0)
    scene = Scene(fluids=(water,), walls=TANK, gravity=(0, -9.81), duration=0.1)
    assert fill_scene(scene).liquid == 8 * 4
    assert fill_scene(scene).displaced == ()


@pytest.mark.parametrize("up", ["y", "z"])
def test_a_tank_of_space(up: str) -> None:
    walls = tank((0, 0, 0), (0.3, 0.4, 0.5), L0, up=up)
    expected = [0.3, 0.2, 0.5] if up == "y" else [0.3, 0.4, 0.2]
    assert corners(fill_to(0.2, walls, up=up), 3) == ([0.0, 0.0, 0.0], expected)


def test_walls_that_were_not_made_by_tank() -> None:
    """A floor that reaches under the walls, a step on it, and walls that begin above the step's foot."""
    floor = Wall(name="floor", shape=Box.from_corners((-1, -0.3), (2, 0)), spacing=L0)
    left = Wall(name="left", shape=Box.from_corners((-0.3, -0.1), (0, 1)), spacing=L0)
    right = Wall(name="right", shape=Box.from_corners((1, 0), (1.3, 0.5)), spacing=L0)
    assert corners(fill_to(0.4, (floor, left, right)), 2) == ([0.0, 0.0], [1.0, 0.4])
    assert corners(fill_to(0.5, [right, left, floor]), 2) == ([0.0, 0.0], [1.0, 0.5])


def test_the_fluid_gives_way_to_what_stands_in_the_tank() -> None:
    post = Wall(name="post", shape=Box.from_corners((0.9, -0.2), (1.1, 0.1)), spacing=L0)
    scene = Scene(fluids=(fill_to(0.2, TANK),), walls=(*TANK, post), gravity=(0, -9.81), duration=0.1)
    assert fill_scene(scene).displaced == (("water", "post", 2 * 3),)


@pytest.mark.parametrize(
    ("region", "volume"),
    [
        (Box.from_corners((0, 0, 0), (1, 1, 1)), 0.4),
        (Cylinder(0.5, 1.0, "y", (0.0, 0.5, 0.0)), 0.4 * np.pi / 4),
        # a spherical cap of height h: pi h^2 (3 R - h) / 3
        (Sphere(0.5, (0.0, 0.5, 0.0)), np.pi * 0.16 * 1.1 / 3),
        (Mesh(*cube()).moved((0.0, 0.5, 0.0)) - Box.from_corners((-1, -1, -1), (0, 2, 1)), 0.2),
    ],
)
def test_regions_are_cut_at_the_level(region: Shape, volume: float) -> None:
    """The free surface lies half a spacing above the uppermost particles, whatever the shape."""
    spacing = 0.02
    positions = fill(fill_to(0.4, region, spacing=spacing).shape, spacing, 3)
    assert len(positions) * spacing**3 == pytest.approx(volume, rel=0.02)
    assert positions[:, 1].max() == pytest.approx(0.39)
    assert positions[:, 1].min() == pytest.approx(0.01)


def test_a_region_of_a_plane() -> None:
    positions = fill(fill_to(0.0, Sphere(0.5), spacing=0.01).shape, 0.01, 2)
    assert len(positions) * 0.01**2 == pytest.approx(np.pi / 8, rel=0.01)


RIGHT, ROUND = TANK[2], Wall(name="ball", shape=Sphere(0.2), spacing=L0)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: fill_to(np.nan, TANK), "fluid 'water' level: is nan, must be a finite number"),
        (lambda: fill_to(-0.3, TANK), r"level: is -0\.3 m, must be above the bottom of the tank, -0\.2 m"),
        (lambda: fill_to(0.7, TANK), r"inside: no wall holds the fluid at \(0\.4999, 0\.65\) m: lower the level"),
        (lambda: fill_to(0.2, TANK[:2]), "inside: the walls have none at the high end of x: the fluid would run out"),
        (lambda: fill_to(0.2, TANK[1:]), "inside: the walls have none at the bottom"),
        (lambda: fill_to(0.2, (*TANK, ROUND)), r"inside: wall 'ball' is not a box along the axes; give the region"),
        (
            lambda: fill_to(0.2, (*TANK[:2], replace(RIGHT, shape=RIGHT.shape.turned(0.1)))),
            "wall 'right' is not a box along the axes",
        ),
        (lambda: fill_to(0.2, ()), r"inside: must be the walls of a tank, in a tuple, or a shape, not \(\)"),
        (lambda: fill_to(0.2, "tank"), "inside: must be the walls of a tank, in a tuple, or a shape, not 'tank'"),  # type: ignore[arg-type]
        (lambda: fill_to(0.2, TANK, up="z"), "up: is 'z', but the walls are of a 2-D scene"),
        (lambda: fill_to(0.2, TANK, up="x"), "up: is 'x', must be y or z"),
        (lambda: fill_to(0.2, TANK, spacing=0.0), r"spacing: is 0\.0, must be finite"),
        (lambda: fill_to(0.2, Sphere(1.0)), "spacing: must be given for a region"),
        (lambda: fill_to(0.2, Points([(0.0, 0.0)]), spacing=L0), "level: is for a shape with an inside"),
        (lambda: fill_to(2.0, Sphere(1.0), spacing=L0), "level: is 2 m, must lie in the region, .* from -1 to 1 m"),
        (
            lambda: fill_to(0.9, tank((0, 0), (1, 0.8), L0, open=())),
            r"above the bottom of the tank, 0 m, and at most at its ceiling, 0\.8 m",
        ),
    ],
)
def test_what_would_run_out_is_refused(call, match: str) -> None:
    with pytest.raises(InputError, match=match):
        call()

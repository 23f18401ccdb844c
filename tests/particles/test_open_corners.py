"""Remarks on walls that meet along an edge only."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.particles.test_met_faces import L0, cells, tank, wall
from warp_mps.particles.open_corners import remarks_on_open_corners
from warp_mps.scene import Scene, Wall
from warp_mps.shapes import Box


def without_corners(thickness: float = 3.0) -> Scene:
    """A floor and two sides that stand beside it and not on it, so that their common corners are missing."""
    floor = wall("floor", [0.0, -thickness], [20.0, 0.0])
    return replace(tank(thickness, 20.0, 10.0), walls=(floor, *tank(thickness, 20.0, 10.0).walls[1:]))


@pytest.mark.parametrize("thickness", [3.0, 3.45])
def test_a_missing_corner_is_remarked_with_its_place(thickness: float) -> None:
    left, right = remarks_on_open_corners(without_corners(thickness))
    where = "along an edge only, at (0, 0) m: water leaks there; let one reach past the other"
    assert left == f"wall 'floor': meets wall 'left' {where}"
    assert right.startswith("wall 'floor': meets wall 'right' along an edge only, at (1, 0) m")


def test_corners_that_are_filled_are_not_remarked() -> None:
    """By one of the walls, or by a third one."""
    scene = without_corners()
    block = Wall(name="block", shape=cells([-3.0, -3.0], [0.0, 0.0]), spacing=L0)
    (line,) = remarks_on_open_corners(replace(scene, walls=(*scene.walls, block)))
    assert "wall 'right'" in line
    assert remarks_on_open_corners(tank(3.0, 20.0, 10.0)) == []


def test_three_dimensions() -> None:
    boxes = {"floor": ((0, -3, 0), (8, 0, 8)), "side": ((-3, 0, 0), (0, 9, 8)), "far": ((-3, 0, 9), (0, 9, 12))}
    walls = tuple(
        Wall(name=name, shape=Box.from_corners([L0 * c for c in low], [L0 * c for c in high]), spacing=L0)
        for name, (low, high) in boxes.items()
    )
    water = replace(tank(3.0, 20.0, 10.0).fluids[0], shape=Box.from_corners((0, 0, 0), (8 * L0, 5 * L0, 8 * L0)))
    scene = Scene(dimension=3, fluids=(water,), walls=walls, gravity=(0.0, -9.81, 0.0), duration=1.0)
    (line,) = remarks_on_open_corners(scene)
    assert "at (0, 0, 0.2) m" in line

"""Remarks on boxes whose size is no whole number of spacings."""

from __future__ import annotations

from dataclasses import replace

import pytest

import warp_mps as mps
from tests.particles.test_met_faces import L0, cells, tank, wall
from tests.scenes import block, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.lattice_fit import lattice_fit
from warp_mps.particles.met_faces import Fits
from warp_mps.particles.misfits import remarks_on_misfits
from warp_mps.run.remarks import remarks_on_case
from warp_mps.shapes import Box


@pytest.mark.parametrize("thickness", [3.0, 3.45])
def test_dry_faces_and_whole_numbers_of_spacings_are_not_remarked(thickness: float) -> None:
    assert remarks_on_misfits(tank(thickness, 20.0, 10.0)) == []


def test_the_level_of_water_is_remarked_with_depths_that_fit() -> None:
    """Columns 0.9824 spacings apart make rows 1.0179 apart: 11 reach up to 11.197 of 11.4 spacings."""
    scene = tank(3.0, 24.56, 11.4)
    (line,) = remarks_on_misfits(scene)
    assert line.startswith("fluid 'water': is 11.4 spacings along y and takes 11: the face at the high end lies 0.20")
    assert "(0.0101 m) inside of the drawn one; 0.559853 or 0.610749 m would fit" in line
    for depth in (0.559853, 0.610749):
        water = replace(scene.fluids[0], shape=cells([0.0, 0.0], [24.56, depth / L0]))
        assert remarks_on_misfits(replace(scene, fluids=(water,))) == []


def test_a_wall_that_is_wet_on_both_sides_is_remarked() -> None:
    scene = tank(3.0, 24.0, 10.0, wall("baffle", [10.0, 0.0], [13.45, 20.0]), wall("thin", [18.0, 0.0], [19.4, 20.0]))
    baffle, thin = remarks_on_misfits(scene)
    assert baffle.startswith(
        "wall 'baffle': is 3.45 spacings along x and takes 3: its rows are 1.22 spacings apart, and"
    )
    assert baffle.endswith("settles by some 0.11 spacings; 0.15 or 0.2 m would fit")
    assert "is 1.4 spacings along x and takes 1: both faces lie 0.20 spacings (0.01 m) inside of the drawn" in thin


def test_a_body_keeps_its_lattice_and_is_remarked() -> None:
    body = block(2, shape=Box((0.0445, 0.03)))
    found = lattice_fit(body, Fits(scene_of(body)))
    assert found is not None
    assert (found.axes, found.across, found.steps) == (("x", "y"), (4, 3), (1.0, 1.0))
    assert found.met == found.matters == ((True, True), (True, True))
    assert found.offsets == pytest.approx({"-x": -0.225, "+x": -0.225, "-y": 0.0, "+y": 0.0})
    (line,) = remarks_on_misfits(scene_of(body))
    assert line.startswith("body 'block': is 4.45 spacings along x and takes 4: both faces lie 0.2")
    assert remarks_on_misfits(scene_of(block(2))) == []


def test_a_tank_filled_to_a_level_that_does_not_fit_is_remarked() -> None:
    """1.228 m wide and 0.57 m deep at 0.05 m: 25 columns between the walls, 11 rows from the bottom."""
    walls = mps.tank((0.0, 0.0), (1.228, 0.9), L0)
    scene = mps.Scene(fluids=(mps.fill_to(0.57, walls),), walls=walls, gravity=(0.0, -9.81), duration=1.0)
    (line,) = remarks_on_case(scene, fill_scene(scene))
    assert line.startswith("fluid 'water': is 11.4 spacings along y and takes 11: the face at the high end lies 0.20")


def test_the_dry_faces_of_a_tank_do_not_matter() -> None:
    """Walls of 3.45 spacings: 3 rows from the wet face; what they lack on the outside is told, but not as an offset."""
    scene = tank(3.45, 20.0, 10.0)
    fits, particles = Fits(scene), fill_scene(scene)
    for item, (first, last) in zip(scene.filled, particles.ranges, strict=True):
        fit = lattice_fit(item, fits, particles.positions[first:last])
        assert fit is not None
        # that of the particles is that of the lattice of a box
        assert fit == lattice_fit(item, fits)
        assert abs(fit.worst) < 1e-6
    floor = lattice_fit(scene.walls[0], fits)
    assert floor is not None
    assert min(offset for sides in floor.misfit for offset in sides) == pytest.approx(-0.45)


def test_a_wall_beside_stretched_water_reaches_half_a_step_of_it() -> None:
    """Water of 24.56 x 11 spacings has 25 columns 0.9824 apart; a side wall goes on with its rows, 1.0179 apart."""
    scene = tank(3.0, 24.56, 11.0)
    water, side = scene.fluids[0], next(wall for wall in scene.walls if wall.name == "left")
    fits = Fits(scene)
    found, beside = lattice_fit(water, fits), lattice_fit(side, fits)
    assert found is not None
    assert beside is not None
    assert beside.steps[1] == pytest.approx(found.steps[1])
    assert beside.misfit[1][0] == pytest.approx(found.misfit[1][0], abs=1e-6)

"""Remarks on water that is outside its tank at the end of a run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import warp_mps as mps
from tests.particles.test_met_faces import cells, tank
from warp_mps.particles.filling import fill_scene
from warp_mps.results.summary import read_summary
from warp_mps.run.spilled import remarks_on_spilled_fluid
from warp_mps.scene import Scene

L0, GRAVITY = 0.05, 9.81
# top of the sides, in spacings
RIM = 16.0


def moved(scene: Scene, place: tuple[float, float], velocity: tuple[float, float]) -> list[str]:
    """Remarks where the first fluid particle is at a place in spacings and moves at a velocity [m/s]."""
    particles = fill_scene(scene)
    x, u = particles.positions.copy(), np.zeros_like(particles.positions)
    first = particles.count - particles.liquid
    x[first], u[first] = np.multiply(place, L0), velocity
    return remarks_on_spilled_fluid(scene, particles, x, u)


@pytest.fixture
def basin() -> Scene:
    """A tank of 20 by 10 spacings, the inner corner at the origin, with walls 3 thick, and its water."""
    return tank(3.0, 20.0, 10.0)


@pytest.mark.parametrize(("place", "velocity"), [((5.0, 5.0), (0.0, 0.0)), ((5.0, 30.0), (1.0, -2.0))])
def test_water_in_or_above_its_tank_is_not_outside(basin: Scene, place: tuple, velocity: tuple) -> None:
    assert moved(basin, place, velocity) == []


def test_a_particle_that_fell_over_the_rim(basin: Scene) -> None:
    """It has fallen from 2 spacings above the rim, at 1 m/s to the right, down to the height of the floor."""
    height = (RIM + 2.0) * L0
    duration = np.sqrt(2.0 * height / GRAVITY)
    x = 20.0 + 1.0 + duration / L0
    (line,) = moved(basin, (x, 0.0), (1.0, -GRAVITY * duration))
    assert re.fullmatch(
        r"1 fluid particle is outside the tank at the end: over the top of 'right', as at \(.*\) m", line
    )
    assert re.search(rf"\(1\.05, {height:.4g}\) m", line)


def test_a_particle_that_went_through_a_side_or_the_floor(basin: Scene) -> None:
    (line,) = moved(basin, (25.0, 3.0), (0.5, -0.4))
    assert "1 fluid particle is outside the tank at the end: through or under 'right', as at" in line
    (line,) = moved(basin, (10.0, -6.0), (0.0, -0.5))
    assert "through or under 'floor'" in line
    assert "two spacings thick" in line


def test_what_has_left_the_domain(basin: Scene) -> None:
    (line,) = moved(basin, (10.0, -1e4), (0.0, 0.0))
    assert line == "1 fluid particle has left the domain at its low y end, as at (0.5, -500) m"


def test_water_that_runs_out_below_a_side_has_left_over_the_end_of_the_floor(tmp_path: Path) -> None:
    """The right side ends 4 spacings above the floor, and the floor below its middle."""
    walls = (
        mps.Wall(name="floor", shape=cells([-3, -3], [12, 0]), spacing=L0),
        mps.Wall(name="left", shape=cells([-3, 0], [0, 14]), spacing=L0),
        mps.Wall(name="right", shape=cells([10, 4], [13, 14]), spacing=L0),
    )
    water = mps.Fluid(name="water", shape=cells([0, 0], [10, 8]), spacing=L0)
    scene = mps.Scene(name="gap", walls=walls, fluids=(water,), gravity=(0.0, -GRAVITY), duration=0.4)
    summary = mps.run_scene(scene, tmp_path / "run", quiet=True)
    (line,) = [line for line in summary.remarks if "outside the tank" in line]
    found = re.match(r"(\d+) .* over the top of 'floor', as at \((.*), (.*)\) m", line)
    assert found is not None
    count, x, y = found.groups()
    assert summary.fluid["outside"] == int(count) > 0
    assert 8 * L0 < float(x) < 14 * L0
    assert 0.0 < float(y) < 4 * L0


def test_a_run_says_how_much_ran_over_and_keeps_it(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Water higher than the right side of its tank runs over it."""
    walls = (
        mps.Wall(name="floor", shape=cells([-3, -3], [13, 0]), spacing=L0),
        mps.Wall(name="left", shape=cells([-3, 0], [0, 14]), spacing=L0),
        mps.Wall(name="right", shape=cells([10, 0], [13, 4]), spacing=L0),
    )
    water = mps.Fluid(name="water", shape=cells([0, 0], [10, 8]), spacing=L0)
    scene = mps.Scene(name="weir", walls=walls, fluids=(water,), gravity=(0.0, -GRAVITY), duration=0.5)
    summary = mps.run_scene(scene, tmp_path / "run")
    lines = [line for line in summary.remarks if "outside the tank at the end: over the top of 'right'" in line]
    assert len(lines) == 1
    assert lines[0] in capfd.readouterr().err
    assert summary.fluid["outside"] > 0
    # others are on their way over the wall, and still above it
    assert summary.fluid["outside"] == int(lines[0].split()[0])
    assert f", {summary.fluid['outside']} particles outside the tank" in str(summary)
    assert read_summary(tmp_path / "run" / "run.json").remarks == summary.remarks
    assert not any("through" in line for line in summary.remarks)

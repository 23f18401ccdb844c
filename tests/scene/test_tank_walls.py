"""Walls of rectangular tanks: their places by hand, corners filled once, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Fluid, HarmonicMotion, HarmonicRotation, Scene, Wall, tank
from warp_mps.shapes import Box, contains, fill

L0 = 0.1


def corners(wall: Wall, dimension: int) -> tuple[list[float], list[float]]:
    """Corners of a wall, rounded."""
    assert isinstance(wall.shape, Box)
    middle, size = np.array(wall.shape.center)[:dimension], np.array(wall.shape.size)[:dimension]
    return (middle - 0.5 * size).round(9).tolist(), (middle + 0.5 * size).round(9).tolist()


def test_a_tank_of_a_plane_by_hand() -> None:
    walls = tank((0, 0), (0.8, 0.6), L0, layers=2)
    assert {wall.name: corners(wall, 2) for wall in walls} == {
        "bottom": ([-0.2, -0.2], [1.0, 0.0]),
        "left": ([-0.2, 0.0], [0.0, 0.6]),
        "right": ([0.8, 0.0], [1.0, 0.6]),
    }
    assert {wall.spacing for wall in walls} == {L0}
    assert len(fill(walls[0].shape, L0, 2)) == 12 * 2


def test_what_is_open_has_no_wall_and_the_others_end_there() -> None:
    walls = tank((0, 0), (0.8, 0.6), L0, layers=2, open=("left",))
    assert {wall.name: corners(wall, 2) for wall in walls} == {
        "bottom": ([0.0, -0.2], [1.0, 0.0]),
        "top": ([0.0, 0.6], [1.0, 0.8]),
        "right": ([0.8, 0.0], [1.0, 0.6]),
    }


@pytest.mark.parametrize("up", ["y", "z"])
def test_a_tank_of_space(up: str) -> None:
    """3 x 4 x 5 particles inside 5 x 6 x 7 with a wall of one layer all about: each cell of the shell filled once."""
    walls = tank((0, 0, 0), (0.3, 0.4, 0.5), L0, layers=1, open=(), up=up)
    assert [wall.name for wall in walls[:2]] == ["bottom", "top"]
    assert {wall.name for wall in walls} == {"bottom", "top", "left", "right", "front", "back"}
    positions = np.concatenate([fill(wall.shape, L0, 3) for wall in walls])
    cells = {tuple(cell) for cell in np.floor(positions / L0 + 1e-6).astype(int).tolist()}
    assert len(positions) == len(cells) == 5 * 6 * 7 - 3 * 4 * 5
    assert not any(contains(Box.from_corners((0, 0, 0), (0.3, 0.4, 0.5)), positions, -1e-6))
    by_name = {wall.name: corners(wall, 3) for wall in walls}
    axis = "xyz".index(up)
    assert by_name["bottom"][1][axis] == 0.0
    assert by_name["top"][0][axis] == pytest.approx((0.3, 0.4, 0.5)[axis])
    # right-handed, with x to the right: the front is towards +z if y is up, towards -y if z is
    expected = {"y": ([0, 0, 0.5], [0.3, 0.4, 0.6]), "z": ([0, -0.1, 0], [0.3, 0, 0.5])}
    np.testing.assert_allclose(by_name["front"], expected[up], atol=1e-12)


def test_a_fluid_fits_and_gives_way_to_nothing() -> None:
    water = Fluid(name="water", shape=Box.from_corners((0, 0), (0.8, 0.4)), spacing=L0)
    scene = Scene(fluids=(water,), walls=tank((0, 0), (0.8, 0.6), L0), gravity=(0, -9.81), duration=0.1)
    particles = fill_scene(scene)
    assert particles.displaced == ()
    assert particles.liquid == 8 * 4
    assert particles.count - particles.liquid == 14 * 3 + 2 * 3 * 6


def test_fields_are_passed_on_to_all() -> None:
    motion = HarmonicMotion(amplitude=(0.1, 0.0), frequency=1.0)
    rotation = HarmonicRotation(amplitude=0.1, frequency=1.0, pivot=(0.0, 0.0))
    for wall in tank((0, 0), (1, 1), L0, name="basin_", motion=motion, rotation=rotation, friction=0.3, slip="no"):
        assert wall.name.startswith("basin_")
        assert (wall.motion, wall.rotation, wall.friction, wall.slip) == (motion, rotation, 0.3, "no")


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: tank((0, 0), (1, 0), L0), r"tank low, high: are \(0, 0\) and \(1, 0\), must be 2 or 3 finite numbers"),
        (lambda: tank((0, 0), (1, 1, 1), L0), "tank low, high: are"),
        (lambda: tank((0, 0), (1, 1), 0.0), r"tank spacing: is 0\.0, must be finite and above 0"),
        (lambda: tank((0, 0), (1, 1), L0, layers=0), "tank layers: is 0, must be a whole number of at least 1"),
        (lambda: tank((0, 0), (1, 1), L0, layers=1.5), "tank layers: is 1.5"),  # type: ignore[arg-type]
        (lambda: tank((0, 0), (1, 1), L0, open=("lid",)), "names no side: 'lid'; there are left, right, bottom, top"),
        (lambda: tank((0, 0), (1, 1), L0, open=("front",)), "names no side: 'front'"),
        (lambda: tank((0, 0), (1, 1), L0, up="z"), "tank up: is 'z', must be y"),
        (lambda: tank((0, 0), (1, 1), L0, open=("left", "right", "bottom", "top")), "tank open: leaves no wall"),
        (lambda: tank((0, 0), (1, 0), L0, name="basin_"), "tank 'basin' low, high: are"),
    ],
)
def test_impossible_tanks_are_refused(call, match: str) -> None:
    with pytest.raises(InputError, match=match):
        call()

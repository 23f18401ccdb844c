"""Scenes far from the origin: the same in double precision, refused or remarked in single precision."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import warp_mps as mps
from warp_mps.app.animation_reader import Animation
from warp_mps.particles.filling import fill_scene
from warp_mps.run.far_scenes import remarks_on_far_scene
from warp_mps.scene import Scene

L0 = 0.02
FAR = (450_000.0, 5_000_000.0)


def dam(place: tuple[float, float], **fields: object) -> Scene:
    """A column of water of 5 by 8 particles that collapses."""

    def moved(x: float, y: float) -> list[float]:
        return [place[0] + x, place[1] + y]

    water = mps.Fluid(name="water", shape=mps.Box.from_corners(moved(0, 0), moved(5 * L0, 8 * L0)), spacing=L0)
    walls = mps.tank(moved(0, 0), moved(15 * L0, 12 * L0), L0)
    given = {"fluids": (water,), "walls": walls, "gravity": (0.0, -9.81), "duration": 0.1, **fields}
    return Scene(name="dam", **given)  # type: ignore[arg-type]


def beam(place: tuple[float, float]) -> Scene:
    """A cantilever of 16 by 4 particles."""
    rubber = mps.Material(density=1000.0, youngs_modulus=1e7, poissons_ratio=0.3)
    low = np.array(place)
    body = mps.Body(
        name="beam",
        shape=mps.Box.from_corners(low.tolist(), np.add(low, (0.08, 0.02)).tolist()),
        material=rubber,
        spacing=0.005,
    )
    clamp = mps.Support(name="clamp", region=mps.Box((0.02, 0.06), center=np.add(low, (0.0, 0.01)).tolist()))
    return Scene(name="beam", bodies=(body,), supports=(clamp,), gravity=(0.0, -9.81), duration=0.02)


@pytest.mark.parametrize("make", [dam, beam])
def test_double_precision_gives_the_same_motion_far_away(tmp_path: Path, make: object) -> None:
    """Coordinates are rounded to 1e-9 m there."""
    near, far = (mps.run_scene(make(place), tmp_path / str(place[0]), quiet=True) for place in ((0.0, 0.0), FAR))  # type: ignore[operator]
    assert far.energy["kinetic"] == pytest.approx(near.energy["kinetic"], rel=1e-5)
    assert not any("far from the origin" in line for line in far.remarks)


def test_results_far_away_are_where_they_were_computed(tmp_path: Path) -> None:
    scene = dam(FAR, duration=0.01)
    mps.run_scene(scene, tmp_path, quiet=True)
    x = fill_scene(scene).positions
    animation = Animation(tmp_path)
    points = np.concatenate([animation.points(number, 0) for number in range(len(animation.clouds))])
    np.testing.assert_allclose(points[:, :2], x, rtol=0.0, atol=1e-7)
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    water = np.array(UsdGeom.Points(stage.GetPrimAtPath("/Result/water")).GetPointsAttr().Get(0.0))
    assert len(np.unique(water[:, 0])) == 5


def test_single_precision_is_refused_far_away_and_remarked_at_some_distance() -> None:
    with pytest.raises(mps.InputError, match=r"rounds coordinates this far from the origin to .* spacings, allowed"):
        mps.Simulation(dam((1e4, 0.0)), precision="float32")
    some = dam((100.0, 0.0))
    (line,) = remarks_on_far_scene(some, fill_scene(some), "float32")
    assert line.startswith("in float32, coordinates this far from the origin are rounded to 0.0003 spacings")
    assert remarks_on_far_scene(dam((10.0, 0.0)), fill_scene(dam((10.0, 0.0))), "float32") == []
    assert remarks_on_far_scene(some, fill_scene(some), "float64") == []
    # bodies that touch nothing are computed from displacements
    mps.Simulation(beam((1e4, 0.0)), precision="float32")

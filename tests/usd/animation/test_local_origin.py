"""Animations of scenes far from the origin: exact places in a valid file, and readers that find them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.app.results import UPRIGHT
from tests.observers.views import blocks
from warp_mps.app.animation_reader import Animation
from warp_mps.app.convert.pvd import convert_to_pvd
from warp_mps.app.report.frames import make_frames
from warp_mps.app.view.picture import Painter, PictureOptions
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.scene import StageFrame
from warp_mps.usd.animation.writer import AnimationWriter

FAR = np.array([450e3, 5000e3])
RISE = 0.013
SMALL = PictureOptions(size=(320, 240))
PLACES = (("near", np.zeros(2)), ("far", FAR))


def particles_at(place: np.ndarray) -> Particles:
    """Two blocks of particles, moved by a place [m]."""
    made = fill_scene(blocks())
    return dataclasses.replace(made, positions=made.positions + place)


def write(folder: Path, particles: Particles, frame: StageFrame, *frames: int) -> Path:
    """Frame k is moved by `RISE` k [m] along the second axis."""
    path = folder / "run.usdc"
    animation = AnimationWriter(path, particles, frame, frame_rate=10.0, provenance={"case": "far"})
    for k in frames:
        moved = particles.positions + RISE * k * np.eye(2)[1]
        animation.write(k / 10.0, moved, np.zeros_like(moved))
    animation.close()
    return path


def places(path: Path, frame: StageFrame, code: float) -> np.ndarray:
    """Positions of all particles [m] as USD alone reads them, in the scene's axes."""
    stage, found = Usd.Stage.Open(str(path)), []
    for prim in stage.GetDefaultPrim().GetChildren():
        matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(code))
        found.append(np.array(UsdGeom.Points(prim).GetPointsAttr().Get(code), float) @ matrix[:3, :3] + matrix[3, :3])
    return frame.meters_per_unit * np.concatenate(found)[:, ["xyz".index(axis) for axis in frame.axes]]


@pytest.mark.parametrize("frame", [UPRIGHT, StageFrame()], ids=["centimetres", "metres"])
def test_every_particle_of_a_far_scene_stands_where_it_is(tmp_path: Path, frame: StageFrame) -> None:
    particles = particles_at(FAR)
    path = write(tmp_path, particles, frame, 0, 1, 2)
    least = particles.spacings.min()
    for k in range(3):
        expected = particles.positions + RISE * k * np.eye(2)[1]
        # 1e-9 m is what double precision holds at 5000 km
        np.testing.assert_allclose(places(path, frame, float(k)), expected, rtol=0.0, atol=1e-6 * least + 2e-9)


def test_extents_camera_and_backdrop_follow(tmp_path: Path) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    near, far = (write(tmp_path / name, particles_at(place), UPRIGHT, 0, 1) for name, place in PLACES)
    boxes, cameras, backdrops = [], [], []
    for path in (near, far):
        stage = Usd.Stage.Open(str(path))
        cache = UsdGeom.BBoxCache(1.0, [UsdGeom.Tokens.default_])
        boxes.append(np.array(cache.ComputeWorldBound(stage.GetPrimAtPath("/Result")).ComputeAlignedRange().GetMin()))
        camera = UsdGeom.Xformable(stage.GetPrimAtPath("/Scenery/Camera"))
        cameras.append(np.array(camera.ComputeLocalToWorldTransform(1.0).ExtractTranslation()))
        backdrop = UsdGeom.Mesh(stage.GetPrimAtPath("/Scenery/Backdrop"))
        place = np.array(backdrop.ComputeLocalToWorldTransform(1.0).ExtractTranslation())
        backdrops.append(place + np.array(backdrop.GetPointsAttr().Get()).mean(axis=0))
        validators = validation.ValidationRegistry().GetOrLoadAllValidators()
        assert [item.GetMessage() for item in validation.ValidationContext(validators).Validate(stage)] == []
    moved = np.zeros(3)
    moved[["xyz".index(axis) for axis in UPRIGHT.axes]] = FAR / UPRIGHT.meters_per_unit
    for found in (boxes, cameras, backdrops):
        np.testing.assert_allclose(found[1] - found[0], moved, rtol=0.0, atol=1e-3)


def test_readers_see_a_far_scene_as_a_near_one(tmp_path: Path) -> None:
    found, kinds = [], []
    for name, place in PLACES:
        write(tmp_path / name, particles_at(place), UPRIGHT, 0, 1, 2)
        animation = Animation(tmp_path / name)
        points = np.concatenate([animation.points(0, 2), animation.points(1, 2)])[:, [0, 2]]
        np.testing.assert_allclose(
            0.01 * points - place, particles_at(np.array([0.0, 2.0 * RISE])).positions, rtol=0.0, atol=1e-7
        )
        frames = make_frames(animation)
        low = np.array(frames.facts["low"]) - place
        found.append((low, frames.facts["clouds"][0]["count"], Painter(animation, SMALL).draw(2).astype(float) / 255.0))
        convert_to_pvd(tmp_path / name)
        # only a file in double precision can hold a far place
        file = next((tmp_path / name / "pvd").glob("left_*2.vtp")).read_text()
        kinds.append("Float64" in next(line for line in file.splitlines() if 'Name="Points"' in line))
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-6)
    assert kinds == [False, True]
    assert np.mean(np.abs(found[0][2] - found[1][2]) > 0.02) < 0.01


def test_a_translation_that_is_not_finite_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, particles_at(FAR), UPRIGHT, 0)
    stage = Usd.Stage.Open(str(path))
    stage.GetPrimAtPath("/Result/left").GetAttribute("xformOp:translate").Set((np.nan, 0.0, 0.0))
    stage.Save()
    with pytest.raises(InputError, match="left: is turned, scaled or nowhere"):
        Animation(tmp_path)


def test_a_stage_may_reference_a_far_result_and_move_it(tmp_path: Path) -> None:
    path = write(tmp_path, particles_at(FAR), StageFrame(), 0)
    stage = Usd.Stage.CreateInMemory()
    shot = UsdGeom.Xform.Define(stage, "/Shot")
    shot.GetPrim().GetReferences().AddReference(str(path))
    shot.ClearXformOpOrder()
    shot.AddTranslateOp(opSuffix="moved").Set((1.0, 0.0, 0.0))
    left = UsdGeom.Xformable(stage.GetPrimAtPath("/Shot/left")).ComputeLocalToWorldTransform(0.0)
    np.testing.assert_allclose(left.ExtractTranslation(), [FAR[0] + 1.0, FAR[1], 0.0], rtol=0.0, atol=1.0)

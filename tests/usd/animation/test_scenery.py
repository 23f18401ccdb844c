"""Camera and scenery of an animation: the camera sees everything, and its view grows with the scene alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

from tests.app.results import SPACE, UPRIGHT, write_result
from tests.observers.views import blocks
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Fluid, Scene, StageFrame, Wall
from warp_mps.shapes import Box
from warp_mps.usd.animation.colours import linear_to_srgb, srgb_to_linear
from warp_mps.usd.animation.occlusion import hidden_share, occluding_walls
from warp_mps.usd.animation.writer import AnimationWriter


def camera(stage: Usd.Stage) -> Gf.Camera:
    return UsdGeom.Camera(stage.GetPrimAtPath("/Scenery/Camera")).GetCamera(Usd.TimeCode.Default())


def opened(folder: Path, frame: StageFrame, frames: int = 3) -> Usd.Stage:
    write_result(folder, frame=frame, frames=frames)
    return Usd.Stage.Open(str(folder / "run.usdc"))


@pytest.mark.parametrize("frame", [UPRIGHT, SPACE, StageFrame(axes="xyz"), StageFrame(axes="yz", up_axis="Y")])
def test_the_camera_sees_every_particle_of_every_frame(frame: StageFrame, tmp_path: Path) -> None:
    stage = opened(tmp_path, frame)
    view = camera(stage).frustum
    shares = []
    for name in ("block", "floor"):
        points = UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}"))
        for code in range(3):
            for box in np.asarray(points.GetPointsAttr().Get(code), dtype=float):
                seen = view.ComputeViewMatrix() * view.ComputeProjectionMatrix()
                shares.append(np.array(seen.Transform(Gf.Vec3d(*box))))
    shares = np.abs(np.array(shares))
    assert shares.max() < 1.0
    # and fills the picture
    assert shares[:, :2].max() > 0.7
    # upright
    up = "XYZ".index(frame.up_axis)
    assert np.array(view.ComputeUpVector())[up] > 0.8


def test_the_backdrop_is_behind_everything_and_the_sun_before_it(tmp_path: Path) -> None:
    for frame in (UPRIGHT, SPACE):
        folder = tmp_path / frame.axes
        folder.mkdir()
        stage = opened(folder, frame)
        view = camera(stage).frustum
        backdrop = UsdGeom.Mesh(stage.GetPrimAtPath("/Scenery/Backdrop"))
        corners = np.asarray(backdrop.GetPointsAttr().Get())
        axis = int(np.ptp(corners, axis=0).argmin())
        everything = np.concatenate(
            [
                UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}")).GetExtentAttr().Get(2)
                for name in ("block", "floor")
            ]
        )
        eye = np.array(view.GetPosition())[axis] - corners[0, axis]
        assert ((everything[:, axis] - corners[0, axis]) * np.sign(eye) > 0.0).all()
        sun = UsdLux.DistantLight(stage.GetPrimAtPath("/Scenery/Key"))
        light = UsdGeom.Xformable(sun).GetLocalTransformation().TransformDir(Gf.Vec3d(0.0, 0.0, -1.0))
        assert np.array(light)[axis] * np.sign(eye) < 0.0


def test_the_scenery_depends_on_the_frames_alone_and_not_on_who_wrote_them(tmp_path: Path) -> None:
    """A resumed run has the camera of one that went on, and not that of frames which were dropped."""
    particles = fill_scene(blocks())

    def write(path: Path, frames: range, animation: AnimationWriter | None = None) -> Usd.Stage:
        options = {"frame_rate": 1.0, "provenance": {}}
        animation = animation or AnimationWriter(path, particles, StageFrame(axes="xy"), **options)  # type: ignore[arg-type]
        for k in frames:
            animation.write(k, particles.positions + 3.0 * k, particles.velocities)
        animation.close()
        return Usd.Stage.Open(str(path))

    whole, two = write(tmp_path / "whole.usdc", range(3)), write(tmp_path / "two.usdc", range(2))
    assert camera(whole) != camera(two)
    write(tmp_path / "cut.usdc", range(6))
    again = AnimationWriter.resume(
        tmp_path / "cut.usdc", particles, StageFrame(axes="xy"), frame_rate=1.0, provenance={}, after=1.0
    )
    resumed = write(tmp_path / "cut.usdc", range(2, 3), again)
    for name in ("Camera", "Backdrop"):
        for attribute in whole.GetPrimAtPath(f"/Scenery/{name}").GetAttributes():
            other = resumed.GetPrimAtPath(f"/Scenery/{name}").GetAttribute(attribute.GetName())
            assert attribute.Get() == other.Get(), attribute


def test_every_body_has_a_material_that_shows_its_colours(tmp_path: Path) -> None:
    stage = opened(tmp_path, SPACE)
    for path in ("/Result/block", "/Result/floor", "/Scenery/Backdrop"):
        prim = stage.GetPrimAtPath(path)
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        surface, _, _ = material.ComputeSurfaceSource()
        source, _, _ = surface.GetInput("diffuseColor").GetConnectedSource()
        reader = UsdShade.Shader(source.GetPrim())
        assert reader.GetShaderId() == "UsdPrimvarReader_float3"
        assert reader.GetInput("varname").Get() == "displayColor"


def test_colours_and_back() -> None:
    values = np.linspace(0.0, 1.0, 101)
    assert linear_to_srgb(srgb_to_linear(values)) == pytest.approx(values, abs=1e-6)
    assert srgb_to_linear([0.0, 0.5, 1.0]) == pytest.approx([0.0, 0.21404, 1.0], abs=1e-5)


def test_walls_before_the_water_are_guides(tmp_path: Path) -> None:
    """Of a tank the front and the right side are towards the camera; the other walls and a step stay."""
    l0 = 0.05
    water = Fluid(name="water", shape=Box((0.2, 0.3, 0.4), center=(-0.2, 0.15, 0.0)), spacing=l0)
    boxes = {
        "floor": ((0.8, 0.1, 0.6), (0.0, -0.05, 0.0)),
        "left": ((0.1, 0.5, 0.6), (-0.45, 0.25, 0.0)),
        "right": ((0.1, 0.5, 0.6), (0.45, 0.25, 0.0)),
        "back": ((0.8, 0.5, 0.1), (0.0, 0.25, -0.25)),
        "front": ((0.8, 0.5, 0.1), (0.0, 0.25, 0.25)),
        "step": ((0.1, 0.05, 0.1), (0.2, 0.025, 0.0)),
    }
    walls = tuple(Wall(name=name, shape=Box(size, center=at), spacing=l0) for name, (size, at) in boxes.items())
    scene = Scene(fluids=(water,), walls=walls, dimension=3, duration=1.0)
    particles = fill_scene(scene)
    assert occluding_walls(particles, StageFrame(axes="xyz")) == ["right", "front"]
    assert occluding_walls(particles, StageFrame(axes="xyz", up_axis="Z")) != ["right", "front"]
    AnimationWriter(tmp_path / "run.usdc", particles, scene.frame, frame_rate=1.0, provenance={}).write(
        0.0, particles.positions, particles.velocities
    )
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    purposes = {name: UsdGeom.Imageable(stage.GetPrimAtPath(f"/Result/{name}")).ComputePurpose() for name in boxes}
    assert [name for name, purpose in purposes.items() if purpose == "guide"] == ["right", "front"]


def test_hidden_share() -> None:
    grid = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), axis=-1).reshape(-1, 2)
    content = np.column_stack([grid, np.zeros(100)])
    nearer = np.array([0.0, 0.0, 1.0])
    assert hidden_share(content[:30] + nearer, content, 1.0) == pytest.approx(0.3)
    assert hidden_share(content[:30] - nearer, content, 1.0) == 0.0

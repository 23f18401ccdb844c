"""Animations: contents of the file and its readability while it grows, continuation, refusals."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from tests.observers.views import blocks
from tests.usd.animation.other_process import frames_seen_by_another_process
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.scene import StageFrame
from warp_mps.usd.animation import points_file as points
from warp_mps.usd.animation.local_origin import local_origin
from warp_mps.usd.animation.writer import AnimationWriter

PLANE = StageFrame(axes="xz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=0.001)
PROVENANCE = {"case": "blocks", "steps": 12, "time_step": 1e-4}
BODIES = ("left", "right")


def writer(path: Path, particles: Particles, frame: StageFrame = PLANE, rate: float = 200.0) -> AnimationWriter:
    return AnimationWriter(path, particles, frame, frame_rate=rate, provenance=PROVENANCE, primvars=("pressure",))


def resumed(path: Path, particles: Particles, after: float) -> AnimationWriter:
    return AnimationWriter.resume(
        path, particles, PLANE, frame_rate=200.0, provenance=PROVENANCE, primvars=("pressure",), after=after
    )


def write(animation: AnimationWriter, particles: Particles, *frames: int, rate: float = 200.0) -> None:
    """Frame k: moved by 0.1 k along the scene's second axis, with velocity k and the pressure k."""
    for k in frames:
        moved = particles.positions.copy()
        moved[:, 1] += 0.1 * k
        velocities = np.full_like(moved, k)
        animation.write(k / rate, moved, velocities, pressure=np.full(particles.count, float(k)))


def body(stage: Usd.Stage, name: str) -> UsdGeom.Points:
    return UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}"))


@pytest.fixture
def particles() -> Particles:
    return fill_scene(blocks())


@pytest.fixture
def stage(tmp_path: Path, particles: Particles) -> Usd.Stage:
    animation = writer(tmp_path / "run.usdc", particles)
    write(animation, particles, 0, 1, 2)
    animation.close()
    return Usd.Stage.Open(str(tmp_path / "run.usdc"))


def test_stage_metadata(stage: Usd.Stage) -> None:
    assert stage.GetDefaultPrim().GetPath() == "/Result"
    assert [str(prim.GetPath()) for prim in stage.GetDefaultPrim().GetChildren()] == ["/Result/left", "/Result/right"]
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 0.001
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetRootLayer().customLayerData == PROVENANCE


def test_a_second_of_stage_time_is_a_second_of_the_simulation(stage: Usd.Stage) -> None:
    assert stage.GetTimeCodesPerSecond() == 200.0
    assert stage.GetFramesPerSecond() == 30.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, 2.0)
    for name in BODIES:
        for attribute in (body(stage, name).GetPointsAttr(), body(stage, name).GetVelocitiesAttr()):
            assert attribute.GetTimeSamples() == [0.0, 1.0, 2.0]


def test_points_and_velocities_are_in_the_stages_axes_and_units(stage: Usd.Stage, particles: Particles) -> None:
    for name, (first, last) in zip(BODIES, particles.ranges, strict=True):
        points = np.asarray(body(stage, name).GetPointsAttr().Get(2.0))
        assert points.shape == (last - first, 3)
        expected = 100.0 * (particles.positions[first:last] + np.array([0.0, 0.2]))
        assert points[:, [0, 2]] == pytest.approx(expected, rel=1e-6)
        assert (points[:, 1] == 0.0).all()
        velocities = np.asarray(body(stage, name).GetVelocitiesAttr().Get(2.0))
        assert np.array_equal(velocities, np.tile([200.0, 0.0, 200.0], (last - first, 1)))


def test_quantities_written_once(stage: Usd.Stage, particles: Particles) -> None:
    colours = []
    for name, (first, last) in zip(BODIES, particles.ranges, strict=True):
        points = body(stage, name)
        assert list(points.GetIdsAttr().Get()) == particles.ids[first:last].tolist()
        assert np.asarray(points.GetWidthsAttr().Get()) == pytest.approx(np.full(last - first, 10.0))
        assert points.GetWidthsInterpolation() == "vertex"
        for attribute in (points.GetIdsAttr(), points.GetWidthsAttr()):
            assert attribute.GetNumTimeSamples() == 0
        assert points.GetDisplayColorPrimvar().GetInterpolation() == "constant"
        colours.append(tuple(points.GetDisplayColorAttr().Get()[0]))
    assert colours[0] != colours[1]


def test_extents_enclose_the_widths_in_every_frame(stage: Usd.Stage) -> None:
    for name in BODIES:
        points = body(stage, name)
        for code in (0.0, 1.0, 2.0):
            values = points.GetPointsAttr().Get(code), points.GetWidthsAttr().Get()
            expected = np.asarray(UsdGeom.Points.ComputeExtent(*values))
            assert np.asarray(points.GetExtentAttr().Get(code)) == pytest.approx(expected, rel=1e-6)


def test_primvars_vary_by_particle_and_frame(stage: Usd.Stage, particles: Particles) -> None:
    pressure = UsdGeom.PrimvarsAPI(body(stage, "right")).GetPrimvar("pressure")
    first, last = particles.ranges[1]
    assert pressure.GetInterpolation() == "vertex"
    assert pressure.GetTypeName() == "float[]"
    assert list(pressure.Get(2.0)) == [2.0] * int(last - first)


def test_the_file_is_valid(stage: Usd.Stage) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    errors = validation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in errors] == []


def test_three_dimensions_and_vector_primvars(tmp_path: Path) -> None:
    particles = fill_scene(blocks(3))
    frame = StageFrame(axes="xyz")
    with_spin = AnimationWriter(
        tmp_path / "run.usdc", particles, frame, frame_rate=10.0, provenance={}, primvars=("force",)
    )
    with_spin.write(0.25, particles.positions, particles.velocities, force=particles.positions)
    with_spin.close()
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    points = body(stage, "right")
    assert points.GetPointsAttr().GetTimeSamples() == [2.5]
    assert stage.GetFramesPerSecond() == 10.0
    force = UsdGeom.PrimvarsAPI(points).GetPrimvar("force")
    assert force.GetTypeName() == "vector3f[]"
    first, last = particles.ranges[1]
    assert np.asarray(force.Get(2.5)) == pytest.approx(particles.positions[first:last], rel=1e-6)


def test_a_body_of_one_particle_has_the_extent_of_its_width(tmp_path: Path, particles: Particles) -> None:
    fields = ("positions", "velocities", "angular_velocities", "masses", "spacings", "bodies", "groups", "ids")
    one = {name: getattr(particles, name)[:1] for name in fields}
    single = dataclasses.replace(particles, names=("left",), ranges=np.array([[0, 1]]), **one)
    animation = writer(tmp_path / "run.usdc", single)
    write(animation, single, 0)
    animation.close()
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    low, high = np.asarray(body(stage, "left").GetExtentAttr().Get(0.0))
    assert high - low == pytest.approx([10.0, 10.0, 10.0])


def test_every_frame_is_readable_as_soon_as_it_is_written(tmp_path: Path, particles: Particles) -> None:
    path = tmp_path / "run.usdc"
    animation = writer(path, particles)
    assert not path.exists()
    for k in range(4):
        write(animation, particles, k)
        assert frames_seen_by_another_process(path) == k + 1
    animation.close()
    assert [item.name for item in tmp_path.iterdir()] == ["run.usdc"]


@pytest.mark.parametrize("fails", [False, True])
def test_a_file_of_many_frames_holds_little_else(
    tmp_path: Path, particles: Particles, monkeypatch: pytest.MonkeyPatch, fails: bool
) -> None:
    """Every save leaves tables behind that are as long as the animation; where they cannot be dropped, nothing is."""
    frames, path = range(250), tmp_path / "run.usdc"
    monkeypatch.setattr(points, "LEAST_WASTE", 2**12)
    if fails:
        replace = os.replace

        def refuse(source: str, target: str) -> None:
            if str(source).endswith(".whole.usdc"):
                raise OSError("in use")
            replace(source, target)

        monkeypatch.setattr(os, "replace", refuse)
    animation = writer(path, particles)
    write(animation, particles, *frames)
    animation.close()
    assert [item.name for item in tmp_path.iterdir()] == ["run.usdc"]
    stage = Usd.Stage.Open(str(path))
    stage.GetRootLayer().Export(str(tmp_path / "whole.usdc"))
    size = path.stat().st_size / (tmp_path / "whole.usdc").stat().st_size
    assert size > 4.0 if fails else size < 2.5
    shown = body(stage, "left")
    assert shown.GetPointsAttr().GetTimeSamples() == list(frames)
    for k in frames:
        assert np.asarray(shown.GetVelocitiesAttr().Get(k))[0, 0] == pytest.approx(100.0 * k)
        assert np.asarray(UsdGeom.PrimvarsAPI(shown).GetPrimvar("pressure").Get(k))[0] == k


def test_without_hard_links_the_file_is_copied(
    tmp_path: Path, particles: Particles, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError("not supported")

    monkeypatch.setattr(os, "link", refuse)
    animation = writer(tmp_path / "run.usdc", particles)
    write(animation, particles, 0, 1, 2)
    animation.close()
    assert frames_seen_by_another_process(tmp_path / "run.usdc") == 3


def test_resuming_drops_later_frames_and_continues(tmp_path: Path, particles: Particles) -> None:
    path = tmp_path / "run.usdc"
    animation = writer(path, particles)
    write(animation, particles, 0, 1, 2, 3)
    animation.close()
    animation = resumed(path, particles, after=1 / 200.0)
    assert frames_seen_by_another_process(path) == 2
    write(animation, particles, 2)
    animation.close()
    stage = Usd.Stage.Open(str(path))
    assert body(stage, "left").GetPointsAttr().GetTimeSamples() == [0.0, 1.0, 2.0]
    assert UsdGeom.PrimvarsAPI(body(stage, "left")).GetPrimvar("pressure").GetTimeSamples() == [0.0, 1.0, 2.0]
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, 2.0)


@pytest.mark.parametrize("after", [0.0, 0.25, 4.0])
def test_resuming_after_a_frame_that_is_not_there_is_refused(
    tmp_path: Path, particles: Particles, after: float
) -> None:
    """Else the animation would have a gap."""
    animation = writer(tmp_path / "run.usdc", particles)
    write(animation, particles, 2, 3)
    animation.close()
    before = (tmp_path / "run.usdc").read_bytes()
    with pytest.raises(InputError, match="lacks the frame at time code"):
        resumed(tmp_path / "run.usdc", particles, after=after)
    assert (tmp_path / "run.usdc").read_bytes() == before


def test_what_cannot_be_resumed_is_refused(tmp_path: Path, particles: Particles) -> None:
    with pytest.raises(InputError, match="missing"):
        resumed(tmp_path / "run.usdc", particles, after=0.0)
    (tmp_path / "run.usdc").write_bytes(b"not a stage")
    with pytest.raises(InputError, match="not a result"):
        resumed(tmp_path / "run.usdc", particles, after=0.0)
    other = dataclasses.replace(particles, ids=particles.ids[::-1].copy())
    animation = writer(tmp_path / "other.usdc", other)
    write(animation, other, 0)
    animation.close()
    with pytest.raises(InputError, match="other particles"):
        resumed(tmp_path / "other.usdc", particles, after=0.0)


def test_other_formats_and_primvars_are_refused(tmp_path: Path, particles: Particles) -> None:
    with pytest.raises(InputError, match=r"\.usdc"):
        writer(tmp_path / "run.usda", particles)
    animation = writer(tmp_path / "run.usdc", particles)
    with pytest.raises(ValueError, match="pressure"):
        animation.write(0.0, particles.positions, particles.velocities)


def test_a_file_that_is_open_shows_the_frames_of_the_run_that_replaced_it(tmp_path: Path, particles: Particles) -> None:
    path = tmp_path / "run.usdc"
    opened = []
    for frames in ((0,), (0, 1, 2)):
        animation = writer(path, particles)
        write(animation, particles, *frames)
        animation.close()
        opened.append(Usd.Stage.Open(str(path)))
        assert body(opened[-1], "left").GetPointsAttr().GetNumTimeSamples() == len(frames)
    assert body(opened[0], "left").GetPointsAttr().GetNumTimeSamples() == 3


FAR = np.array([450_000.0, 5_000_000.0])


def test_a_scene_far_from_the_origin_has_a_local_one(tmp_path: Path) -> None:
    """Single precision leaves 0.5 m of points that are 5000 km away; relative to a local origin it is 1e-9 m."""
    near = fill_scene(blocks())
    far = dataclasses.replace(near, positions=near.positions + FAR)
    animation = writer(tmp_path / "far.usdc", far)
    write(animation, far, 0, 1)
    animation.close()
    stage = Usd.Stage.Open(str(tmp_path / "far.usdc"))
    for name, (first, last) in zip(near.names, near.ranges, strict=True):
        prim = UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}"))
        local = np.array(prim.GetPointsAttr().Get(0.0), float)
        place = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0.0))[3, :3]
        world = (local + place) * PLANE.meters_per_unit
        np.testing.assert_allclose(world[:, [0, 2]], far.positions[first:last], rtol=0.0, atol=1e-8)
        assert len(np.unique(local[:, 0])) == len(np.unique(near.positions[first:last, 0].round(9)))
        box = np.array(prim.GetExtentAttr().Get(0.0))
        assert (box[0] < local.min(axis=0) + 1e-6).all()
        assert (box[1] > local.max(axis=0) - 1e-6).all()
    # the camera looks at the middle of what there is
    camera = UsdGeom.Xformable(stage.GetPrimAtPath("/Scenery/Camera")).ComputeLocalToWorldTransform(0.0)
    middle = far.positions.mean(axis=0) / PLANE.meters_per_unit
    np.testing.assert_allclose(np.array(camera)[3, [0, 2]], middle, rtol=0.0, atol=20.0)


def test_a_far_animation_is_continued(tmp_path: Path) -> None:
    near = fill_scene(blocks())
    far = dataclasses.replace(near, positions=near.positions + FAR)
    animation = writer(tmp_path / "far.usdc", far)
    write(animation, far, 0, 1, 2)
    animation.close()
    whole = Sdf.Layer.OpenAsAnonymous(str(tmp_path / "far.usdc")).ExportToString()
    again = resumed(tmp_path / "far.usdc", far, 0.005)
    write(again, far, 2)
    again.close()
    assert Sdf.Layer.OpenAsAnonymous(str(tmp_path / "far.usdc")).ExportToString() == whole


def test_scenes_near_the_origin_keep_the_stages_coordinates() -> None:
    near = fill_scene(blocks())
    for far in (0.0, 3.0, 40.0):
        moved = dataclasses.replace(near, positions=near.positions + far)
        assert not local_origin(moved, PLANE).any()
    assert local_origin(dataclasses.replace(near, positions=near.positions + 1e4), PLANE)[[0, 2]].any()

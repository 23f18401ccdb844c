"""Recording of the animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.observers.views import blocks, view_of
from warp_mps.observers.frames import FrameRecorder
from warp_mps.scene import OUTPUTS, StageFrame


def test_frames_hold_the_view_and_resume(tmp_path: Path) -> None:
    view = view_of(blocks(frame_rate=10.0))
    path = tmp_path / "run.usdc"
    for resume, times in ((None, (0.0, 0.1, 0.2, 0.3)), (0.1, (0.2,))):
        recorder = FrameRecorder(
            path, view.scene, view.particles, every=5, provenance={"case": "blocks"}, resume_after=resume
        )
        assert recorder.every == 5
        for view.time in times:
            view.displacements[:] = view.time
            view.pressures[:] = 100.0 * view.time
            recorder.observe(view)
        recorder.close()
    stage = Usd.Stage.Open(str(path))
    points = UsdGeom.Points(stage.GetPrimAtPath("/Result/left"))
    assert points.GetPointsAttr().GetTimeSamples() == [0.0, 1.0, 2.0]
    first, last = view.particles.ranges[0]
    moved = np.asarray(points.GetPointsAttr().Get(2.0))[:, :2]
    assert moved == pytest.approx(view.particles.positions[first:last] + 0.2, abs=1e-6)
    pressure = UsdGeom.PrimvarsAPI(points).GetPrimvar("pressure").Get(1.0)
    assert np.asarray(pressure) == pytest.approx(10.0)
    assert not UsdGeom.PrimvarsAPI(points).HasPrimvar("stress")


def test_outputs_are_primvars_along_the_axes_of_the_stage(tmp_path: Path) -> None:
    frame = StageFrame(axes="xz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=0.001)
    view = view_of(blocks(frame_rate=10.0, outputs=OUTPUTS, stage=frame))
    rng = np.random.default_rng(1)
    view.stresses, view.strains = rng.normal(size=(2, view.particles.count, 3, 3))
    view.von_mises, view.strain_energy_densities = rng.uniform(size=(2, view.particles.count))
    recorder = FrameRecorder(tmp_path / "run.usdc", view.scene, view.particles, every=1, provenance={})
    recorder.observe(view)
    recorder.close()
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    first, last = view.particles.ranges[1]
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Result/right"))
    # the scene's axes are the stage's x, z and, across the plane, y
    order = np.ix_([0, 2, 1], [0, 2, 1])
    for name, values in (("stress", view.stresses), ("strain", view.strains)):
        primvar = primvars.GetPrimvar(name)
        assert (primvar.GetTypeName(), primvar.GetInterpolation()) == ("matrix3d[]", "vertex")
        expected = np.array([value[order] for value in values[first:last]])
        np.testing.assert_array_equal(np.asarray(primvar.Get(0.0)), expected)
    for name, values in (("von_mises", view.von_mises), ("strain_energy", view.strain_energy_densities)):
        primvar = primvars.GetPrimvar(name)
        assert (primvar.GetTypeName(), primvar.GetInterpolation()) == ("float[]", "vertex")
        assert np.asarray(primvar.Get(0.0)) == pytest.approx(values[first:last])

"""Recording of the animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.observers.views import blocks, view_of
from warp_mps.observers.frames import FrameRecorder


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

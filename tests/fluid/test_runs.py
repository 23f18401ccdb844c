"""Runs of fluids in a folder."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.fluid.scenes import scene_of, tank, water
from warp_mps.app.cli import main
from warp_mps.errors import RunError
from warp_mps.fluid import fluids as fluids_module
from warp_mps.fluid import time_loop
from warp_mps.results.summary import read_summary
from warp_mps.run.run import run_scene
from warp_mps.scene import Flow, HarmonicMotion, Probe, Scene
from warp_mps.usd.case.save import save_stage


@pytest.fixture
def scene() -> Scene:
    """A column that falls over in a shaken tank; frames every 20 ms, rows every 10 ms."""
    return tank(
        (6, 10),
        room=(12, 12),
        wall={"motion": HarmonicMotion(amplitude=(0.01, 0.0), frequency=3.0)},
        probes=(Probe(name="force", quantity="contact_force", body="x_low"),),
        duration=0.12,
        frame_rate=50.0,
        sample_rate=100.0,
        name="splash",
    )


def frames(folder: Path, name: str) -> dict[float, np.ndarray]:
    """An attribute of the water in every frame, by time code."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(folder / "run.usdc"))
    attribute = stage.GetPrimAtPath("/Result/water").GetAttribute(name)
    return {code: np.array(attribute.Get(code)) for code in attribute.GetTimeSamples()}


def test_water_that_fills_its_walls_is_remarked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It pulls at the lid; what it may do, and how much room it has, decide, and the remark changes nothing."""
    shut = tank((6, 6), lid=True, duration=0.01)
    for scene, remarked in (
        (shut, ["needs negative pressures, and they are 'clipped'", "the scheme 'conservative' stirs"]),
        (replace(shut, flow=Flow(negative_pressure="allowed")), ["the scheme 'conservative' stirs"]),
        (replace(shut, flow=Flow(negative_pressure="allowed", scheme="corrected")), []),
        (tank((6, 6), room=(6, 7), lid=True, duration=0.01), []),
    ):
        run_scene(scene, tmp_path / "said", overwrite=True)
        lines = [
            line for line in capsys.readouterr().err.splitlines() if line.startswith("warp-mps: no free surface: ")
        ]
        assert len(lines) == len(remarked)
        assert all(part in line for part, line in zip(remarked, lines, strict=True))
        run_scene(scene, tmp_path / "quiet", quiet=True, overwrite=True)
        assert (tmp_path / "said" / "probes.csv").read_text() == (tmp_path / "quiet" / "probes.csv").read_text()


@pytest.mark.parametrize("first", [0.06, 0.05])
def test_a_run_in_two_parts_is_the_run_in_one(
    scene: Scene, tmp_path: Path, first: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the first part ends between two frames."""
    monkeypatch.setattr(time_loop, "SORT_EVERY", 10)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    summary = run_scene(scene, whole, quiet=True)
    run_scene(replace(scene, duration=first), parts, quiet=True)
    resumed = run_scene(scene, parts, quiet=True, resume=True)
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    for name in ("points", "velocities", "primvars:pressure"):
        one, two = frames(whole, name), frames(parts, name)
        assert len(one) == 7
        assert one.keys() == two.keys()
        for code, values in one.items():
            np.testing.assert_array_equal(values, two[code], err_msg=f"{name} {code}")
    assert (resumed.steps, resumed.time, resumed.energy) == (summary.steps, summary.time, summary.energy)
    assert (resumed.fluid, resumed.momentum_error) == (summary.fluid, summary.momentum_error)
    assert summary.fluid["pressure_iterations"] > 0
    assert summary.fluid["unsolved"] == 0
    assert summary.fluid["lost"] == 0
    assert summary.momentum_error < 1e-10


def test_a_leak_is_a_failed_run_that_says_how_much_was_lost(tmp_path: Path) -> None:
    flow = Flow(domain=([-0.3, -0.2], [0.3, 0.5]))
    scene = scene_of(water([0.0, 0.0], [0.1, 0.1]), gravity=(0.0, -9.81), flow=flow, duration=1.0)
    with pytest.raises(RunError, match="at its low y end"):
        run_scene(scene, tmp_path, quiet=True)
    summary = read_summary(tmp_path / "run.json")
    assert summary.status == "failed"
    assert re.search("have left the domain: .* at its low y end, as particle 0 of body 'water'", summary.reason)
    assert summary.reason.endswith("give flow.domain (mps:domainLow, mps:domainHigh) more room there")
    assert any("left the domain at its low y end" in line for line in summary.remarks)
    assert summary.fluid["lost"] == int(summary.reason.split(" of ")[0].split()[-1])


def test_a_leak_has_its_exit_code(tmp_path: Path) -> None:
    flow = Flow(domain=([-0.3, -0.2], [0.3, 0.5]))
    scene = scene_of(water([0.0, 0.0], [0.1, 0.1]), gravity=(0.0, -9.81), flow=flow, duration=1.0)
    save_stage(scene, tmp_path / "leak.usda")
    assert main(["run", str(tmp_path / "leak.usda"), "--out", str(tmp_path / "out"), "--quiet"]) == 3


def test_steps_that_collapse_have_its_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line says why, and the results so far are kept."""
    advance = fluids_module.Fluids.advance

    def kick(fluids: fluids_module.Fluids, time: float) -> int:
        """Advance; after 55 ms a particle is given a push before that."""
        if fluids.time > 0.055:
            u = fluids.state.u.numpy()
            u[-1] = [1e5, 0.0]
            fluids.state.u.assign(u)
        return advance(fluids, time)

    monkeypatch.setattr(fluids_module.Fluids, "advance", kick)
    save_stage(tank((6, 6), duration=0.2, frame_rate=100.0, name="still"), tmp_path / "still.usda")
    assert main(["run", str(tmp_path / "still.usda"), "--out", str(tmp_path / "out"), "--quiet"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert "runs away" in line
    summary = read_summary(tmp_path / "out" / "run.json")
    assert summary.status == "failed"
    assert "runs away" in summary.reason
    assert summary.time == pytest.approx(0.06)
    assert len(frames(tmp_path / "out", "points")) == 7

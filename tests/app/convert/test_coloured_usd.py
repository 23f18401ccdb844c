"""Animations with the colours of a quantity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.app.results import SPACE, write_result
from warp_mps.app.animation_reader import Animation
from warp_mps.app.cli import main
from warp_mps.app.view.colours import choose_colouring
from warp_mps.usd.animation.colours import linear_to_srgb


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_result(tmp_path, frame=SPACE)
    return tmp_path


def test_colours_are_those_of_the_values_in_every_frame(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (folder / "run.usdc").read_bytes()
    assert main(["convert", str(folder), "--to", "usd", "--colour", "pressure", "--limits", "0", "2000"]) == 0
    assert "displayColor is the pressure, from 0 to 2 kPa" in capsys.readouterr().out
    assert (folder / "run.usdc").read_bytes() == before
    stage = Usd.Stage.Open(str(folder / "run_pressure.usdc"))
    animation = Animation(folder)
    colouring = choose_colouring(animation, "pressure", (0.0, 2000.0))
    block, floor = (UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}")) for name in ("block", "floor"))
    assert block.GetDisplayColorPrimvar().GetInterpolation() == "vertex"
    for frame, code in enumerate(animation.codes):
        shown = linear_to_srgb(np.array(block.GetDisplayColorAttr().Get(code)))
        assert shown == pytest.approx(colouring.colors(animation, 0, frame), abs=1e-6)
        assert np.array_equal(block.GetPointsAttr().Get(code), animation.points(0, frame).astype(np.float32))
    assert len(np.unique(shown, axis=0)) > 10
    assert floor.GetDisplayColorPrimvar().GetInterpolation() == "constant"
    assert floor.GetDisplayColorAttr().GetNumTimeSamples() == 0
    data = stage.GetRootLayer().customLayerData
    assert (data["colours"], list(data["colours from and to [SI]"])) == ("pressure [kPa]", [0.0, 2000.0])
    assert data["case"] == "resting"


def test_the_file_is_valid(folder: Path) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    assert main(["convert", str(folder), "--to", "usd", "--colour", "speed"]) == 0
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    errors = validation.ValidationContext(validators).Validate(Usd.Stage.Open(str(folder / "run_speed.usdc")))
    assert [error.GetMessage() for error in errors] == []


def test_what_cannot_be_coloured_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refusal(*arguments: str) -> str:
        assert main(["convert", str(folder), *arguments]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "are for --to usd" in refusal("--colour", "pressure")
    assert "--colour: is heat, which is not in" in refusal("--to", "usd", "--colour", "heat")
    assert "--colour: is body, which is what run.usdc has" in refusal("--to", "usd", "--colour", "body")
    (folder / "run_speed.usdc").write_text("mine")
    assert "exists; use --overwrite" in refusal("--to", "usd", "--colour", "speed")
    assert sorted(path.name for path in folder.iterdir()) == ["run.usdc", "run_speed.usdc"]

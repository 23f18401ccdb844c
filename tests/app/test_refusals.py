"""Bad input on the command line: exit code 2, one clear line, and nothing left behind."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.usd.case.stages import write
from warp_mps.app.cli import main

SUPPORT = ("Cube", 'token mps:role = "support"', "double size = 0.1", "double3 xformOp:translate = (9, 9, 0)")
ORDER = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
PROBE = ("Xform", 'token mps:role = "probe"', "double3 xformOp:translate = (9, 9, 0)", ORDER)
TWIN = ("Cube", 'token mps:role = "body"', "double mps:spacing = 0.1", "rel material:binding:physics = </Steel>")


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that a refused command prints."""
    assert main(list(arguments)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({"Beam": ('token mps:role = "boddy"',)}, "/Beam mps:role: is 'boddy', must be one of: body, part, wall"),
        ({"Beam": ("double mps:spacing = -1",)}, "/Beam mps:spacing: is -1, must be finite and above 0"),
        ({"Beam": ("-mps:spacing",)}, "/Beam mps:spacing: is missing"),
        ({"Beam": ("double mps:spacing = 3",)}, "thinner than one particle"),
        ({"Beam": ("double mps:spacing = 1e-9",)}, "/Beam mps:spacing: 1e-09 m makes 1e+18 particles; the run needs"),
        ({"Steel": ("double mps:youngsModulus = inf",)}, "/Steel mps:youngsModulus: must be finite"),
        ({"Steel": ("double mps:poissonsRatio = 0.5",)}, "/Steel mps:poissonsRatio: is 0.5, must lie between -1 and"),
        ({"Steel": ("-physics:density",)}, "/Steel physics:density: is missing"),
        ({"Scene": ('token mps:elasticModel = "jelly"',)}, "/Scene mps:elasticModel: is 'jelly', must be one of:"),
        ({"Twin": (*TWIN, "double size = 0.5")}, "overlaps /Twin"),
        ({"Held": (*SUPPORT, ORDER)}, "/Held: the support holds no particle"),
        ({"Tip": PROBE}, "/Tip: (9, 9) m lies outside every body"),
    ],
)
def test_stages_that_cannot_be_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], parts: dict, expected: str
) -> None:
    out = tmp_path / "out"
    assert expected in refusal(capsys, "run", str(write(tmp_path, **parts)), "--out", str(out), "--quiet")
    assert not out.exists()


def test_check_refuses_what_does_not_fit_before_it_says_what_a_run_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = ("Cube", 'token mps:role = "part"', "double size = 0.1", "double3 xformOp:translate = (9, 9, 0)", ORDER)
    path = write(tmp_path, Core=(*part, "rel mps:body = </Beam>", "rel material:binding:physics = </Steel>"))
    assert "/Core: the part holds no particle of body 'Beam'" in refusal(capsys, "check", str(path))
    assert "/Tip: (9, 9) m lies outside every body" in refusal(capsys, "check", str(write(tmp_path, Tip=PROBE)))


def test_a_stage_without_a_scene_or_without_anything(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    empty = tmp_path / "empty.usda"
    empty.write_text("#usda 1.0\n")
    assert "no PhysicsScene prim" in refusal(capsys, "run", str(empty))
    no_scene = write(tmp_path, Scene=("-mps:duration",))
    no_scene.write_text(no_scene.read_text().replace("def PhysicsScene", "def Scope"))
    assert "no PhysicsScene prim" in refusal(capsys, "check", str(no_scene))


def test_files_that_are_no_stages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "there is no such file" in refusal(capsys, "run", str(tmp_path / "none.usda"))
    assert "is neither a file nor a shipped case; give the path" in refusal(capsys, "check", "none")
    assert "; did you mean dam_break?" in refusal(capsys, "check", "dam_brake")
    assert "is a folder; give the path of a stage" in refusal(capsys, "check", str(tmp_path))
    text = tmp_path / "text.usda"
    text.write_text("not a stage")
    assert "is not a USD stage" in refusal(capsys, "run", str(text))


def test_output_folders_that_cannot_be_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stage = str(write(tmp_path, Scene=("double mps:duration = 1e-5",)))
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert "is a file; the output must be a folder" in refusal(capsys, "run", stage, "--out", str(blocked))
    assert "file is a file" in refusal(capsys, "run", stage, "--out", str(blocked / "below"), "--quiet")
    out = str(tmp_path / "out")
    assert main(["run", stage, "--out", out, "--quiet"]) == 0
    before = {path.name: path.read_bytes() for path in Path(out).iterdir()}
    capsys.readouterr()
    assert "use --overwrite to replace or --resume to continue" in refusal(capsys, "run", stage, "--out", out)
    assert {path.name: path.read_bytes() for path in Path(out).iterdir()} == before
    both = ("--overwrite", "--resume")
    assert "not both" in refusal(capsys, "run", stage, "--out", out, *both)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--set", "spacing=1"), "must be /Prim.attribute=value"),
        (("--set", "/Beam.mps:spacing=thin"), "/Beam mps:spacing: 'thin' is not of type double"),
        (("--set", "/Nobody.mps:spacing=1"), "/Nobody"),
        (("--set", "/Beam.mps:spacin=1"), "/Beam mps:spacin: cannot be set: there is no such attribute; did you mean"),
        (("--set", "/Scene.mps:outputs=stress"), '\'stress\' is not of type token[], such as ["a", "b"]'),
        (("--set", "/Scene.physics:gravityDirection=1,0"), "is not of type vector3f, such as (1, 0, 0)"),
        (("--device", "cuda:99"), "device: 'cuda:99' is not available, must be one of: cpu"),
        (("--device", "gpu"), "device: 'gpu' is not available, must be one of: cpu"),
        (("--threads", "0"), "threads: is 0, must be a whole number of 1 or more"),
        (("--duration", "-1"), "/Scene mps:duration: is -1, must be finite and above 0"),
        (("--resume",), "checkpoint"),
    ],
)
def test_options_that_mean_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], expected: str
) -> None:
    out = tmp_path / "out"
    line = refusal(capsys, "run", str(write(tmp_path)), "--out", str(out), "--quiet", *options)
    assert expected in line
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("nothing",), "Unrecognized options: nothing"),
        ((), "Expected one of {list, check, run"),
        (("check",), "Missing from warp-mps check: CASE"),
        (("check", "beam_first_mode", "--duration", "a"), "--duration: is 'a', must be a number;"),
        (("run", "beam_first_mode", "--threads", "a"), "--threads: is 'a', must be a whole number;"),
        (("picture", "DIR", "--size", "a", "2"), "--size: is 'a' '2', must be 2 whole numbers;"),
        (("run", "beam_first_mode", "--precison", "float32"), "did you mean --precision?"),
        (("run", "beam_first_mode", "--threads"), "Missing value for argument '--threads'"),
        (("convert", "DIR", "--to", "nonsense"), "'nonsense' for argument '--to'. Expected one of ('pvd'"),
    ],
)
def test_command_lines_that_cannot_be_understood(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], expected: str
) -> None:
    line = refusal(capsys, *arguments)
    assert re.match("warp-mps: (--)?[A-Za-z]", line)
    assert expected in line
    assert not re.search("----|\u2500|\u2502", line)
    assert line.endswith("; see warp-mps --help\n")

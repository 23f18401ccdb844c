"""The commands: what they print and leave behind."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.usd.case.stages import write
from warp_mps.app import cli
from warp_mps.app.bench import coupling as bench_coupling
from warp_mps.app.bench import solids as bench_solids
from warp_mps.app.cli import COMMANDS, main
from warp_mps.results.history import read_history
from warp_mps.scene import Fluid, Material, Probe, Scene, choices
from warp_mps.shapes import Box
from warp_mps.usd.case.save import save_stage
from warp_mps.usd.shipped_cases import shipped_cases

SHAKEN = {"Beam": ("double3 mps:velocity = (1, 0, 0)",), "Tip": ("Xform", 'token mps:role = "probe"')}

WAVE = (
    'token mps:velocityField = "sine"',
    "double3 mps:velocityField:amplitude = (0, 1, 0)",
    "double3 mps:velocityField:axis = (1, 0, 0)",
    "double3 mps:velocityField:origin = (0, 0, 0)",
    "double mps:velocityField:length = 1",
)


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from warp_mps.app.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "print([m for m in ('warp', 'pxr', 'matplotlib', 'numpy') if m in sys.modules], file=sys.stderr)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stderr.strip() == "[]"
    for command in COMMANDS:
        assert command in result.stdout


@pytest.mark.parametrize("given", [None, "3"])
def test_numpy_has_one_thread_unless_another_number_is_given(given: str | None) -> None:
    code = (
        "import os, sys; from warp_mps.__main__ import main\n"
        "assert 'numpy' not in sys.modules\n"
        "sys.argv = ['warp-mps', '--version']\n"
        "main()\n"
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    if given is not None:
        environment["OPENBLAS_NUM_THREADS"] = given
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert result.stdout.split()[-1] == (given or "1")


def test_words_of_options_are_those_of_a_scene() -> None:
    assert cli.PrecisionName == choices.PrecisionName
    assert cli.ElasticModelName == choices.ElasticModelName


def test_list_names_every_shipped_case(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    assert [line.split()[0] for line in lines] == list(shipped_cases())
    assert all(len(line.split()) > 3 for line in lines), "every case says what it is"


def test_check_says_what_a_run_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(write(tmp_path)), "--set", "/Beam.mps:spacing=0.05"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"body Beam +/Beam *\n", text)
    assert re.search(r"particles +400 of 0.05 m", text)
    assert "steps, frames" in text
    assert main(["check", str(write(tmp_path)), "--set", "/Scene.mps:timeStep=1"]) == 0
    assert "ABOVE THE LIMIT" in capsys.readouterr().out


def test_check_shows_what_a_body_of_several_materials_is_made_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A quarter of a square of 1 m is half as dense."""
    core = ("Cube", 'token mps:role = "part"', "rel mps:body = </Beam>", "rel material:binding:physics = </Steel>")
    core += ("double size = 0.5", "float physics:density = 3900")
    assert main(["check", str(write(tmp_path, Core=core)), "--set", "/Beam.mps:spacing=0.05"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"of Beam +300 particles, 5850 kg/m", text)
    assert re.search(r"of Core +100 particles, 975 kg/m", text)


def test_fluids_are_checked_and_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A falling drop: what it lacks is remarked, and what is said of the run is not the energy of a body."""
    drop = Fluid(name="drop", shape=Box((0.1, 0.1)), spacing=0.01)
    stage, out = str(tmp_path / "drop.usda"), tmp_path / "out"
    probe = Probe(name="drop", body="drop", quantity="volume")
    save_stage(Scene(fluids=(drop,), probes=(probe,), gravity=(0.0, -9.81), duration=0.02), stage)
    assert main(["check", stage]) == 0
    text = capsys.readouterr().out
    assert "2-D, dynamic, fluid scheme conservative" in text
    assert "longest time step" in text
    assert "no walls: nothing holds the fluid" in text
    assert "no gravity" not in text
    assert main(["run", stage, "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert "warp-mps: no walls: nothing holds the fluid" in captured.err
    assert "iterations a pressure solve" in captured.out
    assert "energy drift" not in captured.out
    assert "UNSOLVED" not in captured.out
    assert read_history(out / "probes.csv").probe("drop")[-1] == pytest.approx(0.01, rel=0.02)


def test_check_says_how_much_of_a_fluid_gives_way(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A square of 30 x 30 particles of water about one of 10 x 10."""
    water = ("Cube", 'token mps:role = "fluid"', "double mps:spacing = 0.1", "double size = 3")
    assert main(["check", str(write(tmp_path, Water=water))]) == 0
    text = capsys.readouterr().out
    assert re.search(r"particles +800 of 0.1 m", text)
    assert "Water: 100 particles give way to Beam, which it was drawn into" in text


def test_a_shorter_run_leaves_out_what_comes_later(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "dam_break_elastic_gate", "--duration", "0.1"]) == 0
    line = capsys.readouterr().err
    assert line.startswith("warp-mps: not measured, because the run ends at 0.1 s: farthest shift of the free end, ")
    assert "shift at 0.12 s, shift at 0.20 s" in line
    assert "0.08" not in line
    assert line.endswith("volume at the end\n")
    assert main(["check", "dam_break_elastic_gate", "--duration", "0.4"]) == 0
    assert capsys.readouterr().err == ""


def test_run_leaves_its_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    stage = str(write(tmp_path, Scene=("double mps:duration = 1e-3", "double mps:frameRate = 5000"), **SHAKEN))
    assert main(["run", stage, "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert f"results in {out}" in captured.out
    assert "done" in captured.err
    assert sorted(path.name for path in out.iterdir()) == ["checkpoint.npz", "probes.csv", "run.json", "run.usdc"]
    summary = json.loads((out / "run.json").read_text())
    assert summary["status"] == "done"
    assert summary["particles"] == {"Beam": 100}
    assert summary["time"] == pytest.approx(1e-3)
    history = read_history(out / "probes.csv")
    assert history.times == pytest.approx(np.arange(6) * 2e-4)
    assert history.probe("Tip") == pytest.approx(history.times)


def test_resume_continues_to_the_same_rows_and_frames(tmp_path: Path) -> None:
    scene = ("double mps:duration = 1e-3", "double mps:frameRate = 5000")
    stage = str(write(tmp_path, Scene=scene, Beam=WAVE, Tip=SHAKEN["Tip"]))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert main(["run", stage, "--out", str(whole), "--quiet"]) == 0
    assert main(["run", stage, "--out", str(parts), "--quiet", "--duration", "6e-4"]) == 0
    assert main(["run", stage, "--out", str(parts), "--quiet", "--resume"]) == 0
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    assert frames(whole).keys() == frames(parts).keys()
    for code, points in frames(whole).items():
        assert np.array_equal(points, frames(parts)[code])


def frames(folder: Path) -> dict[float, np.ndarray]:
    """Points of every frame of a result, by time code."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(folder / "run.usdc"))
    points = stage.GetPrimAtPath("/Result/Beam").GetAttribute("points")
    return {code: np.array(points.Get(code)) for code in points.GetTimeSamples()}


def test_a_run_that_becomes_unstable_stops_and_keeps_what_was_good(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    scene = ("double mps:duration = 1", "double mps:frameRate = 20000", "double mps:timeStep = 2e-5")
    stage = write(tmp_path, Scene=scene, Beam=WAVE)
    assert main(["run", str(stage), "--out", str(out), "--quiet"]) == 3
    warning, line = capsys.readouterr().err.splitlines()
    assert "above the limit" in warning
    assert "particle" in line
    assert "time step" in line
    summary = json.loads((out / "run.json").read_text())
    assert summary["status"] == "failed"
    assert summary["reason"] in line
    assert all(np.abs(points).max() < 1.0 for points in frames(out).values())
    assert (out / "checkpoint.npz").exists()


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_ends_cleanly(tmp_path: Path) -> None:
    out = tmp_path / "out"
    scene = ("double mps:duration = 1000", "double mps:frameRate = 1000")
    arguments = [sys.executable, "-m", "warp_mps", "run", str(write(tmp_path, Scene=scene, **SHAKEN))]
    process = subprocess.Popen([*arguments, "--out", str(out)], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 300.0
    while not (out / "probes.csv").exists() or len((out / "probes.csv").read_text().splitlines()) < 4:
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "interrupted; the results so far are kept" in errors.splitlines()[-1]
    assert "Traceback" not in errors
    summary = json.loads((out / "run.json").read_text())
    assert summary["status"] == "failed"
    assert summary["reason"].startswith("interrupted")
    assert (out / "checkpoint.npz").exists()
    assert read_history(out / "probes.csv").last_time > 0.0


@pytest.mark.long
def test_bench_prints_speeds_and_shares(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_solids, "ROUND_SECONDS", 0.02)
    options = ["--sizes", "100", "--of", "elastic", "--dimensions", "2", "--precisions", "float64"]
    assert main(["bench", *options]) == 0
    text = capsys.readouterr().out
    assert "particle-step" in text
    for model, kernel in (("hamiltonian", "stress"), ("springs", "pressure")):
        (line,) = (line for line in text.splitlines() if model in line)
        assert kernel in line
        assert "force" in line


@pytest.mark.parametrize(("dimension", "size", "count"), [(2, 60, "64"), (3, 200, "216")])
def test_bench_of_coupling_prints_speeds_and_shares(
    dimension: int, size: int, count: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    for name, value in {"INTERVAL": 2.0, "MEASURED": 1, "PLATE": Material(500.0, 5e7, 0.3)}.items():
        monkeypatch.setattr(bench_coupling, name, value)
    options = ["--sizes", f"{size}", "--of", "coupling", "--dimensions", f"{dimension}", "--precisions", "float64"]
    assert main(["bench", *options]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    names = re.split(r"\s{2,}", head.strip())
    assert [line.split()[3] for line in lines] == ["explicit", "implicit"]
    for line in lines:
        values = dict(zip(names, re.split(r"\s{2,}", line.strip()), strict=True))
        assert (values["space"], values["fluid"]) == (f"{dimension}-D", count)
        assert float(values["ms a step"]) > 0.0
        assert float(values["passes"]) >= 1.0
        assert float(values["iterations a solve"]) >= 1.0
        shares = dict(re.findall(r"(\w+) (\d+) %", values["share of each part"]))
        assert list(shares) == ["pressure", "fluid", "structure", "exchange"]
        assert sum(map(int, shares.values())) == pytest.approx(100, abs=2)


@pytest.mark.parametrize(("dimension", "size", "count"), [(2, 100, "98"), (3, 60, "54")])
def test_bench_of_fluids_prints_speeds_and_shares(
    dimension: int, size: int, count: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    options = ["--sizes", f"{size}", "--of", "fluids", "--dimensions", f"{dimension}", "--precisions", "float64"]
    assert main(["bench", *options]) == 0
    head, line = capsys.readouterr().out.splitlines()
    assert "elastic" not in head
    assert re.split(r"\s+", line.strip())[:2] == [f"{dimension}-D", count]
    values = dict(zip(re.split(r"\s{2,}", head.strip()), re.split(r"\s{2,}", line.strip()), strict=True))
    milliseconds, millions = float(values["ms a step"]), float(values["million/s"])
    assert milliseconds * millions == pytest.approx(int(count) / 1e3, rel=0.01)
    assert 0.0 < float(values["residual"]) <= 1e-4
    assert float(values["iterations a solve"]) >= 1.0
    parts = dict(re.findall(r"([a-z ]+) (\d+) %", values["share of each part"]))
    assert {"neighbour lists", "assembly", "pressure solve", "corrector", "collisions"} <= {
        name.strip() for name in parts
    }
    assert sum(map(int, parts.values())) == pytest.approx(100, abs=4)


def test_validate_prints_measured_beside_reference(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "beam_second_mode_as_published"]) == 0
    captured = capsys.readouterr()
    line = next(line for line in captured.out.splitlines() if "frequency" in line)
    assert "744" in line
    assert "table 3" in line
    assert "-0.7" in line


def test_check_refuses_what_a_run_would_refuse(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    held = ("Cube", 'token mps:role = "support"', "double size = 0.1", "double3 xformOp:translate = (9, 9, 0)")
    stage = write(tmp_path, Held=(*held, 'uniform token[] xformOpOrder = ["xformOp:translate"]'))
    assert main(["check", str(stage)]) == 2
    assert "/Held: the support holds no particle" in capsys.readouterr().err
    assert main(["check", str(write(tmp_path)), "--set", "/Beam.mps:spacing=1e-9"]) == 2


def test_the_axes_of_a_probe_are_those_of_the_stage(tmp_path: Path) -> None:
    stage = write(tmp_path, up="Z", Scene=("double mps:duration = 1e-4",), Tip=SHAKEN["Tip"])
    assert main(["run", str(stage), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    assert read_history(tmp_path / "out" / "probes.csv").labels[1:3] == ("Tip.x [m]", "Tip.z [m]")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("warp-mps ")

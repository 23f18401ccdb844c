"""The documentation: its links into the package lead somewhere, its reference is complete, and its code runs."""

from __future__ import annotations

import functools
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import warp_mps
from warp_mps.particles.filling import fill_scene

ROOT = Path(__file__).resolve().parent.parent


def linked_names() -> list[str]:
    """Names of the package that the documentation links to its reference, such as `warp_mps.core.weights`."""
    pages = [path.read_text(encoding="utf-8") for path in (ROOT / "docs").rglob("*.md")]
    return sorted({name for page in pages for name in re.findall(r"\[`?(warp_mps[\w.]+)`?\]", page)})


def find(name: str) -> Any:
    """The module, or what it holds, of a dotted name.

    Raises:
        ModuleNotFoundError: There is no such module.
        AttributeError: It holds no such thing.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError:
        module, _, attribute = name.rpartition(".")
        if not module:
            raise
        return getattr(find(module), attribute)


def python_blocks(path: str) -> list[str]:
    """The Python code in a Markdown file."""
    return re.findall(r"```python\n(.*?)```", (ROOT / path).read_text(encoding="utf-8"), re.DOTALL)


def replaced(code: str, values: dict[str, str]) -> str:
    """Code with other numbers, each of which must stand in it once."""
    for old, new in values.items():
        assert code.count(old) == 1, old
        code = code.replace(old, new)
    return code


def test_the_reference_lists_every_public_name() -> None:
    listed = re.findall(r"^::: warp_mps\.(\w+)$", (ROOT / "docs/reference/api.md").read_text(encoding="utf-8"), re.M)
    assert sorted(listed) == sorted(warp_mps.__all__)


@pytest.mark.parametrize("name", linked_names())
def test_the_documentation_links_what_there_is(name: str) -> None:
    assert find(name).__doc__


@pytest.mark.parametrize("part", [0.1, pytest.param(1.0, marks=pytest.mark.long)])
@pytest.mark.parametrize(("number", "folder"), [(0, "first"), (1, "flap")])
def test_the_first_simulations_of_the_readme_run(
    number: int, folder: str, part: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over a part of their durations, and in the longer layer as they are printed."""
    shorter = functools.partial(re.sub, r"duration=([0-9.]+)", lambda found: f"duration={part * float(found[1])}")
    code = shorter(python_blocks("README.md")[number])
    assert len([line for line in code.splitlines() if line.strip()]) <= 9
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    exec(code, scope)
    assert scope["summary"].status == "done"
    assert scope["summary"].case == folder
    assert Path(f"runs/{folder}/run.usdc").exists()


def test_the_moving_tank_of_the_first_steps_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = python_blocks("docs/first-steps.md")
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    exec(replaced(code, {"duration=1.0": "duration=0.05"}), scope)
    assert scope["summary"].status == "done"
    assert Path("runs/baffle/run.usdc").exists()


@pytest.mark.long
def test_the_scripting_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = "".join(python_blocks("docs/scripting.md"))
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    exec(code, scope)
    assert scope["summary"].status == "done"
    assert scope["stress"] > 1e3
    assert {path.name for path in Path("runs/bracket").iterdir()} >= {"picture.png", "probes.png", "report.html"}
    assert scope["half"] == pytest.approx(-0.01, rel=0.01)
    assert scope["simulation"].time == pytest.approx(0.05, rel=1e-3)
    assert fill_scene(scope["again"]).count == scope["summary"].particles["bracket"]


@pytest.mark.long
def test_the_tutorial_runs_and_its_hull_floats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At twice the spacing, for a moment: the water has given way to the hull, which has not sunk or jumped.

    The hull starts at a draught of a whole spacing, so that the water about it fits.
    """
    pytest.importorskip("trimesh")
    coarse = {"l0 = 0.01": "l0 = 0.02", "duration=1.0": "duration=0.1", "= 0.1, 0.03": "= 0.1, 0.02"}
    code = replaced("".join(python_blocks("docs/tutorial.md")), coarse)
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    exec(code, scope)
    found = re.search(r"draught ([0-9.]+) mm, Archimedes 27.0 mm", capsys.readouterr().out)
    assert found
    assert float(found[1]) == pytest.approx(27.0, abs=5.0)
    again = warp_mps.read_stage("hull.usda")
    assert [body.name for body in again.bodies] == ["hull"]
    assert len(again.walls) == len(scope["scene"].walls)

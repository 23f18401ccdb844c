"""The examples at reduced size, for the numbers that they promise."""

from __future__ import annotations

import json
import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SCRIPTS = sorted(path.name for path in EXAMPLES.glob("*.py"))


def main_of(name: str) -> Callable[..., Any]:
    main = runpy.run_path(str(EXAMPLES / name))["main"]
    assert callable(main)
    return main


@pytest.mark.parametrize("name", SCRIPTS)
def test_every_example_says_what_it_does_and_what_to_expect(name: str) -> None:
    text = (EXAMPLES / name).read_text(encoding="utf-8")
    begin = [text.find(f"\n{word}: ") for word in ("Physics", "Reference", "Run time", "Command", "Expect")]
    assert -1 < begin[0] < begin[1] < begin[2] < begin[3] < begin[4]
    assert f"Command: python examples/{name} [--quick]\n" in text
    assert len(text.splitlines()) <= 120


@pytest.mark.long
def test_compare_models() -> None:
    errors = main_of("compare_models.py")(layers=(4, 8), duration=0.06)
    assert errors["springs", 4] == pytest.approx(-0.048, abs=0.003)
    assert errors["springs", 8] == pytest.approx(-0.017, abs=0.002)
    assert abs(errors["hamiltonian", 4]) < 0.005
    assert abs(errors["hamiltonian", 8]) < 0.003


def test_elastica() -> None:
    assert main_of("elastica.py")(quick=True) < 0.003


def test_steel_bar() -> None:
    errors = main_of("steel_bar.py")(quick=True)
    assert abs(errors["frequency"]) < 0.008
    assert abs(errors["deflection"]) < 0.008


@pytest.mark.long
def test_friction() -> None:
    for friction, (way, expected) in main_of("friction.py")(quick=True).items():
        assert way == pytest.approx(expected, rel=0.01, abs=1e-4), friction


@pytest.mark.long
def test_waves() -> None:
    for depth, error in main_of("waves.py")(quick=True).items():
        assert abs(error) < 0.02, depth


def test_dam_break() -> None:
    found = main_of("dam_break.py")(quick=True)
    assert [found[f"{time} s"] for time in ("0.066", "0.133", "0.2")] == pytest.approx([0.02, 0.09, 0.165], abs=0.02)
    assert found["struck"] == pytest.approx(0.256, abs=0.01)
    assert found["gain"] < 0.01


@pytest.mark.long
def test_mesh_asset() -> None:
    volume, momentum, change = main_of("mesh_asset.py")(quick=True)
    assert abs(volume) < 0.02
    assert abs(momentum) < 0.02
    assert change < 1e-10


def test_cradle() -> None:
    found = main_of("cradle.py")(quick=True)
    assert found["restitution"] == pytest.approx(0.96, abs=0.01)
    assert found["momentum"] < 1e-12
    assert found["energy"] < 1e-4


def test_read_results() -> None:
    found = main_of("read_results.py")(quick=True)
    assert set(found) == {"position", "momentum", "kinetic_energy", "total"}
    assert max(found.values()) < 1e-6


@pytest.mark.long
def test_wet_plate() -> None:
    errors = main_of("wet_plate.py")(quick=True)
    assert set(errors) == {0.0, 0.25}
    assert abs(errors[0.0]) < 0.005
    assert abs(errors[0.25]) < 0.01


@pytest.mark.long
def test_floating_plates() -> None:
    errors = main_of("floating_plates.py")(quick=True)
    assert set(errors) == {250.0, 500.0, 750.0}
    assert max(abs(error) for error in errors.values()) < 3e-4


def test_the_notebook_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """Cell by cell, at reduced size, as a kernel would, without one."""
    notebook = json.loads((EXAMPLES / "first_steps.ipynb").read_text(encoding="utf-8"))
    scope: dict[str, Any] = {}
    with mpl.rc_context({"backend": "agg"}):
        for cell in notebook["cells"]:
            assert not cell.get("outputs")
            if cell["cell_type"] == "code":
                exec("".join(cell["source"]).replace("QUICK = False", "QUICK = True"), scope)
    assert scope["QUICK"] is True
    found = re.search(r"rad/s, expected [0-9.]+, ([-+0-9.]+)%", capsys.readouterr().out)
    assert found
    assert abs(float(found[1])) < 1.5
    assert (scope["folder"] / "picture.png").stat().st_size > 5000
    assert "def Cube" in (scope["folder"] / "cantilever.usda").read_text()

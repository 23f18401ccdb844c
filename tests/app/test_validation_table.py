"""The table of the documentation: rows, order and what a cell may hold."""

from __future__ import annotations

import pytest

from warp_mps.app.validation_table import main, validation_table
from warp_mps.results.summary import RunSummary

ELASTIC = {"bodies": {"beam": {}}, "elasticity": {"model": "springs"}}
THEORY = "theory | of thin\nbeams"
WATER = {"fluids": {"water": {}}, "flow": {"scheme": "conservative"}}


def row(name: str, value: float | None, reference: float | None = None, source: str = "") -> dict:
    error = None if value is None or reference is None else (value - reference) / abs(reference)
    return {"name": name, "value": value, "unit": "m", "reference": reference, "error": error, "source": source}


def run(case: str, settings: dict, *rows: dict, status: str = "done") -> RunSummary:
    return RunSummary(case=case, status=status, settings=settings, wall_seconds=3.0, measurements=list(rows))


def test_each_kind_of_case_has_a_table_and_only_finished_runs_are_in_it() -> None:
    text = validation_table(
        [
            run("wave", WATER, row("level", 0.3, 0.4)),
            run("gate", ELASTIC | WATER, row("shift", 0.1)),
            run(
                "beam",
                ELASTIC,
                row("tip", -2.0, -1.0, THEORY),
                row("mean", None, 0.0, THEORY),
                {**row("late", None, 1.0, THEORY), "reason": "not reached: it needs the run up to 2 s"},
            ),
            run("stopped", ELASTIC, row("tip", 1.0), status="failed"),
        ]
    )
    titles = [line for line in text.splitlines() if line.startswith("## ")]
    assert titles == ["## Elastic bodies", "## Water", "## Water and elastic bodies"]
    assert "| `beam`<br>springs, 3 s | tip [m] | -2 | -1 | -100.00 % | theory \\| of thin beams |" in text
    assert "|  | mean [m] | none | 0 |  |  |" in text
    assert "|  | late [m] | not reached: it needs the run up to 2 s | 1 |  |  |" in text
    assert "| `gate`<br>springs, conservative, 3 s | shift [m] | 0.1 |  |  |  |" in text
    assert "stopped" not in text


def test_the_table_is_made_of_the_folders_of_a_folder(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("wave", "drop"):
        (tmp_path / name).mkdir()
        run(name, WATER, row("level", 0.3, 0.4)).write(tmp_path / name / "run.json")
    main(str(tmp_path))
    cases = [line.split("`")[1] for line in capsys.readouterr().out.splitlines() if "`" in line]
    assert cases == ["drop", "wave"]

"""What is no summary, by its types."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from warp_mps.errors import InputError
from warp_mps.results.summary import RunSummary, read_summary

ROW = {"name": "tip", "value": 1.0, "unit": "m", "reference": None, "error": None, "source": ""}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"case": 3}, "case is 3, must be a text"),
        ({"case": "\ud800"}, r"case is '\\ud800', must be a text"),
        ({"status": []}, "a case and a status are missing"),
        ({"dimension": "2"}, "dimension is '2', must be 2 or 3"),
        ({"particles": {"a": None}}, r"particles is \{'a': None\}, must be whole numbers by name"),
        ({"time": None}, "time is None, must be a number of 0 or more"),
        ({"time": 1e308}, r"time is 1e\+308"),
        ({"steps": 1.5}, "steps is 1.5, must be a whole number"),
        ({"energy": []}, "energy is .., must be numbers by name"),
        ({"settings": {"a": {"b": float("nan")}}}, "settings is .*, must be texts and numbers by name"),
        ({"settings": {"\ud800": 1}}, "settings is .*, must be texts and numbers by name"),
        ({"measurements": {}}, "measurements is .., must be a list"),
        ({"measurements": [{}]}, r"measurements\[0\] has no name"),
        ({"measurements": [{**ROW, "value": "1"}]}, r"measurements\[0\] value is '1', must be a number or null"),
        ({"measurements": [{**ROW, "window": [1]}]}, r"measurements\[0\] window is \[1\], must be two times"),
    ],
)
def test_items_of_wrong_types_are_refused(tmp_path: Path, change: dict[str, Any], reason: str) -> None:
    path = tmp_path / "run.json"
    RunSummary(case="case", measurements=[ROW]).write(path)
    assert read_summary(path).measurements == [ROW]
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(InputError, match=f"run.json: is not the summary of a run: {reason}"):
        read_summary(path)


def test_brackets_too_deep_are_refused(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text("[" * 100_000)
    with pytest.raises(InputError, match="is not valid JSON"):
        read_summary(tmp_path / "run.json")

"""Diagrams of a history: their number, their contents, their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from warp_mps.app.cli import main
from warp_mps.app.view.panels import panels
from warp_mps.app.view.plot import draw_figure
from warp_mps.results.history import TIME_LABEL, History, energy_labels, write_history
from warp_mps.results.summary import RunSummary

LABELS = (TIME_LABEL, "tip.x [m]", "tip.y [m]", "middle.x [m]", "middle.y [m]", "far [Pa]")


def history() -> History:
    """A tip whose components are near each other, a middle whose are not, a pressure, and energies of a fall."""
    times = np.linspace(0.0, 1.0, 11)
    rows = [
        (t, 0.1 * t, t**2, 5.0 + 0.1 * t, 0.1 * t, 3e4 * t, 2.0 * t, 0.0, 0.0, 100.0 - 2.0 * t, 0.0, 0.0) for t in times
    ]
    return History([*LABELS, *energy_labels(2)], rows)


def summary() -> RunSummary:
    rows = [
        {"name": "rise", "column": "tip.y [m]", "measure": "maximum", "reference": 0.9, "window": [0.5, None]},
        {"name": "half", "column": "tip.y [m]", "measure": "value_at", "reference": 0.3, "at": 0.5},
        {"name": "passing", "column": "tip.y [m]", "measure": "time_at", "reference": 0.4, "at": 0.2},
        {"name": "beat", "column": "tip.y [m]", "measure": "period", "reference": 0.7, "window": [0.0, None]},
        {"name": "unknown", "column": "tip.y [m]", "measure": "minimum", "reference": None, "window": [0.0, None]},
    ]
    return RunSummary(case="fall", status="done", particles={"a": 3}, time=1.0, measurements=rows)


def drawn(figure: Figure, panel: int) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.array(line.get_xydata()) for line in figure.axes[panel].lines}


def test_components_share_a_diagram_where_that_shows_them() -> None:
    found = panels(history())
    assert [panel.title for panel in found] == ["tip", "middle.x", "middle.y", "far", "energies"]
    assert [panel.unit for panel in found] == ["m", "m", "m", "Pa", "J/m"]
    assert [line.name for line in found[0].lines] == ["x", "y"]
    assert [line.name for line in found[4].lines] == ["kinetic", "potential", "balance"]
    assert found[4].lines[1].values == pytest.approx(-2.0 * np.linspace(0.0, 1.0, 11), abs=1e-12)
    assert found[4].lines[2].values == pytest.approx(np.zeros(11), abs=1e-12)


def test_references_beyond_the_history_are_not_drawn() -> None:
    whole = history()
    short = History(whole.labels, whole.rows[:5])
    assert set(drawn(draw_figure(short, summary()), 0)) == {"x", "y", "reference"}
    assert drawn(draw_figure(short, summary()), 0)["reference"].tolist() == [[0.4, 0.2]]


def test_only_references_that_are_values_of_the_probe_are_drawn() -> None:
    lines = drawn(draw_figure(history(), summary()), 0)
    assert set(lines) == {"x", "y", "reference", "reference: rise"}
    assert lines["reference: rise"].tolist() == [[0.5, 0.9], [1.0, 0.9]]
    assert lines["reference"].tolist() == [[0.5, 0.3], [0.4, 0.2]]
    assert np.array_equal(lines["y"][:, 1], history().probe("tip", 1))


@pytest.mark.parametrize("suffix", ["png", "svg", pytest.param("pdf", marks=pytest.mark.long)])
def test_a_file_is_written_once(tmp_path: Path, capsys: pytest.CaptureFixture[str], suffix: str) -> None:
    write_history(tmp_path / "probes.csv", history())
    summary().write(tmp_path / "run.json")
    out = tmp_path / f"new/probes.{suffix}"
    assert main(["plot", str(tmp_path), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    begin = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert out.read_bytes().startswith(begin)
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    assert main(["plot", str(tmp_path), "--out", str(out)]) == 2
    assert "exists; use --overwrite" in capsys.readouterr().err
    assert main(["plot", str(tmp_path), "--out", str(out), "--overwrite"]) == 0


def test_what_cannot_be_drawn_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refusal(*arguments: str) -> str:
        assert main(["plot", *arguments]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "is not a folder" in refusal(str(tmp_path / "none"))
    assert "probes.csv: cannot be read" in refusal(str(tmp_path))
    assert "must end in .png or .svg or .pdf" in refusal(str(tmp_path), "--out", "a.bmp")
    write_history(tmp_path / "probes.csv", History(history().labels))
    summary().write(tmp_path / "run.json")
    assert "has no rows" in refusal(str(tmp_path))

"""The diagrams of a history as the page draws them: thinned points, references and measurements."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from warp_mps.app.report.run_data import Run
from warp_mps.app.report.tables import measured_text
from warp_mps.app.view.panels import Panel, panels, references

# points of a line; of more, the least and the greatest of every stretch are kept
POINTS = 2000
DIGITS = 7


def make_diagrams(run: Run) -> list[dict[str, Any]]:
    """Each diagram: title, unit, times, lines with their references, and the measurements that belong to it."""
    if run.history is None:
        return []
    times = run.history.times
    return [_diagram(panel, times, run.summary.measurements) for panel in panels(run.history)]


def _diagram(panel: Panel, times: np.ndarray, measurements: list[dict[str, Any]]) -> dict[str, Any]:
    kept = _thin(panel)
    columns = {line.column for line in panel.lines if line.column}
    lines = [
        {
            "name": line.name,
            "values": _numbers(line.values[kept]),
            "references": [
                {"name": item.name, "times": _numbers(item.times), "value": item.value}
                for item in references(line, times, measurements)
            ],
        }
        for line in panel.lines
    ]
    return {
        "title": panel.title,
        "unit": panel.unit,
        "times": _numbers(times[kept]),
        "lines": lines,
        "measured": [measured_text(row) for row in measurements if row.get("column") in columns],
    }


def _thin(panel: Panel) -> np.ndarray:
    """Numbers of the rows that are drawn: all, or the ends, the least and the greatest of each line in each stretch."""
    count = len(panel.lines[0].values)
    if count <= POINTS:
        return np.arange(count)
    stretches = np.array_split(np.arange(count), POINTS // (2 * len(panel.lines)))
    kept = {0, count - 1}
    for line in panel.lines:
        values = np.nan_to_num(line.values)
        for stretch in stretches:
            part = values[stretch]
            kept |= {int(stretch[part.argmin()]), int(stretch[part.argmax()])}
    return np.array(sorted(kept))


def _numbers(values: Any) -> list[float | None]:
    """Numbers for JSON, of as many digits as can be seen."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in values]

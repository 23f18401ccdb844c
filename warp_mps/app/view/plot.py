"""The history of a run as a figure of small diagrams: every probe and the energies against time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from warp_mps.app.animation_reader import refuse_existing
from warp_mps.app.run_folder import PROBES, SUMMARY, require_run
from warp_mps.app.view.figures import COLORS, INK, require_format, save, style
from warp_mps.app.view.panels import Panel, Reference, panels, references
from warp_mps.errors import InputError
from warp_mps.results.history import History, read_history
from warp_mps.results.summary import RunSummary, read_summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = ("png", "svg", "pdf")
# more names than this take a second row, so that they leave room for the title
LEGEND_COLUMNS = 4


def plot_history(folder: Path, out: Path | None = None, *, overwrite: bool = False) -> Path:
    """Draw probes.csv of a run, with the references of run.json that are values of a probe.

    Args:
        folder: Folder of the run.
        out: File to write, ending in one of `FORMATS`; None is probes.png in the folder.
        overwrite: Whether to replace it.

    Returns:
        The file.

    Raises:
        InputError: There is no run in the folder or it has no rows, or the file cannot be written.
    """
    path = out or folder / "probes.png"
    require_format(path, FORMATS)
    require_run(folder)
    history, summary = read_history(folder / PROBES), read_summary(folder / SUMMARY)
    if not history.rows:
        raise InputError(str(folder / PROBES), "", "has no rows")
    refuse_existing(path, overwrite)
    with style():
        save(draw_figure(history, summary), path)
    return path


def draw_figure(history: History, summary: RunSummary) -> Figure:
    """A figure with a diagram for each probe and for the energies, and the references that are values of a probe."""
    found = panels(history)
    columns = 1 if len(found) < 3 else 2 if len(found) < 9 else 3
    rows = math.ceil(len(found) / columns)
    figure = Figure(figsize=(3.0 + 3.6 * columns, 0.7 + 2.2 * rows), dpi=150, layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for number, (axes, panel) in enumerate(zip(grid, found, strict=False)):
        _fill(axes, history.times, panel, summary.measurements)
        if number + columns >= len(found):
            axes.set_xlabel("time [s]")
            axes.tick_params(labelbottom=True)
    for axes in grid[len(found) :]:
        axes.remove()
    figure.suptitle(_headline(summary), x=0.01, ha="left", fontsize=11.0, parse_math=False)
    return figure


def _fill(axes: Axes, times: np.ndarray, panel: Panel, measurements: Sequence[dict[str, Any]]) -> None:
    axes.set_title(panel.title, parse_math=False)
    axes.set_ylabel(f"[{panel.unit}]")
    for number, line in enumerate(panel.lines):
        color = COLORS[number % len(COLORS)]
        if line.name == "balance":
            axes.plot(times, line.values, color=INK, linestyle=":", label="balance")
            continue
        axes.plot(times, line.values, color=color, label=line.name or "_", solid_joinstyle="round")
        _refer(axes, references(line, times, measurements), color)
    _widen(axes, np.concatenate([line.values for line in panel.lines]))
    axes.margins(x=0.0)
    if axes.get_legend_handles_labels()[0]:
        # beside the title, where it covers nothing
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
        legend = axes.legend(ncols=LEGEND_COLUMNS, handlelength=1.4, columnspacing=1.2, labelspacing=0.2, **place)
        for text in legend.get_texts():
            text.set_parse_math(False)


def _refer(axes: Axes, found: Sequence[Reference], color: str) -> None:
    """Draw references: dashed where they hold for a window of time, else as points."""
    marks: dict[str, Any] = {
        "marker": "o",
        "markersize": 5.5,
        "markerfacecolor": "white",
        "markeredgecolor": INK,
        "linestyle": "none",
    }
    points = [(reference.times[0], reference.value) for reference in found if len(reference.times) == 1]
    if points:
        axes.plot(*np.array(points, dtype=float).T, label="reference", zorder=5, clip_on=False, **marks)
    for reference in found:
        if len(reference.times) == 2:
            label = f"reference: {reference.name}"
            axes.plot(reference.times, [reference.value] * 2, color=color, linestyle="--", linewidth=1.0, label=label)


def _widen(axes: Axes, values: np.ndarray) -> None:
    """Show what hardly changes as what hardly changes, not its last digits."""
    finite = values[np.isfinite(values)]
    if len(finite) and np.ptp(finite) <= 1e-6 * np.abs(finite).max():
        middle, half = float(finite.mean()), 0.01 * float(np.abs(finite).max()) or 1.0
        axes.set_ylim(middle - half, middle + half)


def _headline(summary: RunSummary) -> str:
    count = sum(summary.particles.values())
    text = f"{summary.case}: {summary.dimension}-D, {count} particles, {summary.time:.4g} s"
    return text if summary.status == "done" else f"{text} ({summary.status})"

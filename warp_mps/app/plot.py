"""The history of a run as a sheet of small diagrams: every probe and the energies against time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from warp_mps.app.figures import COLORS, INK, require_format, save, style
from warp_mps.app.result import refuse_existing
from warp_mps.energy import ENERGY_NAMES
from warp_mps.errors import InputError
from warp_mps.history import History, read_history
from warp_mps.results import RunSummary, read_summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = ("png", "svg", "pdf")
# measures that are values of the probe itself, at all times of their window or at one
LEVELS = ("mean", "minimum", "maximum", "midrange", "offset", "final")
# components share a diagram unless they lie this many times their own range apart
APART = 4.0


@dataclass(frozen=True)
class Line:
    """A column of probes.csv: its label, what to call it in a legend, and its values, shape [m]."""

    column: str
    name: str
    values: np.ndarray


@dataclass(frozen=True)
class Panel:
    """A diagram: its title, its unit, and its lines."""

    title: str
    unit: str
    lines: tuple[Line, ...]


def plot_history(folder: Path, out: Path | None = None, *, overwrite: bool = False) -> int:
    """Draw probes.csv of a run, with the references of run.json that are values of a probe.

    Args:
        folder: Folder of the run.
        out: File to write, ending in one of `FORMATS`; None is probes.png in the folder.
        overwrite: Whether to replace it.

    Raises:
        InputError: There is no run in the folder or it has no rows, or the file cannot be written.
    """
    path = out or folder / "probes.png"
    require_format(path, FORMATS)
    if not folder.is_dir():
        raise InputError(str(folder), "", "is no folder; give the folder that `warp-mps run` left, such as runs/CASE")
    history, summary = read_history(folder / "probes.csv"), read_summary(folder / "run.json")
    if not history.rows:
        raise InputError(str(folder / "probes.csv"), "", "has no rows")
    refuse_existing(path, overwrite)
    with style():
        save(_draw(history, summary), path)
    print(path)
    return 0


def panels(history: History) -> list[Panel]:
    """The diagrams of a history: the components of a probe together where that shows them, the energies last."""
    values = np.array(history.rows).T
    groups: dict[tuple[str, str], list[Line]] = {}
    for label, column in zip(history.labels[1:], values[1:], strict=True):
        name, _, unit = label.rstrip("]").partition(" [")
        probe, _, component = name.partition(".")
        if name in ENERGY_NAMES.values():
            probe, component = "energies", name
        groups.setdefault((probe, unit), []).append(Line(label, component, column))
    found = [panel for (probe, unit), lines in groups.items() for panel in _panels_of(probe, unit, lines)]
    return [panel for panel in found if panel.lines]


def _panels_of(probe: str, unit: str, lines: list[Line]) -> list[Panel]:
    if probe == "energies":
        return [Panel(probe, unit, tuple(_energies(lines)))]
    together = np.ptp([line.values for line in lines])
    if len(lines) > 1 and together > APART * max(np.ptp(line.values) for line in lines):
        return [Panel(f"{probe}.{line.name}", unit, (replace(line, name=""),)) for line in lines]
    return [Panel(probe, unit, tuple(lines))]


def _energies(lines: Sequence[Line]) -> list[Line]:
    """The energies that are not nothing all the time, the potential energy from its beginning, and their balance."""
    by_name = {line.name: line.values for line in lines}
    potential, work = ENERGY_NAMES["potential"], ENERGY_NAMES["work"]
    if potential in by_name:
        by_name[potential] = by_name[potential] - by_name[potential][0]
    balance = sum(-values if name == work else values for name, values in by_name.items())
    kept = [Line("", name.removesuffix(" energy"), values) for name, values in by_name.items() if np.any(values)]
    return [*kept, Line("", "balance", np.asarray(balance))] if kept else []


def _draw(history: History, summary: RunSummary) -> Figure:
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
        _refer(axes, times, [row for row in measurements if row.get("column") == line.column], color)
    _widen(axes, np.concatenate([line.values for line in panel.lines]))
    axes.margins(x=0.0)
    if axes.get_legend_handles_labels()[0]:
        # beside the title, where it covers nothing
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
        legend = axes.legend(ncols=8, handlelength=1.4, columnspacing=1.2, **place)
        for text in legend.get_texts():
            text.set_parse_math(False)


def _refer(axes: Axes, times: np.ndarray, rows: Sequence[dict[str, Any]], color: str) -> None:
    """Draw references that are values of the probe: dashed where they hold for a window of time, else as points."""
    rows = [row for row in rows if row.get("reference") is not None]
    marks: dict[str, Any] = {
        "marker": "o",
        "markersize": 5.5,
        "markerfacecolor": "white",
        "markeredgecolor": INK,
        "linestyle": "none",
    }
    points = [(row["at"], row["reference"]) for row in rows if row["measure"] == "value_at"]
    points += [(row["reference"], row["at"]) for row in rows if row["measure"] == "time_at"]
    if points:
        axes.plot(*np.array(points, dtype=float).T, label="reference", zorder=5, clip_on=False, **marks)
    for row in rows:
        if row["measure"] in LEVELS:
            start, end = row["window"]
            ends = [max(start, times[0]), times[-1] if end is None else min(end, times[-1])]
            label = f"reference: {row['name']}"
            axes.plot(ends, [row["reference"]] * 2, color=color, linestyle="--", linewidth=1.0, label=label)


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

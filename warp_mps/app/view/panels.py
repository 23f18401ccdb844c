"""The diagrams of a history: lines that share axes, and the references drawn in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.results.history import History

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


@dataclass(frozen=True)
class Reference:
    """A reference that is a value of a line: at one moment, or for a window of time.

    Attributes:
        name: Name of the measurement that it belongs to; empty at one moment.
        times: The moment, or the ends of the window [s], shape [1] or [2].
        value: The value.
    """

    name: str
    times: tuple[float, ...]
    value: float


def references(line: Line, times: np.ndarray, measurements: Sequence[dict[str, Any]]) -> list[Reference]:
    """The references of a line that are values of it at times of its history, those at one moment first.

    Args:
        line: The line.
        times: Times of the history [s], shape [m].
        measurements: Rows as of `warp_mps.results.summary.measurement_rows`.
    """
    rows = [row for row in measurements if line.column and row.get("column") == line.column]
    rows = [row for row in rows if row.get("reference") is not None]
    found = [Reference("", (row["at"],), row["reference"]) for row in rows if row["measure"] == "value_at"]
    found += [Reference("", (row["reference"],), row["at"]) for row in rows if row["measure"] == "time_at"]
    for row in rows:
        if row["measure"] in LEVELS:
            start, end = row["window"]
            ends = (max(start, times[0]), times[-1] if end is None else min(end, times[-1]))
            found.append(Reference(row["name"], ends, row["reference"]))
    # a run that was stopped may not have come as far
    return [item for item in found if times[0] <= item.times[0] <= item.times[-1] <= times[-1]]


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

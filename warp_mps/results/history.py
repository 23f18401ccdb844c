"""The history of a run, probes.csv: every row has a time, and the probes and energies at that time."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from warp_mps.errors import InputError
from warp_mps.results.atomic_write import write_whole
from warp_mps.results.energy import ENERGY_NAMES, Energy
from warp_mps.results.regular_file import read_regular
from warp_mps.results.summary_check import LARGEST

TIME_LABEL = "time [s]"


def energy_labels(dimension: int) -> tuple[str, ...]:
    """Labels of the energies' columns, the last ones of a history."""
    unit = "J/m" if dimension == 2 else "J"
    return tuple(f"{name} [{unit}]" for name in ENERGY_NAMES.values())


class History:
    """Rows of numbers under labels such as ``tip.x [m]``.

    Args:
        labels: Labels: the time, the probes' components, the energies.
        rows: Rows to begin with, times increasing.
    """

    def __init__(self, labels: Sequence[str], rows: Iterable[Sequence[float]] = ()) -> None:
        self.labels = tuple(labels)
        self.rows = [tuple(row) for row in rows]

    def append(self, row: Sequence[float]) -> None:
        """Add a row; its first number is the time [s]."""
        self.rows.append(tuple(row))

    @property
    def last_time(self) -> float:
        """Time of the last row [s], minus infinity before the first."""
        return self.rows[-1][0] if self.rows else -np.inf

    @property
    def times(self) -> np.ndarray:
        """Times [s], shape [m]."""
        return np.array([row[0] for row in self.rows])

    def probe(self, name: str, component: int | str = 0) -> np.ndarray:
        """History of one component of a probe, shape [m].

        Args:
            name: Name of the probe.
            component: Number of the component, from 0, or its name, such as ``y`` or ``xy``.

        Raises:
            KeyError: There is no such probe or component; the text lists those that there are.
        """
        column = self._column(name, component)
        return np.array([row[column] for row in self.rows])

    def label(self, name: str, component: int | str = 0) -> str:
        """Label of the column of one component of a probe, e.g. ``tip.x [m]``.

        Raises:
            KeyError: There is no such probe or component.
        """
        return self.labels[self._column(name, component)]

    @property
    def probes(self) -> dict[str, tuple[str, ...]]:
        """Names of the components of each probe, by its name; one empty name for a probe of a single number."""
        return {name: tuple(columns) for name, columns in self._columns().items()}

    def _columns(self) -> dict[str, dict[str, int]]:
        """Columns by the names of the probe and of its component."""
        found: dict[str, dict[str, int]] = {}
        for column, label in enumerate(self.labels[1 : -len(ENERGY_NAMES)], start=1):
            quantity = label.rpartition(" [")[0]
            parts = re.fullmatch(r"(.+)\.([xyz]{1,2})", quantity)
            name, component = parts.groups() if parts else (quantity, "")
            found.setdefault(name, {})[component] = column
        return found

    def _column(self, name: str, component: int | str) -> int:
        columns = self._columns().get(name)
        if columns is None:
            raise KeyError(f"there is no probe {name!r}, there are: {', '.join(self.probes) or 'none'}")
        if component in columns:
            return columns[str(component)]
        if isinstance(component, int | np.integer) and 0 <= component < len(columns):
            return list(columns.values())[component]
        known = ", ".join(filter(None, columns)) or "a single one, 0"
        raise KeyError(f"probe {name!r} has no component {component!r}, its components are: {known}")

    def energies(self) -> list[Energy]:
        """Energies of every row."""
        count = len(ENERGY_NAMES)
        return [Energy(**dict(zip(ENERGY_NAMES, row[-count:], strict=True))) for row in self.rows]

    def until(self, time: float) -> History:
        """The rows up to a time [s], but for rounding."""
        limit = time + 1e-12 * abs(time)
        return History(self.labels, [row for row in self.rows if row[0] <= limit])


def read_history(path: str | Path) -> History:
    """Read probes.csv; a last row that was cut short when its writer died is left out.

    Raises:
        InputError: The file is missing or holds something else.
    """
    try:
        text = read_regular(path)
        lines = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    except OSError as error:
        raise InputError(str(path), "", f"cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(str(path), "", f"is damaged: {error}") from error
    if not lines or not lines[0] or lines[0][0] != TIME_LABEL:
        raise InputError(str(path), "", f"is not a table of probes: its first column must be {TIME_LABEL!r}")
    try:
        rows = [[float(cell) for cell in line] for line in lines[1:]]
    except ValueError as error:
        raise InputError(str(path), "", f"holds something else than numbers: {error}") from error
    if any(len(row) != len(lines[0]) for row in rows):
        raise InputError(str(path), "", "has rows of different lengths")
    _require_sound(path, lines[0], np.array(rows).reshape(len(rows), len(lines[0])))
    return History(lines[0], rows)


def _require_sound(path: str | Path, labels: Sequence[str], values: np.ndarray) -> None:
    """Refuse a table without energies, times that do not increase, and numbers that cannot be computed with.

    Raises:
        InputError: It is one of these.
    """
    ends = [label.rpartition(" [")[0] for label in labels[-len(ENERGY_NAMES) :]]
    if len(labels) <= len(ENERGY_NAMES) or ends != list(ENERGY_NAMES.values()):
        raise InputError(str(path), "", "is not a table of probes: its last columns must be the energies")
    if len(set(labels)) < len(labels):
        raise InputError(str(path), "", "has two columns of one name")
    times = values[:, 0]
    wrong = ~np.isfinite(times)
    wrong[1:] |= ~(np.diff(times) > 0.0)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(
            str(path), "", f"has the time {times[row]:g} s in row {row + 1}, must increase from row to row"
        )
    large = np.isfinite(values) & (np.abs(values) > LARGEST)
    if large.any():
        row, column = (int(number) for number in np.argwhere(large)[0])
        reason = f"holds {values[row, column]:g} in row {row + 1}, at most {LARGEST:g} can be computed with"
        raise InputError(str(path), labels[column], reason)


def write_history(path: str | Path, history: History) -> None:
    """Write probes.csv as a whole, in one atomic step."""
    lines = [history.labels, *(format_row(row) for row in history.rows)]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    write_whole(path, text.getvalue())


def format_row(row: Sequence[float]) -> list[str]:
    """Numbers as the shortest text that reads back as the same numbers."""
    return [repr(float(value)) for value in row]

"""The table of the validation cases for the documentation, made of the summaries of runs.

``warp-mps validate --out runs`` leaves a folder for each case; ``python -m warp_mps.app.validation_table runs`` prints
the table of all of them in Markdown.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warp_mps.results.formatting import duration
from warp_mps.results.summary import RunSummary, read_summary

HEADER = "| case | result | measured | reference | error | source of the reference |\n|---|---|--:|--:|--:|---|"
# the parts of the table: title, and whether a case of it has bodies and fluids
PARTS = (("Elastic bodies", (True, False)), ("Water", (False, True)), ("Water and elastic bodies", (True, True)))


def validation_table(summaries: Iterable[RunSummary]) -> str:
    """Markdown tables of what runs measured beside its references.

    Args:
        summaries: The runs; one that is not done is left out.

    Returns:
        A heading and a table for each of elastic bodies, water, and both, a row for each measurement; cases are in
        the order of their names.
    """
    done = sorted((run for run in summaries if run.status == "done"), key=lambda run: run.case)
    blocks = []
    for title, kind in PARTS:
        rows = [row for run in done if _kind(run) == kind for row in _rows(run)]
        if rows:
            blocks.append("\n".join([f"## {title}", "", HEADER, *rows]))
    return "\n\n".join(blocks) + "\n"


def _kind(run: RunSummary) -> tuple[bool, bool]:
    return bool(run.settings.get("bodies")), bool(run.settings.get("fluids"))


def _model(run: RunSummary) -> str:
    """The elastic model, the scheme of the fluids, or both."""
    bodies, fluids = _kind(run)
    names = [run.settings["elasticity"]["model"]] if bodies else []
    names += [run.settings["flow"]["scheme"]] if fluids else []
    return ", ".join(names)


def _rows(run: RunSummary) -> list[str]:
    """A row for each measurement; the case, its model and its time stand in the first, a source where it changes."""
    case, source, rows = f"`{run.case}`<br>{_model(run)}, {duration(run.wall_seconds)}", "", []
    for row in run.measurements:
        error = "" if row["error"] is None else f"{100.0 * row['error']:+.2f} %"
        unit = f" [{row['unit']}]" if row["unit"] not in ("", "-") else ""
        measured = row.get("reason") or "none" if row["value"] is None else _number(row["value"])
        cells = [case, row["name"] + unit, measured, _number(row["reference"]), error]
        cells.append(row["source"] if row["source"] != source else "")
        rows.append("| " + " | ".join(map(_cell, cells)) + " |")
        case, source = "", row["source"]
    return rows


def _number(value: Any) -> str:
    """Four significant digits, and whole numbers beyond."""
    if value is None:
        return ""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"


def _cell(text: str) -> str:
    """Text that does not end a cell or a row."""
    return " ".join(text.split()).replace("|", "\\|")


def main(folder: str) -> None:
    """Print the table of all runs in the folders of a folder.

    Raises:
        InputError: A file ``run.json`` is not the summary of a run.
    """
    print(validation_table(read_summary(path) for path in sorted(Path(folder).glob("*/run.json"))), end="")


if __name__ == "__main__":
    main(sys.argv[1])

"""Printed output of the commands: cases and results."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from warp_mps.results.formatting import percent
from warp_mps.results.summary import RunSummary, headline
from warp_mps.usd.shipped_cases import shipped_cases

WIDE = 300
ROOM_FOR_SOURCES = 130


def print_cases() -> int:
    """Print the shipped cases and the first line of each description."""
    from pxr import Sdf

    table = plain_table("case", "what it is")
    for name, path in shipped_cases().items():
        text = Sdf.Layer.OpenAsAnonymous(str(path)).documentation.strip()
        table.add_row(name, text.splitlines()[0] if text else "")
    console().print(table)
    return 0


def print_summary(summary: RunSummary, folder: Path) -> None:
    """Print how a run went and where its results are."""
    out = console()
    out.print(headline(summary), highlight=False, soft_wrap=True)
    if summary.measurements:
        print_measurements([(summary.case, row) for row in summary.measurements])
    out.print(f"results in {folder}", highlight=False, soft_wrap=True)


def print_measurements(rows: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Print measurements beside their references: case, result, measured, reference, error, source.

    On a narrow terminal the sources are listed below the table, by number.
    """
    out = console()
    sources = list(dict.fromkeys(row["source"] for _, row in rows if row["source"]))
    beside = out.width >= ROOM_FOR_SOURCES
    table = plain_table("case", "result", "measured", "reference", "error", *(["source"] * beside))
    last = ""
    for case, row in rows:
        reference = "" if row["reference"] is None else f"{row['reference']:.5g}"
        if not beside and row["source"]:
            reference += f" ({sources.index(row['source']) + 1})"
        measured = row.get("reason", "none") if row["value"] is None else f"{row['value']:.5g} {row['unit']}"
        cells = [measured, reference, percent(row["error"]), *([row["source"]] * beside)]
        table.add_row("" if case == last else case, row["name"], *cells)
        last = case
    out.print(table, highlight=False, markup=False)
    if not beside:
        for number, source in enumerate(sources, start=1):
            out.print(f"({number}) {source}", highlight=False, markup=False)


def console() -> Console:
    """Standard output; wide if it is not a terminal, so that lines of a log are not wrapped."""
    return Console() if sys.stdout.isatty() else Console(width=WIDE)


def plain_table(*columns: str) -> Table:
    """A table; its last column wraps on a narrow terminal."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns[:-1]:
        table.add_column(column, no_wrap=True)
    table.add_column(columns[-1], overflow="fold")
    return table

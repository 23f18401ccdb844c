"""Printed output of ``warp-mps check``."""

from __future__ import annotations

import shutil
from collections.abc import Iterable

from rich.table import Table

from warp_mps.app.printing import console, plain_table
from warp_mps.results.formatting import memory
from warp_mps.run.inventory.case_check import check
from warp_mps.run.inventory.text import cost_rows, item_rows
from warp_mps.scene import Scene


def print_check(scene: Scene, *, as_json: bool = False) -> int:
    """Print what a scene is and what a run of it would cost, and refuse a scene that the run would refuse.

    Raises:
        InputError: As `warp_mps.run.inventory.case_check.check`.
    """
    found = check(scene)
    out = console()
    if as_json:
        print(found.to_json())
        return 0
    free = shutil.disk_usage(".").free
    note = "" if 2.0 * found.cost.disk <= free else "  TOO MUCH: save fewer frames, by a lower mps:frameRate"
    out.print(_table([*cost_rows(found), ("free here", f"{memory(free)}{note}")]))
    out.print(_table(row for item in found.items for row in item_rows(item)))
    for line in found.remarks:
        out.print(line, highlight=False, soft_wrap=True)
    return 0


def _table(rows: Iterable[tuple[str, str]]) -> Table:
    table = plain_table("", "")
    table.show_header = False
    for name, value in rows:
        table.add_row(name, value)
    return table

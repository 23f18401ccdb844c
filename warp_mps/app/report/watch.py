"""Writing the page of a run, once or for as long as the run goes on."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

from warp_mps.app.animation_reader import refuse_existing
from warp_mps.app.report.page import write_report
from warp_mps.app.view.figures import require_format
from warp_mps.errors import InputError


def report_run(
    folder: Path,
    out: Path | None = None,
    *,
    overwrite: bool = False,
    interval: float | None = None,
    announce: Callable[[str], None] = print,
) -> Path:
    """Write the page of a run; with an interval, regenerate it until the run ends.

    Args:
        folder: Folder of the run.
        out: File to write, ending in ``.html``; None is report.html in the folder.
        overwrite: Whether to replace it.
        interval: Seconds between two pages; None writes one.
        announce: Called with the name of the file once it is there, and with remarks on what it leaves out.

    Returns:
        The file.

    Raises:
        InputError: There is no run in the folder, the file cannot be written, or the interval is invalid.
    """
    path = out or folder / "report.html"
    require_format(path, ("html",))
    if interval is not None and not (math.isfinite(interval) and interval >= 1.0):
        raise InputError("--interval", "", f"is {interval:g}, must be 1 or more seconds")
    refuse_existing(path, overwrite)
    state, remarks = write_report(folder, path, reload=interval)
    announce(str(path))
    while interval is not None and state == "running":
        time.sleep(interval)
        state, remarks = write_report(folder, path, reload=interval)
    for remark in remarks:
        announce(f"  {remark}")
    return path

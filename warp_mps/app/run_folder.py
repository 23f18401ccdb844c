"""The folder of a run: the names of its files, and its check."""

from __future__ import annotations

import os
from pathlib import Path

from warp_mps.errors import InputError

ANIMATION, PROBES, SUMMARY = "run.usdc", "probes.csv", "run.json"


def require_run(folder: Path, *names: str) -> None:
    """Refuse a folder without the files of a run.

    Args:
        folder: The folder.
        names: Files of which at least one must be there.

    Raises:
        InputError: The folder does not exist, or it has none of the files.
    """
    if not os.path.isdir(folder):
        reason = "is not a folder; give the output folder of `warp-mps run`, such as runs/CASE"
        raise InputError(str(folder), "", reason)
    if names and not any(os.path.isfile(folder / name) for name in names):
        missing = f"{names[0]} is missing" if len(names) == 1 else f"it has none of {', '.join(names)}"
        raise InputError(str(folder), "", f"does not contain a run: {missing}")

"""The cases that are shipped, by name."""

from __future__ import annotations

import difflib
import os
from pathlib import Path

from warp_mps.errors import InputError

SUFFIXES = (".usda", ".usdc", ".usd", ".usdz")


def stages_folder() -> Path:
    """Folder of the shipped stages: inside an installed package, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "stages"
    return installed if installed.is_dir() else package.parent / "stages"


def shipped_cases() -> dict[str, Path]:
    """Paths of the shipped stages, by name."""
    return {path.stem: path for path in sorted(stages_folder().glob("*.usda"))}


def find_case(case: str) -> Path:
    """Path of a case, given as a stage's path or as the name of a shipped one.

    Raises:
        InputError: There is neither.
    """
    path = Path(case)
    there = os.path.isfile(path)
    if path.suffix in SUFFIXES or there:
        if not there:
            raise InputError(case, "", "there is no such file")
        return path
    shipped = shipped_cases()
    if case not in shipped:
        meant = "".join(f"; did you mean {name}?" for name in difflib.get_close_matches(case, shipped, n=1))
        found = "is a folder" if path.is_dir() else "is neither a file nor a shipped case"
        raise InputError(case, "", f"{found}; give the path of a stage or a name of `warp-mps list`{meant}")
    return shipped[case]

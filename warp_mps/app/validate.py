"""Validation: run cases and print their measurements beside the references."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warp_mps.app.printing import print_measurements
from warp_mps.core.streams import say
from warp_mps.errors import RunError
from warp_mps.run.run import run_scene
from warp_mps.scene.choices import PrecisionName
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.shipped_cases import find_case, shipped_cases


def validate_cases(
    cases: Sequence[str], *, out: Path | None, device: str, precision: PrecisionName, allow_external: bool = False
) -> int:
    """Run cases and print a table of their measurements.

    Args:
        cases: Paths or names of cases; all shipped ones when empty.
        out: Folder that keeps the results, a folder for each case; None keeps nothing.
        device: Device to run on.
        precision: ``float64`` or ``float32``.
        allow_external: Whether a stage may refer to files outside its folder.

    Returns:
        0, or 3 when a case could not be finished.

    Raises:
        InputError: A case cannot be run.
    """
    paths = [find_case(case) for case in cases or shipped_cases()]
    with tempfile.TemporaryDirectory(prefix="warp-mps-") as scratch:
        outcomes = [_run(path, out or Path(scratch), device, precision, allow_external) for path in paths]
    print_measurements([row for rows, _ in outcomes for row in rows])
    return 0 if all(good for _, good in outcomes) else 3


def _run(
    path: Path, folder: Path, device: str, precision: PrecisionName, allow_external: bool
) -> tuple[list[tuple[str, dict[str, Any]]], bool]:
    """The measurements of a case and of its energy, and whether it came to its end."""
    say(f"running {path.stem}")
    scene = read_stage(path, allow_external=allow_external)
    try:
        summary = run_scene(scene, folder / scene.name, device=device, precision=precision, overwrite=True, quiet=True)
    except RunError as error:
        say(f"{path.stem}: {error}")
        return [], False
    rows = [*summary.measurements]
    if not summary.fluid:
        rows.append(_account("energy drift", summary.energy.get("drift")))
    rows.append(_account("momentum error", summary.momentum_error))
    return [(scene.name, row) for row in rows], True


def _account(name: str, value: float | None) -> dict[str, Any]:
    """A row for a number that should be zero."""
    source = "conservation"
    return {"name": name, "value": value, "unit": "", "reference": 0.0, "error": None, "source": source}

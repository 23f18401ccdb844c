"""The files of a run, finished or not; missing or damaged parts are reported, and the rest is shown."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from warp_mps.app.animation_reader import Animation
from warp_mps.app.run_folder import ANIMATION, PROBES, SUMMARY, require_run
from warp_mps.errors import InputError
from warp_mps.results.history import History, read_history
from warp_mps.results.summary import RunSummary, energy_record, read_summary
from warp_mps.run.locks import is_locked

# an animation that is being written is tried again: its file may have been replaced while it was opened
ATTEMPTS, PAUSE = 3, 0.3


@dataclass(frozen=True)
class Run:
    """The contents of the folder of a run.

    Attributes:
        folder: The folder.
        state: ``done``, ``running``, ``failed``, or ``stopped``: its process ended without writing a status.
        summary: Its summary; while it runs, brought up to date from the history.
        history: History; None if there is no row.
        animation: Animation; None if there is no frame.
        remarks: Missing or damaged parts, with the reason.
    """

    folder: Path
    state: str
    summary: RunSummary
    history: History | None
    animation: Animation | None
    remarks: tuple[str, ...]


def read_run(folder: Path) -> Run:
    """Read the folder of a run.

    Raises:
        InputError: There is no such folder, or nothing of a run in it.
    """
    require_run(folder, SUMMARY, PROBES, ANIMATION)
    remarks: list[str] = []
    summary, state = _read_state(folder, remarks)
    history = _read_history(folder, remarks)
    animation = _read_animation(folder, remarks)
    if summary is None:
        named = animation.provenance.get("case") if animation else None
        summary = RunSummary(case=str(named or folder.resolve().name), status="running")
    if state in ("running", "stopped") and history is not None:
        clouds = animation.clouds if animation else ()
        wet = any(cloud.role == "fluid" for cloud in clouds) or bool(summary.fluid)
        summary.time, summary.energy = history.last_time, energy_record(history, fluids=wet)
    return Run(folder, state, summary, history, animation, tuple(remarks))


def _read_state(folder: Path, remarks: list[str]) -> tuple[RunSummary | None, str]:
    """The summary, if there is one, and the state of the run."""
    summary = _read_summary(folder, remarks)
    if summary is not None and (summary.status != "running" or is_locked(folder) is not False):
        return summary, summary.status
    if summary is not None:
        # the run may have ended since: it writes its status before it releases the lock
        summary = _read_summary(folder, remarks)
    return summary, "stopped" if summary is None or summary.status == "running" else summary.status


def _read_summary(folder: Path, remarks: list[str]) -> RunSummary | None:
    try:
        return read_summary(folder / SUMMARY)
    except InputError as error:
        remarks.append(f"There is no summary of the run: {error.reason}.")
        return None


def _read_history(folder: Path, remarks: list[str]) -> History | None:
    try:
        history = read_history(folder / PROBES)
    except InputError as error:
        remarks.append(f"There are no diagrams: {PROBES} {error.reason}.")
        return None
    if history.rows:
        return history
    remarks.append(f"There are no diagrams: {PROBES} has no rows yet.")
    return None


def _read_animation(folder: Path, remarks: list[str]) -> Animation | None:
    if not (folder / ANIMATION).is_file():
        remarks.append("There is no animation: the run has saved no frame.")
        return None
    for attempt in range(ATTEMPTS):
        try:
            animation = Animation(folder)
            if any(len(cloud.ids) for cloud in animation.clouds):
                return animation
            reason = "has no particles"
            break
        except InputError as error:
            reason = error.reason
        if attempt + 1 < ATTEMPTS:
            time.sleep(PAUSE)
    remarks.append(f"There is no animation: {ANIMATION} {reason}.")
    return None

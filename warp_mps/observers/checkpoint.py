"""Checkpoints: the state of a run in a file, written atomically, for a restart."""

from __future__ import annotations

import hashlib
import json
import os
import time
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np

from warp_mps.core.interrupts import defer_interrupts
from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, View
from warp_mps.results.atomic_write import replacing
from warp_mps.results.regular_file import open_regular
from warp_mps.results.summary_check import is_number

# version of the format, raised whenever arrays or their meaning change: 2 since implicit solids have a coarse level and
# water is mirrored in its walls, 3 since it knows the rows and frames of its run, 4 since it holds the statistics and
# what the guards have seen
VERSION = 4
NAME = "checkpoint.npz"
PREVIOUS = "checkpoint.prev.npz"
METADATA = "metadata"
PREFIX = "state."
# changed settings that a refusal names
NAMED = 3


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run at one moment.

    Attributes:
        step: Number of steps done.
        time: Simulated time [s].
        arrays: Everything that evolves, by name.
        records: Facts about the run, by name: its rows and frames so far, its settings, what computed it.
    """

    step: int
    time: float
    arrays: dict[str, np.ndarray]
    records: dict[str, Any] = field(default_factory=dict)


class CheckpointWriter(Observer):
    """Keeps the state at the last look, and saves it every so many seconds and at the end.

    A state with NaN is never kept: the checkpoint of a run that diverged is its last finite state.

    Args:
        folder: Where checkpoint.npz goes; the one before it stays as checkpoint.prev.npz.
        fingerprint: Identity of the run, e.g. a hash of the case.
        every: Steps between two looks.
        interval: Wall seconds between two saves.
        records: Gives facts about the run at that moment, which JSON can hold.
        results: Files that a run continues from as well; they are on the disk before the checkpoint is.
        clock: Gives the wall time [s].
    """

    def __init__(
        self,
        folder: str | Path,
        fingerprint: str,
        *,
        every: int,
        interval: float = 60.0,
        records: Callable[[], dict[str, Any]] = dict,
        results: Sequence[Path] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.every = every
        self._folder = Path(folder)
        self._fingerprint = fingerprint
        self._interval, self._clock = interval, clock
        self._results, self._records = tuple(results), records
        self._last_save = clock()
        self._pending: Checkpoint | None = None

    def observe(self, view: View) -> None:
        """Keep the state, and save it when it is time to.

        Raises:
            RunError: The file cannot be written.
        """
        if not (np.isfinite(view.positions).all() and np.isfinite(view.velocities).all()):
            return
        self._pending = Checkpoint(view.step, view.time, view.state_arrays(), self._records())
        if self._clock() - self._last_save >= self._interval:
            self._save()

    def close(self) -> None:
        """Save the last state that was kept.

        Raises:
            RunError: The file cannot be written.
        """
        self._save()

    def _save(self) -> None:
        if self._pending is not None:
            # a second interrupt must not lose the state
            with defer_interrupts():
                for path in self._results:
                    _sync(path)
                save_checkpoint(self._folder, self._fingerprint, self._pending)
            self._pending = None
        self._last_save = self._clock()


def save_checkpoint(folder: Path, fingerprint: str, checkpoint: Checkpoint) -> None:
    """Save a checkpoint in one atomic step; the one before it becomes checkpoint.prev.npz.

    Raises:
        RunError: The file cannot be written.
    """
    metadata: dict[str, Any] = {
        "version": VERSION,
        "fingerprint": fingerprint,
        "step": checkpoint.step,
        "time": checkpoint.time,
        "records": checkpoint.records,
    }
    metadata["sha256"] = _digest(metadata, checkpoint.arrays)
    newest = folder / NAME
    try:
        with replacing(newest) as temporary:
            with temporary.open("wb") as file:
                _write(file, _entries(metadata, checkpoint.arrays))
                file.flush()
                os.fsync(file.fileno())
            if newest.exists():
                os.replace(newest, folder / PREVIOUS)
        _sync(folder)
    except OSError as error:
        raise RunError(f"{newest}: cannot be written: {error.strerror}") from error


def load_checkpoint(
    folder: str | Path,
    fingerprint: str,
    *,
    settings: Mapping[str, str] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Checkpoint:
    """Load the newest whole checkpoint of a folder.

    Args:
        folder: The folder.
        fingerprint: Identity that the checkpoint must have.
        settings: What decides the identity, by name; a refusal names those that the checkpoint has otherwise.
        announce: Called with a message if the newest is damaged and the one before it is taken.

    Raises:
        InputError: There is no checkpoint, or it belongs to another case or another version of the format.
    """
    found = [path for path in (Path(folder) / NAME, Path(folder) / PREVIOUS) if path.exists()]
    if not found:
        raise InputError(str(folder), "", "holds no checkpoint to resume from")
    for path in found:
        loaded = _read(path, fingerprint, settings or {})
        if loaded is not None:
            if path != found[0] and announce:
                announce(f"{found[0]} is damaged; going on from {path.name}, at {loaded.time:.6g} s")
            return loaded
    raise InputError(str(found[0]), "", "is damaged, and so is every earlier checkpoint; start a new run")


def _read(path: Path, fingerprint: str, settings: Mapping[str, str]) -> Checkpoint | None:
    """Read a checkpoint; None if it is truncated or altered."""
    try:
        with open_regular(path) as opened, np.load(opened, allow_pickle=False) as file:
            entries = {name: file[name] for name in file.files}
        metadata = json.loads(str(entries.pop(METADATA)))
        arrays = {name.removeprefix(PREFIX): array for name, array in entries.items()}
        checksum = metadata.pop("sha256")
    except Exception:  # damaged bytes can make the readers of zip files and of arrays raise almost any exception
        return None
    if metadata.get("version") != VERSION:
        text = f"has format version {metadata.get('version')}, this program reads {VERSION}; start a new run"
        raise InputError(str(path), "", text)
    if checksum != _digest(metadata, arrays):
        return None
    step, moment, records = (metadata.get(name) for name in ("step", "time", "records"))
    sound = is_number(moment) and is_number(step) and isinstance(step, int) and isinstance(records, dict)
    if not sound or step < 0 or moment < 0.0:
        return None
    if metadata.get("fingerprint") != fingerprint:
        changed = _changes(records.get("settings"), settings)
        text = "belongs to another case, precision or version of the program, or the case has changed"
        raise InputError(str(path), "", f"{text}{changed}; start a new run")
    return Checkpoint(step, moment, arrays, records)


def _changes(before: object, now: Mapping[str, str]) -> str:
    """The settings that are others now, `NAMED` of them by name."""
    if not isinstance(before, dict):
        return ""
    names = [name for name in {**before, **now} if before.get(name) != now.get(name)]
    texts = [f"{name} was {before.get(name, 'absent')}, is {now.get(name, 'absent')}" for name in names[:NAMED]]
    return ": " * bool(names) + "; ".join(texts) + f"; and {len(names) - NAMED} more" * (len(names) > NAMED)


def _entries(metadata: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    # the prefix keeps the names from meeting the metadata's
    state = {PREFIX + name: np.asarray(array) for name, array in arrays.items()}
    return {METADATA: np.array(json.dumps(metadata)), **state}


def _write(file: IO[bytes], entries: Mapping[str, Any]) -> None:
    """Write a file for `numpy.load` without time stamps: a zip file cannot hold one before 1980, or after 2107."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in entries.items():
            with archive.open(zipfile.ZipInfo(name + ".npy"), "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asanyarray(array), allow_pickle=False)


def _digest(metadata: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """SHA-256 of the metadata and of the arrays' names, types, shapes and bytes."""
    digest = hashlib.sha256(json.dumps(metadata, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {np.shape(arrays[name])}\n".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _sync(path: Path) -> None:
    """Flush a file, or the names in a folder, to the disk, where the system can.

    Raises:
        OSError: The file is gone, or the disk reports an error.
    """
    if os.name == "posix":
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

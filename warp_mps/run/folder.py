"""The folder of a run: what lies in it, whether it can be written, and the restart from its checkpoint."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from warp_mps.errors import InputError
from warp_mps.observers import checkpoint as checkpoint_file
from warp_mps.observers.checkpoint import Checkpoint, load_checkpoint
from warp_mps.results.atomic_write import remove_left_behind

ANIMATION, PROBES, SUMMARY = "run.usdc", "probes.csv", "run.json"
RESULTS = (SUMMARY, PROBES, ANIMATION, checkpoint_file.NAME, checkpoint_file.PREVIOUS)


def require_folder(folder: str | Path) -> Path:
    """The path of a folder of results.

    Raises:
        InputError: It is empty, it is not UTF-8, which USD needs, or the system takes no such name.
    """
    text = os.fspath(folder)
    if not text:
        raise InputError("", "folder", "is empty; give the folder of the results, or . for this one")
    try:
        os.path.abspath(text).encode()
    except UnicodeEncodeError:
        raise InputError(
            ascii(os.path.abspath(text)), "", "cannot be used: its path is not UTF-8, which USD needs"
        ) from None
    try:
        os.lstat(text)
    except (FileNotFoundError, NotADirectoryError):
        pass
    except OSError as error:
        raise InputError(text, "", f"cannot be written: {error.strerror}") from None
    return Path(folder)


def claim_folder(
    folder: Path,
    fingerprint: str,
    *,
    settings: Mapping[str, str],
    overwrite: bool,
    resume: bool,
    announce: Callable[[str], None],
) -> Checkpoint | None:
    """Make sure that the folder can be written and that no results in it are lost.

    Args:
        folder: The folder.
        fingerprint: Hash of the case, which a checkpoint must have been made with.
        settings: What the hash is of, by name.
        overwrite: Whether results in the folder are to be replaced.
        resume: Whether the run continues from the folder's checkpoint.
        announce: Called with a message if a damaged checkpoint is passed over.

    Returns:
        The checkpoint to continue from, or None.

    Raises:
        InputError: The folder cannot be used so.
    """
    if overwrite and resume:
        raise InputError(str(folder), "", "give either --overwrite or --resume, not both")
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(str(folder), "", "is a file; the output must be a folder")
    # the folder is locked, so that they belong to no run that is at work
    remove_left_behind(folder, *RESULTS)
    if resume:
        return load_checkpoint(folder, fingerprint, settings=settings, announce=announce)
    found = [name for name in RESULTS if os.path.lexists(folder / name)]
    if found and not overwrite:
        raise InputError(
            str(folder),
            "",
            f"already has results, {found[0]}; use --overwrite to replace or --resume to continue them "
            "(in Python overwrite=True or resume=True)",
        )
    _refuse_unwritable(folder)
    return None


def remove_results(folder: Path) -> None:
    """Remove the results of an earlier run, so that none of them can be mistaken for this one's."""
    for name in RESULTS:
        if name == PROBES:
            continue  # of this run already
        (folder / name).unlink(missing_ok=True)


def _refuse_unwritable(folder: Path) -> None:
    parent = folder
    while not os.path.exists(parent):
        parent = parent.parent
    if not os.path.isdir(parent):
        raise InputError(str(folder), "", f"cannot be made: {parent} is a file")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError(str(folder), "", f"cannot be written: no permission in {parent}")

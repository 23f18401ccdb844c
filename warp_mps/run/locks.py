"""A folder that belongs to one run at a time."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from warp_mps.errors import InputError

NAME = ".lock"


@contextlib.contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder, which is made if need be.

    The lock is the system's (flock), so that it ends with the process, however that ends. A system or a file system
    without locks, and a folder that cannot be written, are used without one. The lock file is removed, and so is a
    folder that was made and is still empty.

    Raises:
        InputError: Another run is at work in the folder.
    """
    made = _make(folder)
    try:
        handle = _lock(folder)
        try:
            yield
        finally:
            if handle is not None:
                # removed while it is still held: a process that waits with the old file open finds it removed;
                # a lock file that cannot be removed does no harm
                with contextlib.suppress(OSError):
                    (folder / NAME).unlink()
                os.close(handle)
    finally:
        with contextlib.suppress(OSError):
            for part in made:
                part.rmdir()


def is_locked(folder: Path) -> bool | None:
    """Whether a run is at work in a folder; None if the system has no locks."""
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    try:
        handle = _open(folder / NAME, os.O_RDONLY)
    except FileNotFoundError:
        return False
    except (OSError, InputError):
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # a file system without locks
        return None
    finally:
        os.close(handle)
    return False


def _make(folder: Path) -> list[Path]:
    """Make a folder; the folders that were not there, the innermost first."""
    missing = []
    for part in (folder, *folder.parents):
        if os.path.exists(part):
            break
        missing.append(part)
    # a later write reports why the folder cannot be made
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return missing


def _lock(folder: Path) -> int | None:
    """Lock a folder; the open file that holds the lock, or None where there are no locks.

    Raises:
        InputError: Another run holds it.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    while True:
        try:
            handle = _open(folder / NAME, os.O_RDWR | os.O_CREAT)
        except OSError:
            return None
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_current(handle, folder / NAME):
                # on a full disk the lock holds without a number in its file
                with contextlib.suppress(OSError):
                    os.ftruncate(handle, 0)
                    os.write(handle, str(os.getpid()).encode())
                return handle
        except BlockingIOError:
            holder = os.read(handle, 20).decode(errors="replace").strip()
            os.close(handle)
            holding = f"process {holder}" if holder.isdigit() else "another process"
            raise InputError(
                str(folder), "", f"is in use by the run of {holding}; give another folder or wait"
            ) from None
        except OSError:  # a file system without locks, or a full one
            os.close(handle)
            return None
        os.close(handle)


def _open(path: Path, flags: int) -> int:
    """Open the file of a lock, without following a link or waiting for a pipe.

    Raises:
        InputError: It is a link, a pipe, or another name of a file.
        OSError: It cannot be opened.
    """
    try:
        handle = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    except OSError as error:
        # what Linux and BSD say of a link and of a folder
        if error.errno in (errno.ELOOP, errno.EMLINK, errno.EISDIR):
            raise _foreign(path) from None
        raise
    found = os.fstat(handle)
    if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1:
        os.close(handle)
        raise _foreign(path)
    return handle


def _foreign(path: Path) -> InputError:
    return InputError(str(path), "", "is no file of its own, as a run makes it to lock its folder; remove it")


def _is_current(handle: int, path: Path) -> bool:
    """Whether a file that was opened is still the one of that name: its last owner may have removed it."""
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False

"""Files that are written atomically, and never through a link that lies in their folder."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import IO

# how the name of a temporary file begins; those that a killed process left behind are removed by the next run
MARK = ".new."
# characters of a file's name that its temporary file has as well, so that no name becomes too long
SHARED = 60


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A new, empty file beside another one, which it replaces after the body.

    Its name cannot be guessed and ends like that of the other file. If the body or the replacement fails, it is removed
    and the other file stays.

    Raises:
        OSError: It cannot be made, or the other one cannot be replaced.
    """
    temporary = path.with_name(f"{MARK}{secrets.token_hex(4)}.{path.name[-SHARED:]}")
    try:
        with create_file(temporary):
            pass
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def create_file(path: Path) -> IO[bytes]:
    """Create a file that is not there, neither as a file nor as a link, and open it to write.

    Raises:
        OSError: It is there, or it cannot be made.
    """
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666), "wb")


def write_whole(path: str | Path, text: str) -> None:
    """Write a text file in one atomic step.

    Raises:
        OSError: It cannot be written; an existing file stays, and no temporary file is left.
    """
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        file.write(text.encode())
        file.flush()
        os.fsync(file.fileno())


def remove_left_behind(folder: Path, *names: str) -> None:
    """Remove the temporary files of some names that a process left behind when it was killed."""
    for name in names:
        for path in folder.glob(f"{MARK}*.{name[-SHARED:]}"):
            path.unlink(missing_ok=True)

"""Files in a folder of results, which others may have filled: no pipe, which would never end, and no folder."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import IO

NOT_REGULAR = "Not a regular file"


def open_regular(path: str | Path, flags: int = os.O_RDONLY) -> IO[bytes]:
    """Open a file that exists.

    Args:
        path: The file.
        flags: Flags of `os.open`; without ``O_NOFOLLOW`` a link is followed.

    Raises:
        OSError: It cannot be opened, or it is a pipe, a device, a socket or a folder.
    """
    # opened without waiting for the other end of a pipe
    handle = os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, NOT_REGULAR, str(path))
    return os.fdopen(handle, "rb" if flags & (os.O_WRONLY | os.O_RDWR) == 0 else "ab")


def read_regular(path: str | Path) -> str:
    """Read a text in UTF-8.

    Raises:
        OSError: As `open_regular`.
        UnicodeDecodeError: It is not UTF-8.
    """
    with open_regular(path) as file:
        return file.read().decode("utf-8")

"""What native libraries write to the error stream, past Python."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator
from typing import IO

from warp_mps.core.warp_turn import Turn

# the stream belongs to the process: of two threads that divert it at a time, one would leave it diverted
_stream = Turn()


@contextlib.contextmanager
def native_errors() -> Iterator[IO[bytes]]:
    """Divert the process's error stream, so that a native library's lines do not reach the terminal.

    Yields:
        The file that receives the lines instead; it is empty where the stream is closed, which diverts nothing.
    """
    with _stream, _temporary() as diverted:
        try:
            stream = sys.__stderr__.fileno() if sys.__stderr__ else 2
            saved = os.dup(stream)
        except (OSError, ValueError):
            yield diverted
            return
        os.dup2(diverted.fileno(), stream)
        try:
            yield diverted
        finally:
            os.dup2(saved, stream)
            os.close(saved)


def _temporary() -> IO[bytes]:
    """A file that receives lines, or none where no folder takes temporary files."""
    try:
        return tempfile.TemporaryFile()
    except OSError:
        return open(os.devnull, "r+b")

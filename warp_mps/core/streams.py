"""Standard output and error that may be closed, broken or full: what cannot be written there stops no run."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO


class PatientStream:
    """A text stream whose errors are kept instead of raised; characters that it lacks are escaped.

    Attributes:
        failure: The first error, None while there is none.

    Args:
        stream: The stream, None where the process has none.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self.failure: Exception | None = None
        self._stream = stream
        # such as those of a file name in a terminal of another encoding
        with contextlib.suppress(AttributeError, OSError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]

    def write(self, text: str) -> int:
        """Write a text if that is possible; its length."""
        try:
            if self._stream is not None:
                self._stream.write(text)
        except (OSError, ValueError) as error:
            self._fail(error)
        return len(text)

    def flush(self) -> None:
        """Flush if that is possible."""
        try:
            if self._stream is not None:
                self._stream.flush()
        except (OSError, ValueError) as error:
            self._fail(error)

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        with contextlib.suppress(OSError, ValueError):
            return self._stream is not None and self._stream.isatty()
        return False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _fail(self, error: Exception) -> None:
        if self.failure is None:
            self.failure = error
            # what is left in the buffer would fail again when Python ends, which then exits with 120
            with contextlib.suppress(OSError, ValueError, AttributeError):
                nothing = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nothing, self._stream.fileno())  # type: ignore[union-attr]
                os.close(nothing)


def say(message: str) -> None:
    """Print a line of the program on standard error, if that can be written."""
    stream = PatientStream(sys.stderr)
    stream.write(f"warp-mps: {message}\n")
    stream.flush()


def reserve_descriptors() -> None:
    """Open those of the descriptors 0, 1 and 2 that are closed: libraries print to them, whatever file they are."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # the lowest free number is the one that is missing
            os.open(os.devnull, os.O_RDWR)


@contextlib.contextmanager
def patient_streams() -> Iterator[tuple[PatientStream, PatientStream]]:
    """Replace `sys.stdout` and `sys.stderr` by patient ones in the body, and flush them after it."""
    reserve_descriptors()
    before = sys.stdout, sys.stderr
    streams = PatientStream(sys.stdout), PatientStream(sys.stderr)
    sys.stdout, sys.stderr = streams
    try:
        yield streams
    finally:
        for stream in streams:
            stream.flush()
        sys.stdout, sys.stderr = before

"""A stage opened in a process of its own: USD trusts the files that it reads, and a damaged one can end the process."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import IO

from warp_mps.errors import InputError

# processor time that USD may take to compose a stage [s], and how much more for every megabyte of its file
CPU_TIME, CPU_TIME_PER_MEGABYTE = 6.0, 1.0
# wall time in units of that: so much for processors that are shared with others, and for a process that only waits
WALL_TIME = 20.0
# memory that it may take [bytes], and how many times the size of its file more
MEMORY, MEMORY_PER_BYTE = 2 * 2**30, 50
READY = b"ready\n"
# exit code where the memory does not suffice
TOO_LARGE = 3
# what USD prints when a binary file refers to places beyond its end
BEYOND, BEYOND_MEANS = b"posix_madvise", "it refers to what lies beyond its end"


def open_isolated(path: str | Path, *, allow_external: bool) -> None:
    """Open a stage and read every value in a process of its own; errors that USD reports itself are left to the caller.

    Args:
        path: File of the stage.
        allow_external: Whether it may refer to files outside its folder.

    Raises:
        InputError: The process did not survive it, or took more processor time, or far more wall time, than allowed.
    """
    # no wall time: on a busy machine a good stage may wait for most of that
    allowed = CPU_TIME + CPU_TIME_PER_MEGABYTE * os.path.getsize(path) / 2**20
    root = str(Path(__file__).parents[3])
    # without the folder that the user happens to be in, whose files must not pass for modules
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([root, *filter(None, sys.path)]), "PYTHONSAFEPATH": "1"}
    # each thread would take memory
    environment["PXR_WORK_THREAD_LIMIT"] = "1"
    command = [
        sys.executable,
        "-m",
        "warp_mps.usd.case.isolated_process",
        os.path.abspath(path),
        str(allowed),
        *["external"] * allow_external,
    ]
    with tempfile.TemporaryFile() as errors, _start(command, environment, errors) as process:
        assert process.stdout is not None
        # the time that it takes to start is not that of the stage
        good = process.stdout.readline() == READY
        timer = threading.Timer(WALL_TIME * allowed, process.kill)
        timer.start()
        code = process.wait()
        late = not timer.is_alive()
        timer.cancel()
        errors.seek(0)
        beyond = BEYOND in errors.read()
    if good and code == 0 and not beyond:
        return
    if late:
        raise InputError(str(path), "", f"takes USD more than {WALL_TIME * allowed:.0f} s of wall time to compose")
    if _name(code) == "SIGXCPU":
        raise InputError(str(path), "", f"takes USD more than {allowed:.0f} s of processor time to compose")
    raise damaged(path, BEYOND_MEANS if beyond else f"USD fails on it, {_name(code)}")


def damaged(path: str | Path, how: str) -> InputError:
    """The error of a file that USD cannot be trusted with."""
    return InputError(str(path), "", f"is damaged: {how}")


def _start(command: list[str], environment: dict[str, str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": errors}
    return subprocess.Popen(command, env=environment, **pipes)  # type: ignore[call-overload]


def _name(code: int) -> str:
    """Name of the signal or exit code that ended a process."""
    if code == TOO_LARGE:
        return "out of memory"
    with contextlib.suppress(ValueError):
        return signal.Signals(-code).name
    return f"exit code {code}"

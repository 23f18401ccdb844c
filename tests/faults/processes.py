"""Runs in processes of their own, which can be killed, interrupted, and deprived of disk and permissions."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.faults.cases import Case

# wall time after which a process has no progress, on a busy machine as well [s]
PATIENCE = 300.0
# of linux/prctl.h and linux/capability.h
PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2


@contextlib.contextmanager
def running(
    case: Case, out: Path, *options: str, prepare: Callable[[], None] | None = None
) -> Iterator[subprocess.Popen]:
    """A run that saves a checkpoint at every frame; it is killed at the end of the block if it has not ended."""
    command = [sys.executable, "-m", "warp_mps", "run", str(case.stage), "--out", str(out), "--quiet"]
    command += ["--checkpoint-interval", "0", *options]

    def begin() -> None:
        # the tests themselves may run where a shell or nohup ignores signals
        for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        if prepare:
            prepare()

    # the tests start no threads, and the function takes no lock
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=begin)  # noqa: PLW1509
    with process:
        try:
            yield process
        finally:
            process.kill()


def wait_for_rows(process: subprocess.Popen, out: Path, rows: int) -> None:
    """Wait until probes.csv has some rows, or the run has ended."""
    end = time.monotonic() + PATIENCE
    path = out / "probes.csv"
    while process.poll() is None and not (path.exists() and path.read_bytes().count(b"\n") > rows):
        assert time.monotonic() < end, "the run makes no progress"
        time.sleep(0.002)


def ending(process: subprocess.Popen) -> tuple[int, str]:
    """Exit code and the one line of a run that ends by itself."""
    _, errors = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in errors, errors
    lines = errors.splitlines()
    assert len(lines) <= 1, errors
    return process.returncode, "".join(lines)


def obey_permissions() -> None:
    """Let a process that root starts obey the permissions of files, as any other user's does."""
    library = ctypes.CDLL(None, use_errno=True)
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        library.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)

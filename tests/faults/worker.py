"""Commands in a process of their own, which a watchdog kills when one hangs, crashes or takes too much memory.

As a script it is that process: it takes commands as lines of JSON, and answers each with a line.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import select
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

# address space of a worker [bytes]
MEMORY = 6 * 2**30
# resident memory above which a command has failed [bytes]
RESIDENT = 3 * 2**30
# how much more processor time a run may take, which may be the first one of its kind [s]
COMPILING = 120.0
# wall time in units of processor time after which a command hangs
IDLENESS = 10.0
# how often the processor time of a command is looked at [s]
INTERVAL = 0.5


@dataclass(frozen=True)
class Ending:
    """How a command ended.

    Attributes:
        code: Exit code; -1 if it did not end by itself.
        out: What it printed.
        err: What it printed as errors, the worker's and USD's own included.
        seconds: How long it took [s].
        resident: The most memory that was resident [bytes].
    """

    code: int
    out: str = ""
    err: str = ""
    seconds: float = 0.0
    resident: int = 0


class Worker:
    """Runs commands one by one, in a process that is restarted after it was killed.

    Args:
        patience: Processor time that a command may take [s]; a run takes up to `COMPILING` more. Waiting counts for
            one part in `IDLENESS`, since a busy machine lets a process wait, but a command that only waits also hangs.
    """

    def __init__(self, patience: float = 10.0) -> None:
        self._patience = patience
        self.process: subprocess.Popen | None = None

    def run(self, arguments: Sequence[str]) -> Ending:
        """Run ``warp-mps`` with some arguments."""
        process = self.process = self.process or self._start()
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            process.stdin.write(json.dumps(list(arguments)) + "\n")
            process.stdin.flush()
        begin = time.monotonic()
        patience = self._patience + (COMPILING if arguments[0] == "run" else 0.0)
        ready = _answers(process, patience)
        answer = process.stdout.readline() if ready else ""
        if answer:
            return Ending(**json.loads(answer))
        seconds, code = time.monotonic() - begin, process.poll() if not ready else process.wait()
        self.close()
        return Ending(-1, err="hangs" if not ready else f"the process died: exit {code}", seconds=seconds)

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            with contextlib.suppress(BrokenPipeError):
                self.process.communicate()
            self.process = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self) -> subprocess.Popen:
        command = [sys.executable, "-m", "tests.faults.worker"]
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        root = Path(__file__).parents[2]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        process = subprocess.Popen(command, cwd=root, env=environment, **pipes)
        assert process.stdout is not None
        process.stdout.readline()  # it says when it is there
        return process


def _answers(process: subprocess.Popen, patience: float) -> bool:
    """Whether a process prints something, or ends, before it has used up its time."""
    begin, begun = time.monotonic(), _processor_time(process.pid)
    while True:
        left = IDLENESS * patience - (time.monotonic() - begin)
        ready, _, _ = select.select([process.stdout], [], [], max(min(left, INTERVAL), 0.0))
        if ready:
            return True
        if left <= 0.0 or _processor_time(process.pid) - begun > patience:
            return False


def _processor_time(pid: int) -> float:
    """Processor time of a process and of its children that have ended [s]; 0 if it is gone."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except FileNotFoundError:
        return 0.0
    # utime, stime, cutime and cstime of proc_pid_stat(5), after the name, which may hold anything
    return sum(map(int, text.rpartition(")")[2].split()[11:15])) / os.sysconf("SC_CLK_TCK")


def serve() -> None:
    """Take commands until there are no more."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    from warp_mps.app.cli import main

    # what USD prints itself goes to the descriptors
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    print("ready", file=answers)
    for line in sys.stdin:
        print(json.dumps(asdict(_timed(main, json.loads(line)))), file=answers)


def _timed(main: Callable[[Sequence[str]], int], arguments: Sequence[str]) -> Ending:
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # resets the peak of resident memory
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        kept = [os.dup(number) for number in (1, 2)]
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        begin = time.monotonic()
        try:
            code = main(arguments)
        except SystemExit as error:
            code = error.code if isinstance(error.code, int) else 1
        except BaseException:
            traceback.print_exc()
            code = 1
        seconds = time.monotonic() - begin
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):
                stream.flush()
        for number, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, number)
            os.close(copy)
        texts = [_text(file) for file in (out, err)]
    return Ending(code, *texts, seconds=seconds, resident=_peak())


def _text(file: object) -> str:
    file.seek(0)
    return file.read().decode("utf-8", "backslashreplace")


def _peak() -> int:
    """The most memory that was resident [bytes]."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


if __name__ == "__main__":
    serve()

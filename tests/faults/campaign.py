"""The faults, one function each; as a script, many of them at random moments, and a table of the outcomes.

``python -m tests.faults.campaign [KILLS]`` takes some seconds a fault.
"""

from __future__ import annotations

import contextlib
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.faults.cases import SCENES, Case, assert_continues, assert_readable, make_case
from tests.faults.processes import ending, obey_permissions, running, wait_for_rows

Fault = Callable[[Case, Path, int], str]


def killed(case: Case, out: Path, rows: int) -> str:
    """Kill a run at once, as the system does that runs out of memory."""
    random = np.random.default_rng(rows)
    with running(case, out) as process:
        wait_for_rows(process, out, rows)
        time.sleep(random.uniform(0.0, 0.02))
        process.kill()
        process.wait()
        return f"exit {process.returncode}"


def terminated(case: Case, out: Path, rows: int) -> str:
    """End a run as a batch system does whose time is up."""
    return _interrupted(case, out, rows, signal.SIGTERM)


def hung_up(case: Case, out: Path, rows: int) -> str:
    """Close the terminal of a run."""
    return _interrupted(case, out, rows, signal.SIGHUP)


def interrupted_twice(case: Case, out: Path, rows: int) -> str:
    """Ctrl-C, and again as it takes too long."""
    return _interrupted(case, out, rows, signal.SIGINT, signal.SIGINT)


def full(case: Case, out: Path, rows: int) -> str:
    """The disk is full: the next write, often of a row, is cut short."""
    return _full(case, out, rows, lambda: (out / "probes.csv").stat().st_size + 10, "")


def full_for_a_checkpoint(case: Case, out: Path, rows: int) -> str:
    """No further checkpoint can be written, while rows and frames can: a folder is in the place of the one before."""
    before = out / "checkpoint.prev.npz"
    with running(case, out) as process:
        wait_for_rows(process, out, rows)
        while process.poll() is None:
            # the run may put the file back in between
            with contextlib.suppress(OSError):
                before.unlink(missing_ok=True)
                before.mkdir()
                break
        code, line = ending(process)
    assert (code, "checkpoint.npz: cannot be written: Is a directory" in line) == (3, True), (code, line)
    before.rmdir()
    return line


def full_for_a_frame(case: Case, out: Path, rows: int) -> str:
    """The disk takes no further frame, when the animation has grown beyond a checkpoint."""
    size = (case.whole / "checkpoint.npz").stat().st_size
    return _full(case, out, rows, lambda: max((out / "run.usdc").stat().st_size, size + 1), "usdc")


def removed(case: Case, out: Path, rows: int) -> str:
    """Somebody removes the folder."""
    away = out.with_name(f"{out.name}_away")
    with running(case, out) as process:
        wait_for_rows(process, out, rows)
        out.rename(away)
        code, line = ending(process)
    assert (code, "cannot be written" in line) == (3, True), line
    assert not out.exists(), "a removed result does not come back in part"
    away.rename(out)
    return line


def write_protected(case: Case, out: Path, rows: int) -> str:
    """Somebody takes the permission to write in the folder; until it is given back, nothing can go on there."""
    with running(case, out, prepare=obey_permissions) as process:
        wait_for_rows(process, out, rows)
        out.chmod(0o555)
        code, line = ending(process)
    assert (code, "Permission denied" in line) == (3, True), line
    with running(case, out, "--resume", prepare=obey_permissions) as process:
        again = ending(process)
    out.chmod(0o755)
    assert (again[0], "cannot be written" in again[1]) == (2, True), again
    return line


def _interrupted(case: Case, out: Path, rows: int, *signals: signal.Signals) -> str:
    random = np.random.default_rng(rows)
    with running(case, out) as process:
        wait_for_rows(process, out, rows)
        for number in signals:
            process.send_signal(number)
            time.sleep(random.uniform(0.0, 0.01))
        code, line = ending(process)
    kept = (out / "checkpoint.npz").exists()
    assert (code, "continue with --resume" in line) == (128 + signals[0], kept), (code, line)
    assert '"status": "failed"' in (out / "run.json").read_text()
    return line


def _full(case: Case, out: Path, rows: int, limit: Callable[[], int], expected: str) -> str:
    """Limit the size of files: a write beyond it fails, as on a full disk."""
    with running(case, out) as process:
        wait_for_rows(process, out, rows)
        size = limit()
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (size, size))
        code, line = ending(process)
    assert code == 3, (code, line)
    assert expected in line, line
    assert "cannot be written" in line, line
    return line


FAULTS: dict[str, Fault] = {
    "kill -9": killed,
    "SIGTERM": terminated,
    "SIGHUP": hung_up,
    "Ctrl-C twice": interrupted_twice,
    "disk full": full,
    "disk full, checkpoint": full_for_a_checkpoint,
    "disk full, frame": full_for_a_frame,
    "folder removed": removed,
    "folder write-protected": write_protected,
}


def endure(fault: Fault, case: Case, out: Path, rows: int) -> tuple[str, float]:
    """Inflict a fault, and see that nothing is lost; how the run ended, and where it continued to its end [s]."""
    how = fault(case, out, rows)
    assert_readable(case, out)
    return how, assert_continues(case, out)


def main(kills: int = 50) -> int:
    """Go through all faults and print the outcome of every run; the number of lost runs."""
    random = np.random.default_rng(0)
    lost = 0
    with tempfile.TemporaryDirectory() as scratch:
        cases = [make_case(name, Path(scratch)) for name in SCENES]
        plan = [("kill -9", cases[k % len(cases)]) for k in range(kills)]
        plan += [(name, case) for name in list(FAULTS)[1:] for case in cases]
        for number, (name, case) in enumerate(plan):
            out = Path(scratch) / f"run{number}"
            rows = int(random.integers(1, 50))
            try:
                how, start = endure(FAULTS[name], case, out, rows)
                verdict = f"continues from {start:.3f} s to the same bits" if start >= 0 else "starts again"
            except Exception as error:
                lost, how, verdict = lost + 1, f"{type(error).__name__}: {error}", "LOST"
            print(f"{name:24}{case.name:9}row {rows:3}  {verdict:40}  {how}", flush=True)
            shutil.rmtree(out, ignore_errors=True)
    return lost


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))

"""Signals at random moments of runs, from the command line and from Python: results are kept, and continue.

As a script, ``python -m tests.faults.signals_campaign [EACH [SEED]]``, it sends each signal so often to each kind of
program and prints what became of them.
"""

from __future__ import annotations

import collections
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.faults.cases import Case, assert_continues, make_case
from tests.faults.processes import PATIENCE, wait_for_rows

SIGNALS = (signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGPIPE)
SCRIPT = """
import sys
import warp_mps as mps

mps.run_scene(mps.read_stage(sys.argv[1]), sys.argv[2], quiet=True, checkpoint_interval=0.0)
"""
# part of the signals that may come before the first row, within a time from the start [s]; else some time after a row
EARLY, START, LATER = 0.3, 2.0, 0.03
# exit codes of a command that was asked to stop; Python programs die of the signal itself
CODES = {signal.SIGHUP: 129, signal.SIGTERM: 143, signal.SIGINT: 130}


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        program: ``command`` or ``python``.
        signal: Name of the signal.
        what: When it came.
        code: Exit code of the program.
        kept: What ``run.json`` says of the run; empty without a result.
        fault: What is wrong with how it ended; empty if nothing is.
    """

    program: str
    signal: str
    what: str
    code: int
    kept: str
    fault: str


def campaign(each: int, *, seed: int = 0) -> Iterator[Outcome]:
    """Send each signal so often to each kind of program."""
    with tempfile.TemporaryDirectory() as scratch:
        case = make_case("solid", Path(scratch))
        for index, number in enumerate(SIGNALS):
            for program in ("command", "python"):
                random = np.random.default_rng([seed, index, program == "python"])
                for _ in range(each):
                    out = Path(scratch) / "out"
                    yield _send(case, out, program, number, random)
                    shutil.rmtree(out, ignore_errors=True)


def _send(case: Case, out: Path, program: str, number: signal.Signals, random: np.random.Generator) -> Outcome:
    command = [sys.executable, "-m", "warp_mps", "run", str(case.stage), "--out", str(out), "--quiet"]
    command += ["--checkpoint-interval", "0"]
    if program == "python":
        command = [sys.executable, "-c", SCRIPT, str(case.stage), str(out)]
    # a shell may ignore signals for the jobs that it starts
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=_obey)  # noqa: PLW1509
    with process:
        if random.random() < EARLY:
            delay, what = random.uniform(0.0, START), "from the start"
        else:
            rows, delay = int(random.integers(1, 110)), random.uniform(0.0, LATER)
            what = f"after row {rows}"
            wait_for_rows(process, out, rows)
        time.sleep(delay)
        process.send_signal(number)
        try:
            _, errors = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            return Outcome(program, number.name, what, 1, "", "does not end")
    kept = json.loads((out / "run.json").read_text())["status"] if (out / "run.json").exists() else ""
    found = _fault(program, number, process.returncode, kept, errors)
    if not found and kept:
        try:
            assert_continues(case, out)
        except Exception as error:
            found = f"does not continue: {error!r}"[:300]
    return Outcome(program, number.name, f"{what} and {delay:.3f} s", process.returncode, kept, found)


def _obey() -> None:
    for number in CODES:
        signal.signal(number, signal.SIG_DFL if number != signal.SIGINT else signal.default_int_handler)


def _fault(program: str, number: signal.Signals, code: int, kept: str, errors: str) -> str:
    """What is wrong with an end; before a run has begun, and after it is done, the program dies as any other."""
    if code == 0:
        return "" if kept == "done" and not errors else f"exit 0, {kept or 'no result'}: {errors[-200:]}"
    if number == signal.SIGPIPE:
        return f"exit {code} by a signal that Python ignores: {errors[-200:]}"
    if kept == "running":
        return f"exit {code}, and run.json says 'running'"
    allowed = {-number} if program == "python" else {CODES[number]} | ({-number} if kept in ("", "done") else set())
    if code not in allowed:
        return f"exit {code}: {errors[-200:]}"
    if program == "command" and code > 0 and len(errors.splitlines()) != 1:
        return f"{len(errors.splitlines())} lines: {errors[-200:]}"
    return ""


def main(each: int = 25, seed: int = 0) -> int:
    """Go through the campaign and print a table; the number of faults."""
    table: dict[tuple[str, str], collections.Counter] = collections.defaultdict(collections.Counter)
    for outcome in campaign(each, seed=seed):
        row = table[outcome.signal, outcome.program]
        row[f"exit {outcome.code}, {outcome.kept or 'not begun'}"] += 1
        if outcome.fault:
            row["FAULTS"] += 1
            print(f"{outcome.signal} {outcome.program} {outcome.what}: {outcome.fault}", flush=True)
    for (name, program), row in table.items():
        print(f"{name:8}{program:8}", ", ".join(f"{kind}: {row[kind]}" for kind in sorted(row)))
    return sum(row["FAULTS"] for row in table.values())


if __name__ == "__main__":
    sys.exit(min(main(*map(int, sys.argv[1:])), 1))

"""Malformed stages: each is refused in one line or is a valid case; nothing hangs, crashes or exhausts the memory.

As a script, ``python -m tests.faults.hostile [STAGES [SEED]]``, it makes so many, checks them, runs some of those that
are cases for a few steps, and prints what became of each kind. Any of them can be made again:
``python -m tests.faults.hostile make NUMBER [SEED]`` leaves it in the folder ``hostile``.
"""

from __future__ import annotations

import collections
import contextlib
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf

from tests.faults.broken import BREAKAGES
from tests.faults.misplaced_values import MISPLACED
from tests.faults.mutations import CHANGES as WILD_CHANGES
from tests.faults.mutations import pick
from tests.faults.seeds import seeds
from tests.faults.worker import RESIDENT, Ending, Worker

CHANGES = {**WILD_CHANGES, **MISPLACED}
SEVERAL = "several changes"
KINDS = (*CHANGES, SEVERAL, *BREAKAGES)
# a few of the cases are run, for a few steps
RUN_EVERY = 10
PARTICLES, STEPS = 3000, 5


@dataclass(frozen=True)
class Outcome:
    """What became of a malformed stage.

    Attributes:
        number: Its number.
        kind: Kind of malformation, one of `KINDS`.
        what: The change, and the stage that was changed.
        command: ``check`` or ``run``.
        ending: How the command ended.
        fault: The fault found; empty if there is none.
    """

    number: int
    kind: str
    what: str
    command: str
    ending: Ending
    fault: str


def make(number: int, folder: Path, texts: dict[str, str], *, seed: int = 0) -> tuple[str, str, Path]:
    """Write a malformed stage into a folder: its kind, the change, and its path."""
    random = np.random.default_rng([seed, number])
    kind, name = KINDS[number % len(KINDS)], pick(random, texts)
    if kind in BREAKAGES:
        return kind, name, BREAKAGES[kind](texts[name], folder, random)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(texts[name])
    several = [pick(random, CHANGES.values()) for _ in range(random.integers(2, 6))]
    changes = [CHANGES[kind]] if kind in CHANGES else several
    done = []
    for change in changes:
        # what it changes may not be there any more, and USD refuses some values
        with contextlib.suppress(IndexError, RuntimeError, TypeError, ValueError):
            done.append(change(layer, random))
    path = folder / "case.usda"
    layer.Export(str(path))
    return kind, f"{name}: {'; '.join(done)}", path


def campaign(count: int, *, seed: int = 0, leave_out: Sequence[str] = ()) -> Iterator[Outcome]:
    """Make malformed stages, but for some kinds of them, and see what becomes of them."""
    texts = seeds()
    with Worker() as worker, tempfile.TemporaryDirectory() as scratch:
        for number in range(count):
            if KINDS[number % len(KINDS)] in leave_out:
                continue
            folder = Path(scratch) / str(number)
            folder.mkdir()
            kind, what, path = make(number, folder, texts, seed=seed)
            ending = worker.run(["check", str(path)])
            yield Outcome(number, kind, what, "check", ending, fault(ending, "check"))
            if ending.code == 0 and number % RUN_EVERY == 0 and kind not in BREAKAGES:
                duration = _few_steps(path)
                if duration is not None:
                    options = ("--duration", repr(duration), "--out", str(folder / "out"), "--quiet")
                    ending = worker.run(["run", str(path), *options])
                    yield Outcome(number, kind, what, "run", ending, fault(ending, "run"))
            shutil.rmtree(folder)


def fault(ending: Ending, command: str) -> str:
    """The fault in how a command ended; empty if there is none."""
    if ending.code not in (0, 2, *((3,) if command == "run" else ())):
        return ending.err.strip().splitlines()[-1] if ending.err.strip() else f"exit {ending.code}"
    lines = ending.err.splitlines()
    if ending.code and len(lines) != 1:
        return f"{len(lines)} lines: {' | '.join(lines)[:300]}"
    if ending.code == 0 and command == "check" and lines:
        return f"says {lines[0]}"
    if ending.code == 2 and len(lines[0]) > 1000:
        return f"a line of {len(lines[0])} characters: {lines[0][:100]}"
    if ending.resident > RESIDENT:
        return f"takes {ending.resident / 2**30:.1f} GiB"
    return ""


def _few_steps(path: Path) -> float | None:
    """How long a case runs for some steps [s]; None if it is too large."""
    from warp_mps.run.cost import estimate
    from warp_mps.usd.case.read import read_stage

    scene = read_stage(path)
    cost = estimate(scene)
    if sum(cost.particles.values()) > PARTICLES:
        return None
    return min(scene.duration, STEPS * cost.time_step.length)


def main(count: int = 2000, seed: int = 0) -> int:
    """Check many malformed stages and print a table; the number of those that came to a bad end."""
    begin, faults = time.monotonic(), 0
    table: dict[tuple[str, str], collections.Counter] = collections.defaultdict(collections.Counter)
    longest, largest = 0.0, 0
    for outcome in campaign(count, seed=seed):
        ending = outcome.ending
        table[outcome.kind, outcome.command][str(ending.code)] += 1
        table[outcome.kind, outcome.command]["faults"] += bool(outcome.fault)
        longest, largest = max(longest, ending.seconds), max(largest, ending.resident)
        if outcome.fault:
            faults += 1
            print(f"{outcome.number} {outcome.kind}, {outcome.command}, {outcome.what}: {outcome.fault}", flush=True)
    print(f"{'malformed':28}{'command':8}{'stages':>7}{'exit 0':>7}{'exit 2':>7}{'exit 3':>7}{'other':>6}{'faults':>7}")
    totals: collections.Counter = collections.Counter()
    for (kind, command), row in sorted(table.items(), key=lambda item: (item[0][1], KINDS.index(item[0][0]))):
        print(_line(kind, command, row))
        totals.update(row)
    print(_line("all", "", totals))
    print(f"{time.monotonic() - begin:.0f} s; the longest took {longest:.1f} s, the largest {largest / 2**20:.0f} MiB")
    return faults


def _line(kind: str, command: str, row: collections.Counter) -> str:
    stages = row.total() - row["faults"]
    other = stages - row["0"] - row["2"] - row["3"]
    return f"{kind:28}{command:8}{stages:7}{row['0']:7}{row['2']:7}{row['3']:7}{other:6}{row['faults']:7}"


def remake(number: int, seed: int = 0) -> int:
    """Leave a malformed stage in the folder ``hostile``."""
    folder = Path("hostile")
    folder.mkdir()
    print(*make(number, folder, seeds(), seed=seed), sep="\n")
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["make"]:
        sys.exit(remake(*map(int, sys.argv[2:])))
    sys.exit(min(main(*map(int, sys.argv[1:])), 1))

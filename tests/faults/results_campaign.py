"""Forged and damaged results: every command that reads them ends in one line or does what it should.

As a script, ``python -m tests.faults.results_campaign [EACH [SEED]]``, it mutates each of the four files of a result so
often, lets a command read it, and prints what became of them.
"""

from __future__ import annotations

import collections
import shutil
import sys
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.faults.cases import Case, make_case
from tests.faults.hostile import fault
from tests.faults.result_mutations import MUTATIONS
from tests.faults.worker import Ending, Worker
from warp_mps.errors import InputError
from warp_mps.results.history import read_history
from warp_mps.results.summary import read_summary

READING = (
    *("report {0} --overwrite", "plot {0} --overwrite", "picture {0} --overwrite --size 160 120"),
    *(
        "convert {0} --overwrite",
        "convert {0} --overwrite --to vtkhdf",
        "convert {0} --overwrite --to usd --colour speed",
    ),
    "video {0} --overwrite --size 160 120 --out {0}/video.gif",
)
RESUME = "run {1} --out {0} --resume --quiet --duration {2}"
# commands that read a file
COMMANDS = {
    "run.json": READING[:2],
    "probes.csv": (*READING[:2], RESUME),
    "run.usdc": (READING[0], *READING[2:], RESUME),
    "checkpoint.npz": (RESUME,),
}
READERS = {"run.json": read_summary, "probes.csv": read_history}


@dataclass(frozen=True)
class Outcome:
    """What became of a mutated result.

    Attributes:
        file: The file that was mutated.
        what: The mutation.
        command: The first word of the command.
        code: Its exit code.
        fault: What is wrong with how it ended; empty if nothing is.
    """

    file: str
    what: str
    command: str
    code: int
    fault: str


def campaign(each: int, *, seed: int = 0) -> Iterator[Outcome]:
    """Mutate every file of a result so often, and let one command after the other read it."""
    with Worker() as worker, tempfile.TemporaryDirectory() as scratch:
        cases = {name: make_case(name, Path(scratch), frames=8) for name in ("solid", "wet")}
        for file, mutate in MUTATIONS.items():
            # bodies that rub in water have indices, flags and counters in their checkpoints
            case = cases["wet" if file == "checkpoint.npz" else "solid"]
            for number in range(each):
                folder = Path(scratch) / "mutated"
                shutil.copytree(case.whole, folder)
                what = mutate(folder, np.random.default_rng([seed, number]))
                yield from _read(worker, case, folder, file, f"{number}: {what}", number)
                shutil.rmtree(folder)


def _read(worker: Worker, case: Case, folder: Path, file: str, what: str, number: int) -> Iterator[Outcome]:
    command = COMMANDS[file][number % len(COMMANDS[file])]
    ending = worker.run(command.format(folder, case.stage, 1.5 * case.scene.duration).split())
    found = fault(ending, "run" if command is RESUME else command.split()[0])
    if command is RESUME and not found and ending.code == 0:
        found = _compare(case, folder)
    yield Outcome(file, what, command.split()[0], ending.code, found)
    if file in READERS:
        ending = _in_python(file, folder)
        yield Outcome(file, what, "python", ending.code, fault(ending, "check"))


def _compare(case: Case, folder: Path) -> str:
    """What is wrong with the rows of a run that was resumed with exit 0: those of the whole run must begin it."""
    whole = read_history(case.whole / "probes.csv").rows
    rows = read_history(folder / "probes.csv").rows
    return "" if rows[: len(whole)] == whole else "continues to other rows with exit 0"


def _in_python(file: str, folder: Path) -> Ending:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            str(READERS[file](folder / file))
    except InputError as error:
        return Ending(2, err=f"{error}\n")
    except Exception as error:
        return Ending(1, err=f"{type(error).__name__}: {error}\n")
    return Ending(0)


def main(each: int = 500, seed: int = 0) -> int:
    """Go through the campaign and print a table; the number of faults."""
    table: dict[tuple[str, str], collections.Counter] = collections.defaultdict(collections.Counter)
    for outcome in campaign(each, seed=seed):
        table[outcome.file, outcome.command].update([str(outcome.code), *["faults"] * bool(outcome.fault)])
        if outcome.fault:
            print(f"{outcome.file} {outcome.what}, {outcome.command}: {outcome.fault}", flush=True)
    for (file, command), row in table.items():
        codes = ", ".join(f"exit {code}: {row[code]}" for code in sorted(row) if code != "faults")
        print(f"{file:16}{command:10}{codes}, faults: {row['faults']}")
    return sum(row["faults"] for row in table.values())


if __name__ == "__main__":
    sys.exit(min(main(*map(int, sys.argv[1:])), 1))

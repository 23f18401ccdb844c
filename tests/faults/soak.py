"""A long run in one process: whether its memory grows and whether it slows down.

``python -m tests.faults.soak --steps N --case CASE`` runs a case, given by name or by the path of its stage, for N time
steps of the solver (of fluids, those within the intervals), however long it lasts as shipped, with all that a run in a
folder does: frames, rows, checkpoints and guards. At every tenth it prints the resident memory and the speed. It exits
with 1 if memory grows by more than 2 % from the first tenth to the last, or if a step of the last tenth takes more than
5 % longer than one of the first, by the clock on the wall and by that of the process.

The speed means something on a quiet machine alone: others slow a process down by both clocks. And it does where a step
of the last tenth has as much to do as one of the first: bodies that come to touch, and water that spreads, cost more.
``--memory-only`` leaves it out of the verdict.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import gc
import resource
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

from warp_mps.observers.base import Observer, View
from warp_mps.observers.progress import Progress
from warp_mps.run.recording import Recording
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.shipped_cases import find_case

TENTHS = 10
LARGEST_GROWTH, LARGEST_SLOWING = 0.02, 0.05


@dataclass(frozen=True)
class Mark:
    """A moment of the run.

    Attributes:
        steps: Steps of the solver done.
        seconds: Wall time [s].
        busy: Time that this process has computed [s].
        memory: Resident memory [bytes].
    """

    steps: int
    seconds: float
    busy: float
    memory: int


class EnoughError(Exception):
    """All steps are done."""


class Meter(Observer):
    """An observer that marks the end of every tenth, and ends the run with the last.

    Args:
        simulation: The run.
        steps: Its steps.
        every: Steps of the clock between two looks.
    """

    def __init__(self, simulation: Simulation, steps: int, *, every: int) -> None:
        self.every = every
        self.marks: list[Mark] = []
        self._simulation, self._tenth = simulation, -(-steps // TENTHS)

    def observe(self, view: View) -> None:
        """Look at the clock and the memory, if a tenth is over.

        Raises:
            EnoughError: It was the last one.
        """
        done = self._simulation.steps_done
        # the first look after kernels are loaded and graphs captured is where the first tenth begins
        if done == 0 or (self.marks and done < self.marks[0].steps + len(self.marks) * self._tenth):
            return
        self.marks.append(Mark(done, time.perf_counter(), time.process_time(), resident_memory()))
        if len(self.marks) > 1:
            print(f"{len(self.marks) - 1:2}/{TENTHS} {self._line()}", flush=True)
        if len(self.marks) > TENTHS:
            raise EnoughError

    def growth(self) -> float:
        """Memory at the end of the last tenth relative to that at the end of the first one, less 1 [-]."""
        return self.marks[-1].memory / self.marks[1].memory - 1.0

    def slowing(self) -> float:
        """Time of a step in the last tenth relative to that in the first one, less 1, by the kinder clock [-]."""
        return min(last / first for first, last in zip(self._times(1), self._times(TENTHS), strict=True)) - 1.0

    def _times(self, tenth: int) -> tuple[float, float]:
        """Wall time and computing time of a step in a tenth, counted from 1 [s]."""
        a, b = self.marks[tenth - 1 : tenth + 1]
        return (b.seconds - a.seconds) / (b.steps - a.steps), (b.busy - a.busy) / (b.steps - a.steps)

    def _line(self) -> str:
        last, (wall, busy) = self.marks[-1], self._times(len(self.marks) - 1)
        speed = f"{1.0 / wall:9.1f} steps/s, {1.0 / busy:9.1f} a second of computing"
        return f"{last.steps:9} steps {last.memory / 2**20:8.1f} MiB {speed}"


def resident_memory() -> int:
    """Memory of this process that is in RAM, after all that can be given back was [bytes]."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def soak(scene: Scene, steps: int, folder: Path, *, device: str = "cpu", precision: str = "float64") -> Meter:
    """Run a case for some steps in a folder, and print what becomes of memory and speed."""
    clock = Clock(scene)
    # an interval of fluids takes a step at least
    scene = replace(scene, duration=(steps + 2 * clock.sample_every) * clock.dt)
    simulation = Simulation(scene, device=device, precision=precision)
    progress = Progress(every=clock.sample_every, quiet=True)
    run = Recording(simulation, folder, progress, resumed=False, interval=60.0)
    meter = Meter(simulation, steps, every=clock.sample_every)
    with contextlib.suppress(EnoughError):
        simulation.run([*run.observers, meter])
    return meter


def main(arguments: list[str] | None = None) -> int:
    """Run the command line, and return the exit code."""
    parser = argparse.ArgumentParser(prog="soak", description=__doc__.splitlines()[0])
    parser.add_argument("--case", required=True)
    parser.add_argument("--steps", type=int, required=True)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--precision", default="float64")
    parser.add_argument("--memory-only", action="store_true")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        scene = read_stage(find_case(options.case))
        meter = soak(scene, options.steps, Path(folder), device=options.device, precision=options.precision)
    growth, slowing = meter.growth(), meter.slowing()
    print(f"{scene.name}: memory {100.0 * growth:+.2f} %, time of a step {100.0 * slowing:+.1f} %")
    return int(growth > LARGEST_GROWTH or (slowing > LARGEST_SLOWING and not options.memory_only))


if __name__ == "__main__":
    sys.exit(main())

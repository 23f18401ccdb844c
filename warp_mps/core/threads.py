"""Several CPU threads on one step, each replaying graphs of its own on its share of the particles.

Warp runs a launch on the CPU in one thread, but lets other threads run meanwhile. A step is cut into sections; between
two sections all threads wait for each other, and within one no thread reads what another writes.
"""

import itertools
import threading
from collections.abc import Callable, Sequence

Task = Callable[[], None]


class Team:
    """Threads that go through the same sections side by side.

    Args:
        sections: For each section, a task for each thread; None where a thread has nothing to do.
        threads: Number of threads, the caller's included.
    """

    def __init__(self, sections: Sequence[Sequence[Task | None]], threads: int) -> None:
        self._sections = sections
        self._barrier = threading.Barrier(threads)
        self._repetitions = 0
        for number in range(1, threads):
            # daemons, so that an interrupted program does not wait for them
            threading.Thread(target=self._serve, args=(number,), daemon=True).start()

    def run(self, repetitions: int) -> None:
        """Go through all sections this many times."""
        self._repetitions = repetitions
        self._barrier.wait()
        self._work(0)

    def _serve(self, number: int) -> None:
        while True:
            self._barrier.wait()
            self._work(number)

    def _work(self, number: int) -> None:
        for _ in range(self._repetitions):
            for tasks in self._sections:
                task = tasks[number]
                if task is not None:
                    task()
                self._barrier.wait()


def shares(count: int, threads: int) -> list[tuple[int, int]]:
    """First particle and number of particles of each thread."""
    ends = [count * number // threads for number in range(threads + 1)]
    return [(first, last - first) for first, last in itertools.pairwise(ends)]

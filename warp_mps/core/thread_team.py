"""A team of CPU threads that share a step, each replaying graphs of its own on its part of the particles.

Warp runs a launch on the CPU in one thread, without holding up other threads. A step is divided into sections. The
threads meet at a barrier between two sections; within a section no thread reads what another one writes.
"""

import itertools
import threading
import weakref
from collections.abc import Callable, Iterable, Sequence
from queue import SimpleQueue

Task = Callable[[], None]
# number of repetitions of the sections, or None to end the thread
Orders = SimpleQueue[int | None]


class ThreadTeam:
    """Threads that run the same sections in parallel; they end with the team.

    Args:
        sections: For each section, a task for each thread; None where a thread has nothing to do.
        threads: Number of threads, the caller's included.
    """

    def __init__(self, sections: Sequence[Sequence[Task | None]], threads: int) -> None:
        self._shared = shared = _Sections(sections, threads)
        self._orders: list[Orders] = [SimpleQueue() for _ in range(1, threads)]
        # daemons, so that a program can end without waiting for them; they hold no reference to the team, so that it
        # can be finalized
        self._threads = [
            threading.Thread(target=shared.serve, args=(number, orders), daemon=True)
            for number, orders in enumerate(self._orders, start=1)
        ]
        for thread in self._threads:
            thread.start()
        self._dismissal = weakref.finalize(self, _dismiss, self._orders)

    @property
    def closed(self) -> bool:
        """Whether the threads have ended, by `close` or by a failure."""
        return not self._dismissal.alive

    def run(self, repetitions: int) -> None:
        """Run all sections a number of times.

        After an error of any thread, or an interrupt, the state of the others is unknown, and the team is closed.

        Raises:
            RuntimeError: The team is closed.
            BaseException: The exception of a task.
        """
        if self.closed:
            raise RuntimeError(
                "the team of threads is closed, by `close` or after a failure, must be open: make a new one"
            )
        try:
            for orders in self._orders:
                orders.put(repetitions)
            self._shared.follow(0, repetitions)
        except threading.BrokenBarrierError:
            self.close()
            raise self._shared.failures[0] from None
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the threads, after their present tasks."""
        self._shared.barrier.abort()
        self._dismissal()
        for thread in self._threads:
            thread.join()


class _Sections:
    """The sections of a team and its barrier, shared by all its threads.

    Attributes:
        barrier: Barrier between two sections; broken once a thread has failed.
        failures: Exceptions of tasks, in all threads but the caller's.
    """

    def __init__(self, sections: Sequence[Sequence[Task | None]], threads: int) -> None:
        self.barrier = threading.Barrier(threads)
        self.failures: list[BaseException] = []
        self._sections = sections

    def follow(self, number: int, repetitions: int) -> None:
        """Run all sections as one of the threads.

        Raises:
            BrokenBarrierError: Another thread has failed.
        """
        for _ in range(repetitions):
            for tasks in self._sections:
                task = tasks[number]
                if task is not None:
                    task()
                self.barrier.wait()

    def serve(self, number: int, orders: Orders) -> None:
        """Run the sections as often as ordered, until ended or until a thread fails."""
        try:
            while (repetitions := orders.get()) is not None:
                self.follow(number, repetitions)
        except threading.BrokenBarrierError:
            pass  # the failed thread reports the reason
        except BaseException as error:
            self.failures.append(error)
            self.barrier.abort()


def _dismiss(teams_orders: Iterable[Orders]) -> None:
    # a finalizer may run at any point of any thread, where a queue is safe to use and a barrier is not
    for orders in teams_orders:
        orders.put(None)


def split_particles(count: int, threads: int) -> list[tuple[int, int]]:
    """First particle and number of particles of each thread."""
    ends = [count * number // threads for number in range(threads + 1)]
    return [(first, last - first) for first, last in itertools.pairwise(ends)]

"""Several CPU threads on one step, each replaying graphs of its own on its share of the particles.

Warp runs a launch on the CPU in one thread, but lets other threads run meanwhile. A step is cut into sections; between
two sections all threads wait for each other, and within one no thread reads what another writes.
"""

import itertools
import threading
import weakref
from collections.abc import Callable, Iterable, Sequence
from queue import SimpleQueue

Task = Callable[[], None]
# how often to go through the sections, or None: to end
Orders = SimpleQueue[int | None]


class ThreadTeam:
    """Threads that go through the same sections side by side; they end with the team.

    Args:
        sections: For each section, a task for each thread; None where a thread has nothing to do.
        threads: Number of threads, the caller's included.
    """

    def __init__(self, sections: Sequence[Sequence[Task | None]], threads: int) -> None:
        self._course = course = _Sections(sections, threads)
        self._orders: list[Orders] = [SimpleQueue() for _ in range(1, threads)]
        # daemons, so that a program that ends does not wait for them; none of them may hold the team, see `_dismissal`
        self._threads = [
            threading.Thread(target=course.serve, args=(number, orders), daemon=True)
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
        """Go through all sections this many times.

        After an error, of whichever thread, or an interrupt no one knows who has done what: the team is closed.

        Raises:
            RuntimeError: The team is closed.
            BaseException: What a task has raised.
        """
        if self.closed:
            raise RuntimeError("the threads have ended: they were closed, or one of them failed")
        try:
            for orders in self._orders:
                orders.put(repetitions)
            self._course.follow(0, repetitions)
        except threading.BrokenBarrierError:
            self.close()
            raise self._course.failures[0] from None
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the threads, after the tasks that they are at."""
        self._course.barrier.abort()
        self._dismissal()
        for thread in self._threads:
            thread.join()


class _Sections:
    """What the threads of a team share.

    Attributes:
        barrier: Where they wait for each other; broken once one of them has failed.
        failures: What tasks have raised, in the threads that serve.
    """

    def __init__(self, sections: Sequence[Sequence[Task | None]], threads: int) -> None:
        self.barrier = threading.Barrier(threads)
        self.failures: list[BaseException] = []
        self._sections = sections

    def follow(self, number: int, repetitions: int) -> None:
        """Go through all sections as one of the threads.

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
        """Follow orders until there are no more, or until a thread fails."""
        try:
            while (repetitions := orders.get()) is not None:
                self.follow(number, repetitions)
        except threading.BrokenBarrierError:
            pass  # the thread that has failed says why
        except BaseException as error:
            self.failures.append(error)
            self.barrier.abort()


def _dismiss(teams_orders: Iterable[Orders]) -> None:
    # a finalizer may come at any point of any thread, where a barrier could not be touched but a queue can
    for orders in teams_orders:
        orders.put(None)


def split_particles(count: int, threads: int) -> list[tuple[int, int]]:
    """First particle and number of particles of each thread."""
    ends = [count * number // threads for number in range(threads + 1)]
    return [(first, last - first) for first, last in itertools.pairwise(ends)]

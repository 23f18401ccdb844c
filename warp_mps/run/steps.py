"""How the steps of a run are launched: one by one, as replayed graphs, or by several threads."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from warp_mps.errors import InputError
from warp_mps.run.schedule import Clock
from warp_mps.run.system import PacedSystem

if TYPE_CHECKING:
    from warp_mps.elastic.explicit.solid import Solid
    from warp_mps.elastic.explicit.step import Phase
    from warp_mps.scene import Scene

# steps in a graph that is replayed as one: long enough that the launch from Python does not count
BLOCK = 32
# threads that a machine of few cores takes, and how many a core of others: more of them mostly wait at barriers
MOST_THREADS, MOST_THREADS_PER_CORE = 16, 2


def require_threads(threads: int, scene: Scene, gpu: str) -> None:
    """Refuse a number of threads that a scene cannot be shared by.

    Args:
        threads: The number.
        scene: The scene.
        gpu: Name of the device if it is not the CPU, else empty.

    Raises:
        InputError: It is not a whole number from 1 on, it is far above the number of cores, or the scene or the device
            takes one.
    """
    if not isinstance(threads, int) or threads < 1:
        raise InputError("", "threads", f"is {threads!r}, must be a whole number of 1 or more")
    if threads == 1:
        return
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    most = max(MOST_THREADS, MOST_THREADS_PER_CORE * cores)
    if threads > most:
        raise InputError("", "threads", f"is {threads}, must be at most {most} on the {cores} cores of this process")
    if gpu:
        raise InputError("", "threads", f"is {threads} on {gpu}; threads are for the CPU device")
    if scene.fluids or scene.implicit:
        what = "fluids take" if scene.fluids else "a static analysis and implicit steps take"
        raise InputError("", "threads", f"is {threads}; {what} one")
    if not all(force.is_warp_function for force in scene.body_forces):
        raise InputError("", "threads", f"is {threads}; body forces given as Python functions take one")


class Steps(Protocol):
    """A way to launch the steps of a run.

    Attributes:
        block: Steps that are launched together.
    """

    block: int

    def take(self, first: int, count: int) -> None:
        """Take some steps, after `first` that were done before.

        Raises:
            RunError: A step, or an equilibrium, could not be solved, or a fluid particle is too fast.
        """

    def reopen(self) -> None:
        """Make steps possible again after one that failed."""


class PacedSteps:
    """Steps of a system that decides on the host how each one goes on.

    Args:
        system: The system.
        clock: Gives the time after a step.
    """

    block = 1

    def __init__(self, system: PacedSystem, clock: Clock) -> None:
        self._system, self._clock = system, clock

    def take(self, first: int, count: int) -> None:
        """Take the steps one by one."""
        for step in range(first, first + count):
            self._system.advance(self._clock.time(step + 1))

    def reopen(self) -> None:
        """Do nothing: a failed step leaves the system as it was restored."""


class ReplayedSteps:
    """Explicit steps of elastic bodies, launched as one graph.

    Args:
        solid: The bodies.
        device: Warp device.
        graphs: Whether to; if not, every kernel is launched by itself, with the same result.
    """

    block = BLOCK

    def __init__(self, solid: Solid, device: Any, *, graphs: bool) -> None:
        from warp_mps.core.replay import Replay

        self._solid, self._replay = solid, Replay(device=device, graphs=graphs)

    def take(self, first: int, count: int) -> None:
        """Take the steps as one graph, or in parts where the host has to do something within a step."""
        from warp_mps.elastic.explicit.step_graphs import take_steps

        take_steps(self._solid, self._replay, count)

    def reopen(self) -> None:
        """Do nothing: graphs stay."""


class ThreadedSteps:
    """Explicit steps of elastic bodies by several CPU threads, with the same result as by one.

    Args:
        solid: The bodies.
        particles: Number of their particles.
        device: Warp device.
        threads: Number of threads.
    """

    block = BLOCK

    def __init__(self, solid: Solid, particles: int, device: Any, threads: int) -> None:
        self._solid, self._particles, self._device, self._threads = solid, particles, device, threads
        self._team = self._make_team()

    def take(self, first: int, count: int) -> None:
        """Take the steps, each thread on its share of the particles."""
        self._team.run(count)

    def reopen(self) -> None:
        """Start new threads if the old ones have ended."""
        if self._team.closed:
            self._team = self._make_team()

    def _make_team(self) -> Any:
        """Threads with a graph each for every section of a step; sections that do not split are the first thread's."""
        import warp as wp

        from warp_mps.core.replay import capture
        from warp_mps.core.thread_team import ThreadTeam, split_particles

        def task(section: Sequence[Phase], share: tuple[int, int]) -> Callable[[], None]:
            def launch() -> None:
                for phase in section:
                    phase.launch(*share)

            return functools.partial(wp.capture_launch, capture(launch, self._device))

        count, threads = self._particles, self._threads
        sections = [
            [task(section, share) for share in (split_particles(count, threads) if section[0].splits else [(0, count)])]
            for section in self._solid.sections()
        ]
        return ThreadTeam([tasks + [None] * (threads - len(tasks)) for tasks in sections], threads)

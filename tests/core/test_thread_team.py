"""Threads that share particles: sections in order, every share done, an end to all of them."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator

import pytest

from warp_mps.core.thread_team import ThreadTeam, split_particles


@pytest.fixture
def threads() -> Iterator[list[threading.Thread]]:
    """Gets the threads that a test has started; they must have ended, or end by themselves."""
    before = set(threading.enumerate())
    started: list[threading.Thread] = []
    start = threading.Thread.start

    def note(thread: threading.Thread) -> None:
        started.append(thread)
        start(thread)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threading.Thread, "start", note)
        yield started
    gc.collect()
    for thread in started:
        thread.join(timeout=60.0)
    assert started
    assert set(threading.enumerate()) <= before


@pytest.mark.parametrize(("count", "threads"), [(10, 1), (10, 3), (2, 4), (1000, 7)])
def test_shares_cover_every_particle_once(count: int, threads: int) -> None:
    parts = split_particles(count, threads)
    assert len(parts) == threads
    assert [i for first, size in parts for i in range(first, first + size)] == list(range(count))
    assert max(size for _, size in parts) - min(size for _, size in parts) <= 1


def test_no_thread_enters_a_section_before_the_others_have_left_the_last() -> None:
    """Three threads write to a list in sections; a section's entries never mix with the next one's."""
    done: list[int] = []
    sections = [[lambda s=s: done.append(s)] * 3 for s in range(4)]
    sections[2] = [sections[2][0], None, None]
    team = ThreadTeam(sections, 3)
    for repetitions in (50, 0, 1):
        done.clear()
        team.run(repetitions)
        assert done == [0, 0, 0, 1, 1, 1, 2, 3, 3, 3] * repetitions


def test_threads_end_with_the_team(threads: list[threading.Thread]) -> None:
    ran, idle = (ThreadTeam([[lambda: None] * 4], 4) for _ in range(2))
    ran.run(3)
    assert len(threads) == 6
    assert all(thread.is_alive() for thread in threads)
    del ran, idle


def test_a_closed_team_has_no_threads_and_does_not_run(threads: list[threading.Thread]) -> None:
    team = ThreadTeam([[lambda: None] * 3], 3)
    team.run(1)
    assert not team.closed
    for _ in range(2):
        team.close()
    assert team.closed
    assert not any(thread.is_alive() for thread in threads)
    with pytest.raises(RuntimeError, match="the team of threads is closed"):
        team.run(1)


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("failing", [0, 1, 2])
def test_an_error_in_any_thread_is_raised_and_ends_them_all(
    threads: list[threading.Thread], error: type[BaseException], failing: int
) -> None:
    """It comes in the second of three repetitions, which the others may or may not have begun."""
    done = [0, 0, 0]

    def task(number: int) -> None:
        done[number] += 1
        if number == failing and done[number] == 2:
            raise error("enough")

    team = ThreadTeam([[lambda n=n: task(n) for n in range(3)], [lambda: None] * 3], 3)
    with pytest.raises(error, match="enough"):
        team.run(3)
    reached = list(done)
    assert reached[failing] == max(reached) == 2
    assert team.closed
    assert not any(thread.is_alive() for thread in threads)
    with pytest.raises(RuntimeError, match="the team of threads is closed"):
        team.run(1)
    assert done == reached

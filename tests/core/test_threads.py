"""Threads that share particles: sections in order, every share done."""

from __future__ import annotations

import pytest

from warp_mps.core.threads import Team, shares


@pytest.mark.parametrize(("count", "threads"), [(10, 1), (10, 3), (2, 4), (1000, 7)])
def test_shares_cover_every_particle_once(count: int, threads: int) -> None:
    parts = shares(count, threads)
    assert len(parts) == threads
    assert [i for first, size in parts for i in range(first, first + size)] == list(range(count))
    assert max(size for _, size in parts) - min(size for _, size in parts) <= 1


def test_no_thread_enters_a_section_before_the_others_have_left_the_last() -> None:
    """Three threads write to a list in sections; a section's entries never mix with the next one's."""
    done: list[int] = []
    sections = [[lambda s=s: done.append(s)] * 3 for s in range(4)]
    sections[2] = [sections[2][0], None, None]
    Team(sections, 3).run(50)
    assert done == [0, 0, 0, 1, 1, 1, 2, 3, 3, 3] * 50

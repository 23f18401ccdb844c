"""Malformed stages, some of every kind: refused in one line, or cases; and what the campaign takes for a fault."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

if not sys.platform.startswith("linux"):
    pytest.skip("the watchdog reads what Linux tells of a process", allow_module_level=True)

from tests.faults import hostile
from tests.faults.worker import RESIDENT, Ending, Worker

EACH = 3


@pytest.mark.long
def test_malformed_stages_are_refused_in_a_line_or_are_cases() -> None:
    outcomes = list(hostile.campaign(EACH * len(hostile.KINDS), seed=1, leave_out=("crowd of references",)))
    assert [outcome for outcome in outcomes if outcome.fault] == []
    assert {outcome.kind for outcome in outcomes} == {*hostile.KINDS} - {"crowd of references"}
    codes = [outcome.ending.code for outcome in outcomes]
    assert min(codes.count(0), codes.count(2)) > 0.2 * len(codes)


@pytest.mark.parametrize(
    ("ending", "expected"),
    [
        (Ending(0, "a table"), ""),
        (Ending(2, err="warp-mps: /Beam: is wrong\n"), ""),
        (Ending(3, err="warp-mps: failed\n"), "warp-mps: failed"),
        (Ending(1, err="Traceback\nValueError: x\n"), "ValueError: x"),
        (Ending(-1, err="hangs"), "hangs"),
        (Ending(2, err="a warning\nwarp-mps: /Beam: is wrong\n"), "2 lines"),
        (Ending(2), "0 lines"),
        (Ending(0, err="a warning\n"), "says a warning"),
        (Ending(2, err="x" * 5000 + "\n"), "a line of 5000 characters"),
        (Ending(0, resident=RESIDENT + 1), "takes 3.0 GiB"),
    ],
)
def test_what_is_a_fault(ending: Ending, expected: str) -> None:
    found = hostile.fault(ending, "check")
    assert found.startswith(expected)
    assert bool(found) == bool(expected)


def test_the_watchdog_ends_what_hangs_and_restarts(tmp_path: Path) -> None:
    with Worker(patience=0.0) as worker:
        assert worker.run(["check", "beam_first_mode"]).err == "hangs"
    with Worker() as worker:
        assert worker.run(["check", "nothing"]).code == 2
        assert worker.process is not None
        worker.process.kill()
        worker.process.wait()
        assert worker.run(["check", "nothing"]).err == "the process died: exit -9"
        assert worker.run(["list"]).code == 0

"""Runs that are killed, interrupted and starved: nothing that was saved is lost, and they resume to the same bits."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.faults.cases import Case, assert_same, make_case
from warp_mps.run.run import run_scene

if not sys.platform.startswith("linux"):
    pytest.skip("the faults are made by Linux's own means", allow_module_level=True)

from tests.faults import campaign

pytestmark = pytest.mark.usefixtures("interruptible")

# one of each kind of end: at once, with a checkpoint, and in the middle of a file
SHORT = [("kill -9", "solid", 26), ("Ctrl-C twice", "solid", 12), ("disk full", "solid", 15)]
LONG = [
    *(("kill -9", "solid", rows) for rows in (1, 9, 47)),
    *(("kill -9", "fluid", rows) for rows in (5, 33)),
    *(("kill -9", "wet", rows) for rows in (3, 29)),
    *(("kill -9", "implicit", rows) for rows in (14, 45)),
    ("SIGTERM", "fluid", 20),
    ("SIGHUP", "solid", 31),
    ("Ctrl-C twice", "implicit", 22),
    ("disk full", "wet", 17),
    ("disk full, checkpoint", "solid", 2),
    ("disk full, frame", "fluid", 30),
    ("folder removed", "solid", 21),
    ("folder write-protected", "solid", 18),
]


@pytest.fixture(scope="module")
def case_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Case]:
    """Gives a case by its name, with its continuous run, which is made when a test first asks for it."""
    folder = tmp_path_factory.mktemp("cases")
    return functools.cache(lambda name: make_case(name, folder))


@pytest.mark.parametrize(
    ("fault", "name", "rows"), [*SHORT, *(pytest.param(*fault, marks=pytest.mark.long) for fault in LONG)]
)
def test_a_run_goes_on_after_a_fault(
    case_of: Callable[[str], Case], tmp_path: Path, fault: str, name: str, rows: int
) -> None:
    _, start = campaign.endure(campaign.FAULTS[fault], case_of(name), tmp_path / "run", rows)
    # beyond the first frame there is a checkpoint, of at most some rows ago
    if rows > 5:
        assert start > 0.0


def test_a_clock_that_jumps_changes_nothing(
    case_of: Callable[[str], Case], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To before the oldest time that a zip file can hold, beyond the newest, and back."""
    jumps = np.random.default_rng(0)
    monkeypatch.setattr(time, "time", lambda: float(jumps.choice([-1e9, 0.0, 1e9, 5e9])))
    case = case_of("solid")
    run_scene(case.scene, tmp_path, quiet=True, checkpoint_interval=0.0)
    assert_same(case, tmp_path)


@pytest.mark.slow
def test_the_long_campaign_loses_no_run() -> None:
    assert campaign.main(50) == 0

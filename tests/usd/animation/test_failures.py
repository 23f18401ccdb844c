"""Animations whose writer fails: every completed frame survives a full disk and a killed process."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.usd.animation.other_process import frames_seen_by_another_process
from warp_mps.errors import RunError
from warp_mps.particles.particles import Particles


def test_a_full_disk_stops_the_run_and_keeps_the_frames(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    path = tmp_path / "run.usdc"
    child = subprocess.run(
        [sys.executable, "-c", CHILD.format(path=str(path), prologue=LIMIT.format(resource=resource.__name__))],
        capture_output=True,
        text=True,
        check=False,
    )
    assert RunError.__name__ in child.stderr
    assert frames_seen_by_another_process(path) == len(child.stdout.split()) > 3


LIMIT = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4_000_000, 4_000_000))
"""

CHILD = """
import itertools
import numpy as np
from tests.usd.animation.test_failures import big
from tests.usd.animation.test_writer import PLANE
from warp_mps.usd.animation.writer import AnimationWriter
{prologue}
particles = big()
animation = AnimationWriter({path!r}, particles, PLANE, frame_rate=1.0, provenance={{}})
rng = np.random.default_rng(0)
for k in itertools.count():
    animation.write(k, rng.normal(size=(particles.count, 2)), particles.velocities)
    print(k, flush=True)
"""


def big(count: int = 20_000) -> Particles:
    """Enough particles for a save to take a while."""
    zeros = np.zeros(count)
    return Particles(
        elastic=count,
        liquid=0,
        names=("cloud",),
        ranges=np.array([[0, count]]),
        positions=np.zeros((count, 2)),
        velocities=np.zeros((count, 2)),
        angular_velocities=np.zeros((count, 1)),
        masses=zeros,
        spacings=zeros + 0.1,
        bodies=np.zeros(count, int),
        materials=np.zeros(count, int),
        groups=np.zeros(count, int),
        ids=np.arange(count),
    )


# every save finds too much waste
COMPACTING = (
    "from warp_mps.usd.animation import points_file as points; points.LEAST_WASTE = 0; points.MOST_WASTE = -0.5"
)


@pytest.mark.parametrize("attempts", [1, pytest.param(5, marks=pytest.mark.long)])
@pytest.mark.parametrize("prologue", ["", COMPACTING])
def test_a_killed_writer_leaves_every_completed_frame(tmp_path: Path, prologue: str, attempts: int) -> None:
    """Also one that rewrites its files after every frame."""
    rng = random.Random(1)
    for attempt in range(attempts):
        path = tmp_path / f"{attempt}.usdc"
        child = subprocess.Popen(
            [sys.executable, "-c", CHILD.format(path=str(path), prologue=prologue)], stdout=subprocess.PIPE, text=True
        )
        assert child.stdout is not None
        for _ in range(5):
            child.stdout.readline()
        time.sleep(rng.uniform(0.0, 0.03))
        child.kill()
        done = 5 + len(child.stdout.read().split())
        child.wait()
        assert frames_seen_by_another_process(path) in (done, done + 1)

"""What every test session shares: the number of worker processes, and interrupts that arrive."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

# every worker imports Warp and holds kernels of its own; more than this many gain nothing
MOST_WORKERS = 4

# workers already share the cores; NumPy's own threads would only compete with them
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")


def pytest_xdist_auto_num_workers() -> int:
    """Workers of ``-n auto``: one for each core that this process may use, none (tests run in this process) on one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, MOST_WORKERS) if cores > 1 else 0


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Deliver SIGINT to the test and to the processes that it starts, even if a background shell ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)

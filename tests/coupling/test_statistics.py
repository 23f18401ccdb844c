"""Statistics of the fixed-point passes."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.coupling.statistics import CouplingStatistics


def test_passes_and_residuals() -> None:
    found = CouplingStatistics()
    assert found.record()["passes"] == 0.0
    for passes, residual in ((2, 1e-4), (20, 0.3), (5, 1e-3)):
        found.add(passes, residual, converged=residual < 0.1)
    record = found.record()
    assert (record["passes"], record["most_passes"], record["worst_residual"], record["unconverged"]) == (
        9.0,
        20,
        0.3,
        1,
    )


def test_statistics_go_on_from_a_checkpoint() -> None:
    """Also the count of steps in a row that diverged, which ends a run."""
    first, second = CouplingStatistics(), CouplingStatistics()
    for residual in (1e-4, 0.3, 0.2):
        first.add(4, residual, converged=residual < 0.1)
    second.assign(first.state())
    assert second == first
    assert second.diverged == 2
    for broken in (np.nan, -1.0, 1.5):
        state = first.state()
        state[4] = broken
        with pytest.raises(ValueError, match="whole numbers"):
            second.assign(state)

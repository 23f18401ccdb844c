"""Statistics of the fixed-point passes."""

from __future__ import annotations

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

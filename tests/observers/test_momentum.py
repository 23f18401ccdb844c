"""The monitor of momentum: the resultant of the internal forces, relative to their magnitudes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.observers.views import FakeView, blocks, view_of
from warp_mps.errors import RunError
from warp_mps.observers.momentum import MomentumMonitor


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks())


def look(monitor: MomentumMonitor, view: FakeView, first: float, second: float) -> float:
    """The error after a look at two forces along x."""
    view.internal_forces[:2, 0] = first, second
    monitor.observe(view)
    return monitor.error


def test_largest_resultant_over_the_largest_magnitude(view: FakeView) -> None:
    monitor = MomentumMonitor(every=10)
    assert monitor.error == 0.0
    assert look(monitor, view, 1.0, -1.0) == 0.0
    assert look(monitor, view, 1.0, -0.5) == pytest.approx(0.25)
    assert look(monitor, view, 9.0, -9.0) == pytest.approx(0.5 / 18.0)


def test_a_monitor_that_goes_on_knows_what_was_before(view: FakeView) -> None:
    """But for a last moment off the grid, where a run that goes on would not have looked."""
    first, second = MomentumMonitor(every=10), MomentumMonitor(every=10)
    look(first, view, 1.0, -0.5)
    view.step = 15
    assert look(first, view, 3.0, -1.0) == 0.5
    second.restore(json.loads(json.dumps(first.record())))
    assert second.error == pytest.approx(0.5 / 1.5)
    with pytest.raises(ValueError, match="magnitude is None, must be a finite number"):
        second.restore({"resultant": 1.0})


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_force_that_is_not_finite_stops_the_run(view: FakeView, value: float) -> None:
    """Of NaN, the larger of two numbers is the other."""
    monitor = MomentumMonitor(every=10)
    with pytest.raises(RunError, match=r"the force on particle 0 of body 'left' .* is not finite at 0 s \(step 0\)"):
        look(monitor, view, value, 0.0)

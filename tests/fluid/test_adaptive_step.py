"""Time steps by the CFL condition, and the clock."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import (
    L0,
    fluids_of,
    scene_of,
    tank,
    wall_count,
    water,
)
from warp_mps.scene import Flow


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_an_interval_takes_the_steps_that_its_fastest_particle_asks_for(precision: str, speed: float) -> None:
    """And ends at its time to the last bit, whatever the steps are."""
    flow = Flow(courant=0.25)
    fluids = fluids_of(scene_of(water([0.0, 0.0], [4 * L0, 4 * L0], velocity=(speed, 0.0)), flow=flow))
    limit = 0.25 * L0 / speed if speed else 0.05
    assert fluids.model.step_limit == pytest.approx(limit)
    for end in (0.1, 0.1 + 1.0 / 3.0):
        before = float(fluids.state.time.numpy()[0])
        assert fluids.advance(end) == np.ceil((end - before) / limit - 1e-6)
        assert fluids.state.time.numpy()[0] == end
    assert fluids.state.steps.numpy()[0] == sum(np.ceil(t / limit - 1e-6) for t in (0.1, 1.0 / 3.0))


def test_a_wall_that_moves_fast_shortens_the_steps() -> None:
    fluids = fluids_of(tank((8, 8)))
    w, u = wall_count(fluids), fluids.state.u.numpy()
    u[w // 2] = [30.0, 40.0]
    fluids.state.u.assign(u)
    fluids.step.time_step.set_target(1.0)
    fluids.step.set_time_step()
    assert fluids.step.time_step.dt.numpy()[0] == pytest.approx(0.2 * L0 / 50.0, rel=1e-3)


def test_a_step_that_is_given_is_kept_below() -> None:
    scene = scene_of(water([0.0, 0.0], [4 * L0, 4 * L0]), time_step=1e-3)
    assert fluids_of(scene).advance(0.0205) == 21

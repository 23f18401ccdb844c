"""Time step and domain of fluids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.fluid.scenes import tank
from warp_mps.errors import InputError
from warp_mps.fluid.domain import domain
from warp_mps.particles.filling import fill_scene
from warp_mps.run.cost import estimate
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Flow


@pytest.mark.parametrize(("corner", "name"), [(0, "low"), (1, "high")])
def test_a_domain_that_leaves_fluid_out_is_refused_as_by_a_check(corner: int, name: str) -> None:
    scene = tank((8, 8))
    filled = fill_scene(scene)
    x = filled.positions[filled.count - filled.liquid :]
    corners = [x.min(axis=0) - 1.0, x.max(axis=0) + 1.0]
    corners[corner] = x.mean(axis=0)
    tight = replace(scene, flow=Flow(domain=(tuple(corners[0]), tuple(corners[1]))))
    for refuse in (estimate, Simulation):
        with pytest.raises(InputError, match="leaves out fluid") as caught:
            refuse(tight)
        assert caught.value.attribute == f"flow.domain.{name}"


def test_particles_outside_a_period_are_carried_into_it() -> None:
    scene = tank((40, 8))
    filled = fill_scene(scene)
    x = filled.positions[filled.count - filled.liquid :]
    low, high = x.min(axis=0) - 1.0, x.max(axis=0) + 1.0
    low[0] = x[:, 0].mean()
    found = domain(replace(scene, flow=Flow(domain=(tuple(low), tuple(high)), periodic=(0,))), filled)
    assert (found[0] == low).all()


@pytest.mark.parametrize("gravity", [(0.0, -9.81), (3.0, 0.0), ()])
def test_by_default_there_is_most_room_against_gravity(gravity: tuple[float, ...]) -> None:
    scene = replace(tank((8, 8)), gravity=gravity)
    filled = fill_scene(scene)
    x = filled.positions
    size = (x.max(axis=0) - x.min(axis=0)).max()
    low, high = domain(scene, filled)
    g = np.array(gravity or (0.0, 0.0))
    np.testing.assert_allclose(x.min(axis=0) - low, size * (1.0 + (g > 0.0)))
    np.testing.assert_allclose(high - x.max(axis=0), size * (1.0 + (g < 0.0)))


def test_a_longer_step_than_the_limit_is_not_taken() -> None:
    simulation = Simulation(replace(tank((8, 8)), time_step=0.5))
    longest, limit = simulation.longest_step
    assert longest == limit == simulation.fluids.model.step_limit

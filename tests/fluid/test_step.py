"""The phases of a step: done one by one they are the step, and the state that they change is a checkpoint."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bits import assert_same_bits
from tests.fluid.scenes import L0, fluids_of, stir, tank
from warp_mps.fluid.fluids import Fluids
from warp_mps.scene import Flow, Liquid

PHASES = [
    "time step",
    "drift",
    "neighbour lists",
    "viscosity",
    "predictor",
    "assembly",
    "pressure solve",
    "corrector",
    "collisions",
    "clock",
]


def stirred() -> Fluids:
    """Viscous water in a tank, with velocities at random."""
    fluids = fluids_of(tank((8, 8), fluid={"liquid": Liquid(viscosity=1e-3)}, wall={"slip": "no"}))
    stir(fluids)
    fluids.step.time_step.set_target(1.0)
    return fluids


def test_phases_one_by_one_are_the_step() -> None:
    """With each named method called by hand, and as one graph."""
    by_hand, at_once = stirred(), stirred()
    step, end = by_hand.step, 0.0
    assert [name for name, _ in step.phases] == PHASES
    for _ in range(3):
        step.set_time_step()
        end += float(step.time_step.dt.numpy()[0])
        step.drift()
        step.update_neighbours()
        step.apply_viscosity()
        step.predict()
        step.assemble()
        step.solve_pressure()
        step.correct()
        step.collide()
        step.advance_clock()
        at_once.step.take()
    assert_same_bits([by_hand.state.arrays()], [at_once.state.arrays()])
    assert by_hand.state.steps.numpy()[0] == 3
    assert by_hand.state.now == pytest.approx(end, rel=1e-12)


def test_the_predictor_adds_gravity_and_the_corrector_the_pressure() -> None:
    """Of water at rest: u* = dt g, and the pressure brings u back to rest in the midst of the water."""
    fluids = fluids_of(tank((12, 12)))
    step, w = fluids.step, fluids.model.walls
    step.time_step.set_target(1.0)
    step.set_time_step()
    dt = float(step.time_step.dt.numpy()[0])
    step.drift()
    step.update_neighbours()
    step.predict()
    u = fluids.state.u.numpy()[w:]
    np.testing.assert_allclose(u, np.broadcast_to(dt * fluids.model.gravity, u.shape), rtol=1e-12)
    step.assemble()
    step.solve_pressure()
    step.correct()
    corrected = fluids.state.u.numpy()[w:]
    assert np.linalg.norm(corrected, axis=1).mean() < 0.3 * dt * 9.81


def test_a_step_that_is_replaced_ends_where_it_says() -> None:
    """Its displacement is in the ratio of the lengths, and the last step ends at the target to the bit."""
    fluids = stirred()
    time_step = fluids.step.time_step
    time_step.choose()
    dt, way = float(time_step.dt.numpy()[0]), float(time_step.displacement.numpy()[0])
    assert way > 0.0
    assert time_step.replace(0.5 * dt, 7) == pytest.approx(0.5 * dt)
    assert time_step.displacement.numpy()[0] == pytest.approx(0.5 * way)
    assert time_step.steps_left.numpy()[0] == 7
    assert time_step.replace(0.25 * dt, 1) == 1.0
    time_step.advance_clock()
    assert fluids.state.now == 1.0


def test_sorted_particles_keep_their_values() -> None:
    """In the order of the scene, whatever their order in memory."""
    fluids = stirred()
    state, w = fluids.state, fluids.model.walls
    state.p.assign(np.arange(len(state.p), dtype=float))
    rng = np.random.default_rng(1)
    x = state.x.numpy()
    x[w:] = x[w:][rng.permutation(len(x) - w)]
    state.x.assign(x)
    before = [state.in_scene_order(state.x), state.in_scene_order(state.u), state.fluid_in_scene_order(state.p.numpy())]
    state.sort(fluids.model.low, 2.0 * fluids.model.operators.radius)
    after = [state.in_scene_order(state.x), state.in_scene_order(state.u), state.fluid_in_scene_order(state.p.numpy())]
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.any(state.order.numpy() != np.arange(len(state.p)))
    cells = np.floor((state.x.numpy()[w:] - fluids.model.low) / (2.0 * fluids.model.operators.radius))
    changes = np.any(np.diff(cells, axis=0) != 0.0, axis=1).sum()
    assert changes == len(np.unique(cells, axis=0)) - 1


def test_constants_of_a_run() -> None:
    """Masses, schemes and walls of the model, as the scene has them."""
    model = fluids_of(tank((8, 8), wall={"slip": "no"}, flow=Flow(scheme="corrected"))).model
    assert model.mass == pytest.approx(1000.0 * L0**2)
    assert model.count == 64
    assert model.walls == model.particles.count - 64
    assert model.shifting
    assert model.no_slip.numpy().all()
    assert (model.collision_share.numpy() == 1.0).all()
    assert model.relaxation_time == pytest.approx(3.0 * np.sqrt(L0 / 9.81))
    assert fluids_of(tank((8, 8))).model.relaxation_time == pytest.approx(2.0 * np.sqrt(L0 / 9.81))


@pytest.mark.parametrize("scheme", ["corrected", "koshizuka_oka"])
def test_other_schemes_evaluate_the_pressure_at_predicted_positions(scheme: str) -> None:
    """The neighbour lists are those of x* = x + dt u*, and the pressure's change of velocity acts on the whole step."""
    fluids = fluids_of(tank((8, 8), flow=Flow(scheme=scheme), fluid={"liquid": Liquid(viscosity=0.0)}))
    stir(fluids)
    step, w = fluids.step, fluids.model.walls
    assert [name for name, _ in step.phases] == [PHASES[0], *PHASES[3:5], "neighbour lists", *PHASES[5:]]
    step.time_step.set_target(1.0)
    x, u = (array.numpy()[w:].astype(float) for array in (fluids.state.x, fluids.state.u))
    for name, launch in step.phases:
        launch()
        if name == "predictor":
            dt = float(step.time_step.dt.numpy()[0])
            np.testing.assert_allclose(fluids.state.x.numpy()[w:], x + dt * (u + dt * fluids.model.gravity), rtol=1e-12)
        if name == "corrector":
            np.testing.assert_allclose(fluids.state.x.numpy()[w:], x + dt * fluids.state.u.numpy()[w:], rtol=1e-12)

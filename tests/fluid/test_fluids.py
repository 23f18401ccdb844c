"""Runs of fluids: the same bits whichever way they are launched, restarts, and the order of particles."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bits import assert_same_bits, states
from tests.fluid.scenes import L0, SCHEMES, fluids_of, scene_of, tank, wall_count, water
from warp_mps.errors import InputError, RunError
from warp_mps.fluid import time_loop
from warp_mps.observers.base import View
from warp_mps.observers.guard import Guard
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Flow, HarmonicRotation, Liquid, Scene

INTERVAL = 0.01


def splash(dimension: int, **flow: object) -> Scene:
    """A column of viscous water that falls over in a tank that is rocked."""
    cells, room = ((8, 14), (16, 16)) if dimension == 2 else ((4, 6, 4), (8, 7, 4))
    axis = {"axis": (0.0, 0.0, 1.0)} if dimension == 3 else {}
    rock = HarmonicRotation(amplitude=0.1, frequency=2.0, pivot=(0.16, 0.0, 0.0)[:dimension], **axis)
    return tank(
        cells,
        room=room,
        flow=Flow(**flow),  # type: ignore[arg-type]
        wall={"rotation": rock, "slip": "no"},
        fluid={"liquid": Liquid(viscosity=1e-4)},
        duration=0.3,
        frame_rate=1.0 / INTERVAL,
    )


@pytest.mark.long
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("dimension", "precision"), [(2, "float64"), (3, "float32")])
def test_a_restored_run_continues_to_the_same_bits(
    dimension: int, precision: str, scheme: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the particles are sorted every few intervals, and lists are not fresh."""
    monkeypatch.setattr(time_loop, "SORT_EVERY", 25)
    scene = splash(dimension, scheme=scheme)
    simulation = Simulation(scene, precision=precision)
    simulation.advance(9)
    saved = simulation.state_arrays()
    while np.array_equal(saved["x"], saved["x_listed"]):
        simulation.advance(1)
        saved = simulation.state_arrays()
    assert not np.array_equal(saved["order"], np.sort(saved["order"]))
    later = states(simulation, 3, 6)
    energy, forces = simulation.energy, simulation.internal_forces
    assert not np.array_equal(later[-1]["order"], saved["order"])
    for graphs in (True, False):
        restored = Simulation(scene, precision=precision, graphs=graphs)
        restored.advance(2)
        restored.restore(saved)
        assert restored.step == int(saved["step"])
        assert_same_bits([restored.state_arrays()], [saved])
        assert_same_bits(states(restored, 3, 6), later)
        assert restored.energy == energy
        np.testing.assert_array_equal(restored.internal_forces, forces)


def test_what_a_restored_run_shows_is_what_was_shown() -> None:
    """Before it goes on, too: forces of the last interval are part of the state."""
    simulation = Simulation(splash(2))
    simulation.advance(5)
    restored = Simulation(splash(2))
    restored.restore(simulation.state_arrays())
    assert np.abs(simulation.internal_forces).max() > 0.0
    for name in (
        "positions",
        "velocities",
        "pressures",
        "number_densities",
        "volumes",
        "contact_forces",
        "internal_forces",
    ):
        np.testing.assert_array_equal(getattr(restored, name), getattr(simulation, name), err_msg=name)
    assert restored.energy == simulation.energy


def test_a_restored_run_that_loses_particles_continues_to_the_same_bits() -> None:
    """Water that runs out of its domain over the edge of a table, some of it in every interval."""
    flow = Flow(domain=([-0.2, -0.2], [0.2, 0.5]))
    scene = tank((10, 8), room=(10, 8), flow=flow, duration=1.0)
    scene = scene_of(*scene.fluids, walls=scene.walls[:2], gravity=scene.gravity, flow=flow, frame_rate=200.0)
    simulation = Simulation(scene)
    lost = []
    for k in range(30):
        saved = simulation.state_arrays()
        simulation.advance(1)
        lost.append(simulation.fluids.readings.lost())
        if k > 0 and lost[-1] > lost[-2] and int(simulation.state_arrays()["stale"][0]):
            break
    assert lost[-1] > 0
    assert simulation.state_arrays()["stale"][0] == 1
    saved = simulation.state_arrays()
    later = states(simulation, 1, 5)
    restored = Simulation(scene)
    restored.restore(saved)
    assert_same_bits(states(restored, 1, 5), later)


def test_what_is_shown_is_in_the_order_of_the_particles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever order they are computed in: a run that sorts stays, for a time, near one that does not."""
    never = Simulation(splash(2))
    never.advance(6)
    monkeypatch.setattr(time_loop, "SORT_EVERY", 5)
    sorts = Simulation(splash(2))
    sorts.advance(6)
    order = sorts.state_arrays()["order"]
    assert not np.array_equal(order, np.arange(len(order)))
    assert np.array_equal(np.sort(order), np.arange(len(order)))
    for name in ("positions", "velocities", "displacements", "number_densities", "volumes"):
        a, b = getattr(sorts, name), getattr(never, name)
        np.testing.assert_allclose(a, b, atol=2e-3 * np.abs(b).max(), err_msg=name)
    difference = sorts.pressures - never.pressures
    assert np.sqrt(np.mean(difference**2)) < 0.02 * np.sqrt(np.mean(never.pressures**2))
    np.testing.assert_allclose(
        sorts.internal_forces, never.internal_forces, atol=0.05 * np.abs(never.internal_forces).max()
    )


def test_sorted_particles_are_near_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_loop, "SORT_EVERY", 5)
    simulation = Simulation(splash(2))
    rng = np.random.default_rng(0)
    state = simulation.fluids.state
    w = len(state.x) - len(state.p)
    new = rng.permutation(len(state.p))
    for array in (state.x, state.u):
        values = array.numpy().copy()
        values[w:] = values[w:][new]
        array.assign(values)
    state.order.assign(state.order.numpy()[new])
    simulation.fluids.step.neighbours.renew(state.x, state.lost)
    apart = [np.linalg.norm(np.diff(state.x.numpy()[w:], axis=0), axis=1).mean()]
    simulation.advance(2)
    apart.append(np.linalg.norm(np.diff(state.x.numpy()[w:], axis=0), axis=1).mean())
    assert apart[1] < 0.5 * apart[0]
    assert np.abs(simulation.displacements[w:]).max() < 3.0 * L0


def test_fluids_take_one_thread() -> None:
    with pytest.raises(InputError, match="threads: is 2; fluids take one"):
        Simulation(splash(2), threads=2)


def test_a_leak_ends_the_run() -> None:
    """Water over a hole: particles that have left the domain are counted."""
    flow = Flow(domain=([-0.3, -0.2], [0.3, 0.5]))
    simulation = Simulation(scene_of(water([0.0, 0.0], [0.1, 0.1]), gravity=(0.0, -9.81), flow=flow, duration=1.0))
    with pytest.raises(
        RunError, match=r"^at t = 0\.\d+ s: \d+ of 25 fluid particles have left the domain: \d+ at its low y end, as"
    ):
        simulation.run([Guard(every=1, time_step=INTERVAL)])
    assert 0.19 < simulation.time < 0.22


def test_a_period_that_is_too_short_is_refused() -> None:
    flow = Flow(domain=([0.0, 0.0], [0.16, 0.5]), periodic=(0,))
    with pytest.raises(InputError, match=r"domain\.high: makes a period of 0\.16 m, must be at least 0\.204 m"):
        Simulation(scene_of(water([0.0, 0.0], [0.1, 0.1]), flow=flow))


def test_views_hold_what_observers_ask_for() -> None:
    simulation: View = Simulation(splash(2))
    n = simulation.particles.count
    for name in ("stresses", "strains"):
        assert getattr(simulation, name).shape == (n, 3, 3)
    for name in ("rotations", "elastic_torques"):
        assert getattr(simulation, name).shape == (n, 1)
    for name in ("pressures", "number_densities", "volumes", "von_mises", "strain_energy_densities"):
        assert getattr(simulation, name).shape == (n,)
    assert not simulation.reactions.any()


def test_water_that_collapses_into_a_point_ends_the_run() -> None:
    """Beyond all the room that lists may have."""
    simulation = Simulation(scene_of(water([0.0, 0.0], [0.6, 0.6]), duration=0.1))
    state = simulation.fluids.state
    x = state.x.numpy().copy()
    x[:] = [0.1, 0.3] + 0.01 * x
    state.x.assign(x)
    simulation.fluids.step.neighbours.renew(state.x, state.lost)
    with pytest.raises(RunError, match=r"^at t = .* s: more .* about particle .* at \(.*, .*\) m than a"):
        simulation.run()


def clustered(*, graphs: bool = True, viscosity: float = 0.0) -> Simulation:
    """A tank of water in whose midst some particles have been put upon each other."""
    liquid = {"liquid": Liquid(viscosity=viscosity)}
    simulation = Simulation(tank((12, 12), room=(12, 16), fluid=liquid, duration=0.5, frame_rate=100.0), graphs=graphs)
    fluids = simulation.fluids
    x, w = fluids.state.x.numpy().copy(), wall_count(fluids)
    middle = np.argsort(np.linalg.norm(x[w:] - 6 * L0, axis=1))[:90] + w
    x[middle] = 6 * L0 + 0.15 * (x[middle] - 6 * L0)
    fluids.state.x.assign(x)
    fluids.step.renew_neighbours()
    return simulation


@pytest.mark.parametrize("viscosity", [0.0, 0.5])
def test_lists_grow_where_particles_crowd(viscosity: float) -> None:
    """Graphs are captured again, implicit viscosity has its rows, and a run that is restored gets the same room."""
    runs = [clustered(viscosity=viscosity), clustered(viscosity=viscosity, graphs=False)]
    room = runs[0].fluids.step.neighbours.listed.shape[1]
    assert runs[0].fluids.step.neighbours.overflowed() is not None
    for run in runs:
        run.advance(1)
    restored = clustered(viscosity=viscosity)
    restored.restore(runs[0].state_arrays())
    for run in (*runs, restored):
        run.advance(2)
        assert run.fluids.step.neighbours.listed.shape[1] > room
        assert run.fluids.step.neighbours.overflowed() is None
        assert run.fluids.trouble() is None
    for other in (runs[1], restored):
        for name in ("positions", "velocities", "pressures", "volumes"):
            np.testing.assert_array_equal(getattr(other, name), getattr(runs[0], name), err_msg=name)


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.long)])
def test_lists_have_room_for_the_crowds_of_a_dam_break(dimension: int) -> None:
    cells, room = ((12, 24), (36, 26)) if dimension == 2 else ((6, 12, 6), (18, 14, 6))
    fluids = fluids_of(tank(cells, room=room))
    room_first, full, most = fluids.step.neighbours.listed.shape[1], fluids.step.neighbours.count.numpy().max(), 0
    for _ in range(30):
        fluids.advance(fluids.time + 10 * fluids.model.step_limit)
        most = max(most, fluids.step.neighbours.count.numpy().max())
    assert most > 1.04 * full
    assert fluids.step.neighbours.listed.shape[1] == room_first


@pytest.mark.parametrize("graphs", [True, False])
def test_a_particle_that_runs_away_ends_the_run_at_once(graphs: bool) -> None:
    """Else its speed would make the steps so short that the run no longer gets on."""
    fluids = fluids_of(tank((8, 8), room=(8, 12)), graphs=graphs)
    fluids.advance(0.01)
    u, w, steps = fluids.state.u.numpy(), wall_count(fluids), int(fluids.state.steps.numpy()[0])
    k = 20
    u[w + k] = [0.0, -3e4]
    fluids.state.u.assign(u)
    particle = w + fluids.state.order.numpy()[k]
    with pytest.raises(
        RunError, match=rf"^at t = 0\.01\d* s: particle {particle} of body 'water' .* m moves at .* m/s: it runs away,"
    ):
        fluids.advance(0.02)
    assert fluids.state.steps.numpy()[0] == steps + 1


def test_what_is_fast_has_not_run_away() -> None:
    """Water that is only as fast as a wall, or fast but not by so much."""
    fluids = fluids_of(tank((8, 8)))
    u, w = fluids.state.u.numpy(), wall_count(fluids)
    usual = Flow().courant * L0 / fluids.model.step_limit
    for wall, fluid, fled in ((0.0, 900.0, False), (0.0, 1100.0, True), (10.0, 9e3, False), (10.0, 1.1e4, True)):
        u[0, 0], u[w, 0] = wall * usual, fluid * usual
        fluids.state.u.assign(u)
        assert (fluids.failures.find_runaway() is not None) == fled

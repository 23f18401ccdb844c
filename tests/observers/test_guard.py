"""The guard: what stops a run, and what must not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.observers.views import REST, FakeView, blocks, view_of
from warp_mps.errors import RunError
from warp_mps.observers.guard import Guard


@pytest.fixture
def guard() -> Guard:
    return Guard(every=1, time_step=1e-4)


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks())


def look(guard: Guard, view: FakeView, **energies: float) -> None:
    view.energy = dataclasses.replace(REST, **energies)
    guard.observe(view)


@pytest.mark.parametrize("field", ["displacements", "velocities"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_stop_the_run(guard: Guard, view: FakeView, field: str, value: float) -> None:
    guard.observe(view)
    getattr(view, field)[20, 1] = value
    view.time, view.step = 0.25, 2500
    x, y = view.particles.positions[20]
    name = "position" if field == "displacements" else "velocity"
    expected = (
        f"the {name} of particle {view.particles.ids[20]} of body 'right' (from ({x:.6g}, {y:.6g}) m) is not finite at "
        "0.25 s (step 2500); the time step of 0.0001 s is probably too large"
    )
    with pytest.raises(RunError) as caught:
        guard.observe(view)
    assert str(caught.value) == expected


def test_a_scene_at_rest_passes(guard: Guard, view: FakeView) -> None:
    for _ in range(5):
        look(guard, view)


def test_rounding_of_a_resting_scene_in_gravity_passes(guard: Guard, view: FakeView) -> None:
    look(guard, view, potential=1e6)
    look(guard, view, potential=1e6 + 0.5, kinetic=1e-9)


def test_exchange_between_the_energies_passes(guard: Guard, view: FakeView) -> None:
    look(guard, view, kinetic=1.0, potential=-3.0)
    look(guard, view, elastic=0.5, contact=0.5, potential=-3.0)
    look(guard, view, kinetic=4.0, elastic=2.0, potential=-3.0, work=5.0)
    look(guard, view, kinetic=1.0, potential=-3.0, work=5.0, dissipated=5.0)


def test_energy_from_nowhere_stops_the_run_and_names_the_fastest_particle(guard: Guard, view: FakeView) -> None:
    look(guard, view, kinetic=1.0)
    look(guard, view, kinetic=1.05)
    view.velocities[3] = [3.0, 4.0]
    with pytest.raises(RunError, match=rf"particle {view.particles.ids[3]} of body 'left' .* at 5 m/s; the time step"):
        look(guard, view, kinetic=1.2)


def test_a_small_part_of_the_work_passes_and_a_large_one_does_not(guard: Guard, view: FakeView) -> None:
    look(guard, view)
    look(guard, view, kinetic=1.05, work=1.0, dissipated=0.0)
    with pytest.raises(RunError, match="the energy balance has grown by"):
        look(guard, view, kinetic=1.3, work=1.0)


def test_lost_energy_passes(guard: Guard, view: FakeView) -> None:
    look(guard, view, kinetic=1.0)
    look(guard, view, kinetic=0.1)


def test_an_energy_that_is_not_a_number_stops_the_run(guard: Guard, view: FakeView) -> None:
    look(guard, view)
    with pytest.raises(RunError):
        look(guard, view, elastic=np.nan)

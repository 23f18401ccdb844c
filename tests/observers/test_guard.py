"""The guard: what stops a run, and what must not."""

from __future__ import annotations

import contextlib
import dataclasses
import json

import numpy as np
import pytest

from tests.coupling.scenes import lump, pool
from tests.fluid.scenes import L0, tank
from tests.observers.views import REST, FakeView, blocks, view_of
from warp_mps.errors import RunError
from warp_mps.observers.guard import Guard
from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.scene import HarmonicMotion

CAUSE = "what acts on the bodies is too violent for the time step of 0.0001 s"
# weight times spacing of water of 8 by 8 particles [J/m]
WEIGHT = 1000.0 * 9.81 * 64 * L0**3


@pytest.fixture
def guard() -> Guard:
    return Guard(every=1, time_step=1e-4)


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks())


@pytest.fixture
def water() -> FakeView:
    """A moment of water of 8 by 8 particles."""
    return view_of(tank((8, 8)))


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
        f"0.25 s (step 2500); {CAUSE}"
    )
    with pytest.raises(RunError) as caught:
        guard.observe(view)
    assert str(caught.value).startswith(expected)


def test_a_scene_at_rest_passes(guard: Guard, view: FakeView) -> None:
    for _ in range(3):
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
    with pytest.raises(RunError, match=rf"particle {view.particles.ids[3]} of body 'left' .* at 5 m/s; {CAUSE}"):
        look(guard, view, kinetic=1.2)


def test_a_small_part_of_the_work_passes_and_a_large_one_does_not(guard: Guard, view: FakeView) -> None:
    look(guard, view)
    look(guard, view, kinetic=1.05, work=1.0, dissipated=0.0)
    with pytest.raises(RunError, match="the energy balance has grown by"):
        look(guard, view, kinetic=1.3, work=1.0)


def test_lost_energy_passes(guard: Guard, view: FakeView) -> None:
    look(guard, view, kinetic=1.0)
    look(guard, view, kinetic=0.1)


def test_energy_from_nowhere_is_seen_beside_what_was_lost(guard: Guard, view: FakeView) -> None:
    """Losses that nothing counts, as those of water, are no credit."""
    look(guard, view, kinetic=1.0)
    look(guard, view, kinetic=0.1)
    with pytest.raises(RunError, match=r"the energy balance has grown by 0\.3 J/m"):
        look(guard, view, kinetic=0.4)


def test_what_was_exchanged_long_before_is_no_credit(guard: Guard, view: FakeView) -> None:
    """Work that was put in and dissipated, cycle after cycle, allows for nothing in the next."""
    for cycle in range(10):
        look(guard, view, kinetic=1.0, work=10.0 * cycle, dissipated=10.0 * cycle - 0.01 * cycle - 1.0)
    with pytest.raises(RunError, match=r"grown by 0\.3 J/m since it was least .* since then: 1\.3 J/m"):
        look(guard, view, kinetic=1.3, work=90.0, dissipated=88.91)


def test_rounding_of_work_and_of_what_was_dissipated_passes(guard: Guard, view: FakeView) -> None:
    """In single precision, after a body has come to rest."""
    look(guard, view, kinetic=1e3)
    look(guard, view, work=5e3, dissipated=6e3)
    look(guard, view, work=5e3 - 2e-3, dissipated=6e3)


def test_dissipated_energy_that_returns_is_energy_from_nowhere(guard: Guard, view: FakeView) -> None:
    """An implicit step counts whatever closes its balance as dissipated."""
    look(guard, view, kinetic=1.0)
    look(guard, view, kinetic=0.2, dissipated=0.8)
    look(guard, view, kinetic=0.21, dissipated=0.79)
    with pytest.raises(RunError, match=r"the energy balance has grown by 0\.4 J/m"):
        look(guard, view, kinetic=0.6, dissipated=0.4)


@pytest.mark.parametrize("name", ENERGY_NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("energy", [True, False])
def test_an_energy_that_is_not_finite_stops_the_run(view: FakeView, name: str, value: float, energy: bool) -> None:
    """Also in statics, and at the first look."""
    guard = Guard(every=1, time_step=1e-4, energy=energy)
    label = "dissipated energy" if name == "dissipated" else ENERGY_NAMES[name]
    with pytest.raises(RunError, match=rf"^the {label} is not finite at 0 s \(step 0\); {CAUSE}"):
        look(guard, view, **{name: value})


def test_water_at_rest_settles_and_swells(guard: Guard, water: FakeView) -> None:
    look(guard, water)
    look(guard, water, potential=-0.02 * WEIGHT)
    look(guard, water, potential=0.03 * WEIGHT, kinetic=0.001 * WEIGHT)
    with pytest.raises(RunError, match="the energy balance has grown by"):
        look(guard, water, potential=0.12 * WEIGHT, kinetic=0.001 * WEIGHT)


def test_water_that_begins_to_move_by_itself_stops_the_run(guard: Guard, water: FakeView) -> None:
    """Motion that neither the start, nor work, nor a fall has given, also where the surface rises less than it may."""
    look(guard, water)
    look(guard, water, kinetic=0.004 * WEIGHT)
    look(guard, water, kinetic=0.02 * WEIGHT, potential=-0.015 * WEIGHT)
    with pytest.raises(RunError, match=r"contact energy of \S+ J/m is \S+ J/m more than the start, work and potential"):
        look(guard, water, kinetic=0.03 * WEIGHT)


def legs(energies: list[float], parts: int, view: FakeView) -> int | None:
    """The moment at which a run in some parts, each continued from the checkpoint's records, is stopped."""
    record: dict = {}
    for part in np.array_split(np.arange(len(energies)), parts):
        leg = Guard(every=1, time_step=1e-4)
        if record:
            leg.restore(json.loads(json.dumps(record)))
        # a run that is resumed shows the moment of its checkpoint again
        for k in [*part[:1] - 1, *part] if record else part:
            try:
                look(leg, view, kinetic=energies[k])
            except RunError:
                return int(k)
        record = leg.record()
    return None


@pytest.mark.parametrize("parts", [1, 2, 3, 5, 10])
def test_a_run_in_parts_is_judged_like_one_that_was_never_interrupted(parts: int, view: FakeView) -> None:
    """3 % a moment: no part alone gains 10 %."""
    energies = [1.0 + 0.03 * k for k in range(10)]
    assert legs(energies, parts, view) == 4
    assert legs(energies[:4] + [1.0] * 6, parts, view) is None


def test_a_last_moment_off_the_grid_is_judged_and_not_kept(view: FakeView) -> None:
    guard = Guard(every=10, time_step=1e-4)
    look(guard, view, kinetic=1.0)
    before = guard.record()
    view.step = 15
    look(guard, view, kinetic=0.9)
    assert guard.record() == before
    with pytest.raises(RunError, match="the energy balance has grown"):
        look(guard, view, kinetic=1.5)


NONE = [None, {}, [1.0], {"all": {"start": "a"}}, {"all": {"start": np.nan}}, {"all": 1.0}]


@pytest.mark.parametrize("record", NONE)
def test_records_that_are_none_are_refused(guard: Guard, record: object) -> None:
    with pytest.raises(ValueError, match=r"start is .* a finite number|what the guard has seen is .*, must be"):
        guard.restore(record)


def test_water_about_a_body_may_rise_by_the_gap_that_it_leaves() -> None:
    """By twice the weight of the water before its largest face times a spacing, and not by much more."""
    water = view_of(pool(lump([3, 3], [4, 3])))
    gap = 2.0 * 1000.0 * 9.81 * (7.0 * L0) * (4.0 * L0) * L0
    guard = Guard(every=1, time_step=1e-4)
    guard.observe(water)
    look(guard, water, potential=gap)
    with pytest.raises(RunError, match="the energy balance has grown by"):
        look(guard, water, potential=gap + 0.2 * 1000.0 * 9.81 * 68 * L0**3)


def test_a_wall_that_moves_between_others_leaves_a_gap_and_a_tank_that_moves_as_a_whole_does_not() -> None:
    scene, motion = tank((8, 8)), HarmonicMotion(amplitude=(0.01, 0.0), frequency=1.0)
    whole = dataclasses.replace(scene, walls=tuple(dataclasses.replace(wall, motion=motion) for wall in scene.walls))
    one = dataclasses.replace(scene, walls=(*scene.walls[:-1], whole.walls[-1]))
    for case, allowed in ((one, True), (whole, False)):
        guard, view = Guard(every=1, time_step=1e-4), view_of(case)
        look(guard, view)
        with pytest.raises(RunError) if not allowed else contextlib.nullcontext():
            look(guard, view, potential=0.5 * WEIGHT)


def test_bodies_in_water_are_judged_without_what_water_may_do() -> None:
    """Beside the weight of the water a gain of light bodies would not be seen, also not in a second part of the run."""
    water = view_of(pool(lump([3, 3], [4, 3])))
    energies = [1e-3 * WEIGHT * size for size in (1.0, 1.08, 1.16)]
    guard = Guard(every=1, time_step=1e-4)
    for kinetic in energies[:2]:
        water.energy = water.energy_of_bodies = dataclasses.replace(REST, kinetic=kinetic)
        guard.observe(water)
    second = Guard(every=1, time_step=1e-4)
    second.restore(json.loads(json.dumps(guard.record())))
    water.energy = water.energy_of_bodies = dataclasses.replace(REST, kinetic=energies[2])
    expected = r"the energy balance of the bodies has grown by .* m/s; the bodies have become unstable in the water"
    with pytest.raises(RunError, match=expected):
        second.observe(water)
    water.energy_of_bodies = None
    Guard(every=1, time_step=1e-4).observe(water)

"""Coupled runs: the same bits whichever way they are launched, restarts, and single precision."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.bits import assert_restored_goes_on, assert_same_bits, states
from tests.coupling.scenes import EXPLICIT, IMPLICIT, RUBBING, WAYS, afloat, busy, hung, lump, pool
from tests.fluid.scenes import L0
from warp_mps.coupling import added_mass
from warp_mps.fluid import time_loop
from warp_mps.results.history import read_history
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import HarmonicMotion, Material, Probe

ALL_WAYS = [RUBBING, IMPLICIT]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("dimension", "precision"),
    [
        (2, "float64"),
        pytest.param(2, "float32", marks=pytest.mark.long),
        pytest.param(3, "float64", marks=pytest.mark.long),
        (3, "float32"),
    ],
)
def test_graphs_and_kernels_give_the_same_bits_and_the_same_run_twice(
    way: dict, dimension: int, precision: str
) -> None:
    scene, chunks = hung(dimension, **way), (1, 3)
    expected = states(Simulation(scene, precision=precision), *chunks)
    assert expected[-1]["water_steps"][0] >= 15
    assert np.abs(expected[-1]["bodies_u"]).max() > 1e-7
    for graphs in (True, False):
        assert_same_bits(states(Simulation(scene, precision=precision, graphs=graphs), *chunks), expected)


@pytest.mark.parametrize("way", [pytest.param(RUBBING, marks=pytest.mark.long), IMPLICIT])
def test_a_restored_run_goes_on_to_the_same_bits(way: dict, monkeypatch: pytest.MonkeyPatch) -> None:
    """While particles are sorted, steps change their length, and mobilities are measured again."""
    monkeypatch.setattr(time_loop, "SORT_EVERY", 25)
    monkeypatch.setattr(added_mass, "STEPS", 15)
    scene = busy(**way)
    for first, rest in ((1, 4), (8, 6)):
        assert_restored_goes_on(scene, first, rest)
    simulation = Simulation(scene)
    found = states(simulation, *[1] * 14)
    order = found[-1]["water_order"]
    assert not np.array_equal(order, np.sort(order))
    assert len({state["water_mobility"].tobytes() for state in found}) > 2
    assert len(np.unique(np.diff([0, *(int(state["water_steps"][0]) for state in found)]))) > 1
    assert max(len(state["water_learnt_sizes"]) for state in found) > 1


@pytest.mark.parametrize("way", ALL_WAYS)
@pytest.mark.parametrize("first", [pytest.param(0.06, marks=pytest.mark.long), 0.05])
def test_a_run_in_two_parts_is_the_run_in_one(
    way: dict, first: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In files; also where the first part ends between two frames."""
    monkeypatch.setattr(time_loop, "SORT_EVERY", 25)
    probes = (
        Probe(name="light", body="light", quantity="displacement", path="light"),
        Probe(name="push", body="light", quantity="contact_force"),
        Probe(name="wall", body="x_low", quantity="contact_force"),
        Probe(name="stress", point=(7.5 * L0, 5.5 * L0), quantity="stress"),
    )
    scene = busy(probes=probes, name="busy", **{**way, "duration": 0.12, "frame_rate": 50.0, "sample_rate": 100.0})
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    summary = run_scene(scene, whole, quiet=True)
    run_scene(replace(scene, duration=first), parts, quiet=True)
    resumed = run_scene(scene, parts, quiet=True, resume=True)
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    assert len(read_history(whole / "probes.csv").rows) == 13
    assert (resumed.steps, resumed.time, resumed.energy) == (summary.steps, summary.time, summary.energy)
    for name in ("coupling", "fluid", "implicit", "momentum_error"):
        assert getattr(resumed, name) == getattr(summary, name), name
    assert summary.momentum_error < 1e-8
    assert summary.coupling["unconverged"] == 0
    assert 1.0 <= summary.coupling["passes"] <= summary.coupling["most_passes"] <= 20


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_single_precision_stays_near_double(way: dict, dimension: int) -> None:
    runs = [Simulation(afloat(500.0, dimension=dimension, **way), precision=name) for name in ("float64", "float32")]
    for simulation in runs:
        simulation.advance(5)
    double, single = (simulation.displacements[: simulation.particles.elastic] for simulation in runs)
    assert double[:, 1].min() > 1e-3 * L0
    np.testing.assert_allclose(single, double, atol=0.02 * np.abs(double).max())


def test_what_both_ways_have_in_common() -> None:
    """Implicit and explicit steps are two rules for one motion."""
    ends = []
    for way in (EXPLICIT, IMPLICIT):
        simulation = Simulation(afloat(500.0, **way))
        simulation.advance(6)
        ends.append(simulation.displacements[: simulation.particles.elastic].mean(axis=0))
    np.testing.assert_allclose(ends[1], ends[0], atol=0.05 * np.abs(ends[0]).max())


def test_moving_supports_carry_bodies_through_water() -> None:
    """A paddle: the support does the work, and water and body hold it or have spent it."""
    for way in WAYS:
        made = hung(**way)
        motion = HarmonicMotion(amplitude=(0.5 * L0, 0.0), frequency=4.0)
        simulation = Simulation(replace(made, supports=(replace(made.supports[0], motion=motion),)))
        start = simulation.energy
        simulation.advance(6)
        energy = simulation.energy
        assert energy.work > 0.02
        assert energy.balance - start.balance < 0.0
        assert simulation.record()["coupling"]["unconverged"] == 0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("density", [300.0, 1700.0])
def test_bodies_that_rise_and_sink_pass_the_guards(way: dict, density: float, tmp_path: Path) -> None:
    """Water is lifted by the gap that a body leaves behind it, and that is no failure."""
    body = lump([3, 3], [4, 3], material=Material(density, 5e5, 0.3))
    scene = pool(body, cells=(10, 8), room=(10, 16), **{**way, "duration": 0.4, "sample_rate": 100.0})
    summary = run_scene(scene, tmp_path, quiet=True)
    assert summary.status == "done"
    assert summary.energy["kinetic"] > 0.1

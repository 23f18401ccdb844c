"""The shipped cases as they are shipped, against their references.

The references and their sources stand in the stages. The tolerances here are those reached at the shipped
resolution.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warp_mps.results.history import read_history
from warp_mps.results.summary import RunSummary
from warp_mps.run.run import run_scene
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.shipped_cases import shipped_cases

# largest relative error of each result, and the largest energy drift
TOLERANCES: dict[str, tuple[dict[str, float], float]] = {
    "beam_first_mode": ({"frequency": 0.002, "mean deflection": 0.005}, 1e-3),
    "beam_second_mode": ({"frequency": 0.002}, 1e-3),
    # the paper's lattice and supports are guessed: see the stages
    "beam_first_mode_as_published": ({"frequency": 0.07, "largest deflection": 0.11}, 1e-3),
    "beam_second_mode_as_published": ({"frequency": 0.01}, 1e-3),
    "mass_spring_free": ({"frequency": 0.002, "mean": 0.002, "amplitude": 0.002}, 1e-3),
    # the references take the block for rigid
    "mass_spring_forced": (
        {
            "amplitude at half of resonance": 0.002,
            "phase at half of resonance": 0.002,
            "amplitude at resonance": 0.002,
            "phase at resonance": 0.002,
            "amplitude at twice resonance": 0.002,
            "phase at twice resonance": 0.002,
        },
        1e-3,
    ),
    "ring_collision": ({}, 0.01),
    "ring_collision_gray": (
        {
            "restitution, 0.059 c0": 0.015,
            "contact time, 0.059 c0": 0.015,
            "least width, 0.059 c0": 0.015,
            "restitution, 0.02 c0": 0.015,
            "contact time, 0.02 c0": 0.015,
            "least width, 0.02 c0": 0.015,
        },
        0.01,
    ),
    "block_on_wall": (
        {
            "restitution, square block": 0.015,
            "contact time, square block": 0.02,
            "restitution, slender block": 0.01,
            "contact time, slender block": 0.015,
        },
        1e-3,
    ),
    "block_on_elastic_base": ({}, 0.01),
    # the layer of contact is as soft as a spacing of the bar
    "bar_struck_by_wall": ({"contact time": 0.03, "speed after": 0.015, "push": 0.015}, 1e-4),
    # the particles of the block rattle on those of the floor
    "paddle_and_block": ({"weight on the floor, before": 0.02, "weight on the floor, after": 0.02}, 0.002),
    "oscillating_plate": ({"period": 0.005, "amplitude": 0.01}, 1e-3),
    "turek_csm1": ({"tip shift": 0.006, "tip height": 0.005}, 1e-3),
    "turek_csm3": (
        {
            "tip height, mean": 0.02,
            "tip height, amplitude": 0.02,
            "tip shift, mean": 0.02,
            "tip shift, amplitude": 0.02,
            "period": 0.01,
        },
        1e-6,
    ),
    "sandwich_cantilever": ({"frequency": 0.005}, 1e-5),
    "free_free_bar_3d": ({"period": 0.005}, 1e-3),
    # the reference is of a small twist
    "twisting_column_3d": ({"period": 0.004}, 1e-5),
    # the ball is made of cells: where it touches first it is flat over 7 of them
    "rubber_drop_3d": (
        {"restitution": 0.015, "contact time": 0.025, "greatest push": 0.015, "greatest width": 0.005},
        1e-5,
    ),
}

# of fluids, whose losses are in no account
FLUID_TOLERANCES: dict[str, dict[str, float]] = {
    "hydrostatic_tank": {
        "pressure on the bottom": 0.005,
        "pressure on the side": 0.01,
        "level at the end": 0.003,
        "push on the right side": 0.015,
        "volume at the end": 0.003,
    },
    # crests of little more than a spacing lose height
    "standing_wave": {
        "period of the level": 0.006,
        "period of the centre of mass": 0.005,
        "amplitude of the level": 0.13,
    },
    "sloshing_tank": {
        # 9 rows are 1.1 % off, at steps of half the length 1.0 %; 12 and 13 rows are 0.3 and 0.1 % off
        "period of the pressure on the left": 0.0125,
        "period of the centre of mass": 0.01,
        # water swells by 0.012 where disorder makes its number densities more than 1 % too large
        "volume at the end": 0.015,
    },
    # no barrier has to be lifted, so that all are ahead of the experiment: potential flow by 19.8, 12.9, 16.1, 13.8 %
    "dam_break": {
        "arrival at 0.183 m": 0.15,
        "arrival at 0.276 m": 0.15,
        "arrival at 0.382 m": 0.16,
        "arrival at 0.529 m": 0.15,
        "arrival at 0.183 m by potential flow": 0.1,
        "arrival at 0.276 m by potential flow": 0.03,
        "arrival at 0.382 m by potential flow": 0.025,
        "arrival at 0.529 m by potential flow": 0.03,
        "arrival at 0.395 m by the original method": 0.02,
        "arrival at 0.475 m by the original method": 0.02,
        # the last splash: -0.006 to 0.003 in runs that differ in the solve's last digits
        "volume at the end": 0.01,
    },
    "dam_break_3d": {
        "arrival at 0.183 m": 0.15,
        "arrival at 0.276 m": 0.15,
        "arrival at 0.382 m": 0.16,
        "arrival at 0.529 m": 0.15,
        "arrival at 0.183 m by potential flow": 0.14,
        "arrival at 0.276 m by potential flow": 0.03,
        "arrival at 0.382 m by potential flow": 0.02,
        "arrival at 0.529 m by potential flow": 0.02,
    },
    "elliptical_drop": {
        "half length at 0.8 ms": 0.003,
        "half length at 3.8 ms": 0.005,
        "half length at 7.6 ms": 0.005,
    },
    "taylor_green": {"kinetic energy at 0.2 s": 0.03, "kinetic energy at 0.5 s": 0.02, "kinetic energy at 1 s": 0.02},
    "square_patch": {
        "pressure in the middle at the start": 0.02,
        "angular momentum at the end": 0.003,
        "kinetic energy at the end": 0.005,
        "volume at the end": 0.002,
    },
}

# of water and elastic bodies
COUPLED_TOLERANCES: dict[str, dict[str, float]] = {
    "water_column_on_plate": {
        "frequency": 0.015,
        "deflection in the mean": 0.02,
        "pressure on the plate in the mean": 0.005,
    },
    # the theory is linear, and of an impact in no time
    "elastic_panel_slamming": {"greatest deflection": 0.04, "deflection after 5 ms": 0.13, "half a period": 0.03},
    # half a spacing, and a bit of the level
    "floating_elastic_plate": {
        "height of the plate at rest": 0.025,
        "level at rest": 0.005,
        "pressure on the floor at rest": 0.015,
    },
    "sloshing_elastic_baffle": {"period of the turn of the end": 0.015, "period of the level on the left": 0.015},
    # the gate of the experiment opens farther, and stays open longer
    "dam_break_elastic_gate": {
        "farthest shift of the free end": 0.22,
        "farthest rise of the free end": 0.36,
        "shift at 0.04 s": 0.26,
        "shift at 0.08 s": 0.07,
        "shift at 0.12 s": 0.19,
        "shift at 0.20 s": 0.42,
        "shift at 0.28 s": 0.43,
        "shift at 0.36 s": 0.31,
        "rise at 0.04 s": 0.62,
        "rise at 0.08 s": 0.08,
        "rise at 0.12 s": 0.3,
        "rise at 0.20 s": 0.68,
        "rise at 0.28 s": 0.67,
        "rise at 0.36 s": 0.52,
    },
    # two particles through the gate, which is open at once: too far at first, too little later
    "dam_break_elastic_gate_3d": {
        "farthest shift of the free end": 0.28,
        "shift at 0.04 s": 0.17,
        "shift at 0.08 s": 0.08,
        "shift at 0.12 s": 0.27,
        "rise at 0.04 s": 0.46,
        "rise at 0.08 s": 0.21,
        "rise at 0.12 s": 0.45,
    },
}

# one of each kind, of about a second
QUICK = ("beam_second_mode_as_published", "block_on_wall", "turek_csm1")
SLOW = ("dam_break_3d",)


RunCase = Callable[[str], tuple[RunSummary, Path]]


@pytest.fixture(scope="module")
def run_case(tmp_path_factory: pytest.TempPathFactory) -> RunCase:
    """Runs a shipped case when a test first asks for it; gives its summary and the folder of its results."""

    @functools.cache
    def run(name: str) -> tuple[RunSummary, Path]:
        folder = tmp_path_factory.mktemp(name)
        return run_scene(read_stage(shipped_cases()[name]), folder, quiet=True), folder

    return run


@pytest.mark.validation
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.long) for name in TOLERANCES]
)
def test_results_lie_within_their_tolerances(name: str, run_case: RunCase) -> None:
    tolerances, drift = TOLERANCES[name]
    summary, _ = run_case(name)
    errors = {row["name"]: row["error"] for row in summary.measurements if row["reference"] is not None}
    assert errors.keys() == tolerances.keys(), "every reference has a tolerance"
    assert {key: abs(error) <= tolerances[key] for key, error in errors.items()} == dict.fromkeys(tolerances, True)
    assert summary.energy["drift"] is not None
    assert summary.energy["drift"] < drift
    assert summary.momentum_error is not None
    assert summary.momentum_error < 1e-12


@pytest.mark.validation
@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in FLUID_TOLERANCES]
)
def test_results_of_fluids_lie_within_their_tolerances(name: str, run_case: RunCase) -> None:
    tolerances = FLUID_TOLERANCES[name]
    summary, _ = run_case(name)
    errors = {row["name"]: row["error"] for row in summary.measurements if row["reference"] is not None}
    assert errors.keys() == tolerances.keys(), "every reference has a tolerance"
    assert {key: abs(error) <= tolerances[key] for key, error in errors.items()} == dict.fromkeys(tolerances, True)
    assert summary.fluid["unsolved"] == 0
    total = sum(count for body, count in summary.particles.items() if body in ("water", "drop"))
    assert summary.fluid["lost"] <= 0.001 * total


@pytest.mark.validation
@pytest.mark.slow
@pytest.mark.parametrize("name", COUPLED_TOLERANCES)
def test_results_of_coupled_cases_lie_within_their_tolerances(name: str, run_case: RunCase) -> None:
    tolerances = COUPLED_TOLERANCES[name]
    summary, _ = run_case(name)
    errors = {row["name"]: row["error"] for row in summary.measurements if row["reference"] is not None}
    assert errors.keys() == tolerances.keys(), "every reference has a tolerance"
    assert {key: abs(error) <= tolerances[key] for key, error in errors.items()} == dict.fromkeys(tolerances, True)
    assert summary.fluid["unsolved"] == summary.fluid["lost"] == summary.coupling["unconverged"] == 0


@pytest.mark.validation
@pytest.mark.long
def test_the_block_is_thrown_back_turning(run_case: RunCase) -> None:
    """The paper's figure 6 in numbers: it rises again, turns, and carries what the base gave it."""
    summary, folder = run_case("block_on_elastic_base")
    values = {row["name"]: row["value"] for row in summary.measurements}
    assert 0.2 < values["restitution"] < 1.0
    assert abs(values["final turn"]) > 0.1
    history = read_history(folder / "probes.csv")
    impulse = _integral(history.times, history.probe("block_force", 1))
    momentum = history.probe("block_momentum", 1)
    assert impulse == pytest.approx(momentum[-1] - momentum[0], rel=0.01)


@pytest.mark.validation
@pytest.mark.long
def test_the_ball_leaves_straight_upwards(run_case: RunCase) -> None:
    """Though its lattice is shifted against the floor's; friction takes a thousandth of its energy, and adds none."""
    summary, folder = run_case("rubber_drop_3d")
    history = read_history(folder / "probes.csv")
    up = history.probe("ball_velocity", 1)
    assert up[-1] > 0.9 * -up[0]
    for axis in (0, 2):
        assert abs(history.probe("ball_velocity", axis)[-1]) < 2e-3 * up[-1]
    start = history.rows[0][history.labels.index("kinetic energy [J]")]
    assert 1e-4 * start < (summary.energy["dissipated"] or 0.0) < 2e-3 * start


@pytest.mark.validation
@pytest.mark.long
def test_the_column_swings_in_the_period_of_a_small_twist(run_case: RunCase, tmp_path: Path) -> None:
    """As its stage says; energy is kept through the greatest turn and back."""
    scene = read_stage(shipped_cases()["twisting_column_3d"])
    (column,) = scene.bodies
    assert column.velocity_field is not None
    small = replace(column, velocity_field=replace(column.velocity_field, rate=0.01))
    large, folder = run_case("twisting_column_3d")
    summaries = (large, run_scene(replace(scene, bodies=(small,)), tmp_path, quiet=True))
    periods = [row["value"] for summary in summaries for row in summary.measurements if row["name"] == "period"]
    # 0.3630 and 0.3639 s: some of the large twist is in higher modes
    assert periods[0] == pytest.approx(periods[1], rel=0.003)
    turn = read_history(folder / "probes.csv").probe("turn_at_1_m", 1)
    # a twist this large is not a pure mode: some of its energy goes into others on the way
    assert turn.max() == pytest.approx(-turn.min(), rel=0.05)


def _integral(times: np.ndarray, values: np.ndarray) -> float:
    return float((0.5 * (values[1:] + values[:-1]) * (times[1:] - times[:-1])).sum())

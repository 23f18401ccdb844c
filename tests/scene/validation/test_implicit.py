"""Static and implicit scenes: refusals and their messages, schedule, cost."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.refusals import assert_refused
from tests.scenes import RUBBER, SPRINGS, block
from warp_mps.errors import InputError
from warp_mps.run.cost import estimate
from warp_mps.run.cost.work import START, START_OF_SOLVERS
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Contact, Fluid, HarmonicMotion, Load, Part, Scene, Support, TableMotion, VelocityField, Wall
from warp_mps.shapes import Box

STATIC = {"analysis": "static"}
STEPS = {"integrator": "implicit", "time_step": 1e-3}
REGION = Box((1.0, 1.0))
OTHER = block(2, name="other", shape=Box((0.03, 0.03), (0.5, 0.0)))
FLOOR = Wall(name="floor", shape=Box((0.1, 0.02), (0.0, -0.1)), spacing=0.01)
WATER = Fluid(name="water", shape=Box((0.1, 0.1)), spacing=0.01)
SINE = VelocityField(kind="sine", amplitude=(0.0, 1.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=0.04)
SOFT = replace(RUBBER, retardation_time=1e-3, path="/World/soft")


def scene(**fields: Any) -> Scene:
    """A block, with some fields of the scene."""
    return Scene(**{"bodies": (block(2, path="/World/block"),), "duration": 1.0, "path": "/World", **fields})


FAST = block(2, velocity=(1.0, 0.0), path="/World/block")
SWING = HarmonicMotion(amplitude=(1.0, 0.0), frequency=1.0)


def moved(motion: Any) -> dict[str, Any]:
    return {"supports": (Support(name="grip", region=REGION, motion=motion, path="/World/grip"),)}


BROKEN: list[tuple[str, str, str, dict[str, Any]]] = [
    ("/World", "analysis", "must be one of: dynamic, static", {"analysis": "modal"}),
    ("/World", "integrator", "must be one of: auto, explicit, implicit", {"integrator": "newmark"}),
    ("/World", "theta", "between 0.5 and 1", {"theta": 0.49}),
    ("/World", "theta", "between 0.5 and 1", {**STEPS, "theta": 1.01}),
    ("/World", "load_steps", "at least 1", {**STATIC, "load_steps": 0}),
    ("/World", "load_steps", "a whole number", {**STATIC, "load_steps": 2.5}),
    ("/World", "analysis", "requires a scene without fluids", {**STATIC, "bodies": (), "fluids": (WATER,)}),
    ("/World", "elasticity.model", "'static' needs hamiltonian", {**STATIC, "elasticity": SPRINGS}),
    ("/World", "elasticity.model", "'implicit' needs hamiltonian", {**STEPS, "elasticity": SPRINGS}),
    ("/World", "analysis", "cannot be used with walls", {**STATIC, "walls": (FLOOR,)}),
    ("/World", "integrator", "cannot be used with walls", {**STEPS, "walls": (FLOOR,)}),
    ("/World", "contact.between", "must be 'none'", {**STATIC, "bodies": (block(2), OTHER)}),
    ("/World", "contact.between", "must be 'none'", {**STEPS, "contact": Contact(between="all")}),
    ("/World", "time_step", "is missing", {"integrator": "implicit"}),
    ("/World/soft", "retardation_time", "must be 0 with implicit", {**STEPS, "bodies": (block(2, material=SOFT),)}),
    (
        "/World/soft",
        "retardation_time",
        "must be 0 with implicit",
        {**STEPS, "bodies": (block(2, parts=(Part(name="core", region=REGION, material=SOFT),)),)},
    ),
    (
        "/World/block",
        "velocity",
        "nothing moves",
        {**STATIC, "bodies": (FAST,)},
    ),
    ("body 'block'", "velocity_field", "nothing moves", {**STATIC, "bodies": (block(2, velocity_field=SINE),)}),
    (
        "load 'push'",
        "frequency",
        "must be 0",
        {**STATIC, "loads": (Load(name="push", region=REGION, force=(1.0, 0.0), frequency=2.0),)},
    ),
    (
        "/World/grip",
        "motion",
        "must be a table",
        {**STATIC, **moved(SWING)},
    ),
]


@pytest.mark.parametrize(("where", "attribute", "reason", "fields"), BROKEN, ids=lambda value: str(value)[:40])
def test_a_broken_scene_is_refused(where: str, attribute: str, reason: str, fields: dict[str, Any]) -> None:
    assert_refused(lambda: scene(**fields), where, attribute, reason)


TABLE = TableMotion(times=np.array([0.0, 1.0]), displacements=np.array([[0.0, 0.0], [0.01, 0.0]]))


@pytest.mark.parametrize(
    "fields",
    [
        STATIC,
        {**STATIC, **moved(TABLE)},
        {**STATIC, "bodies": (block(2, material=SOFT),)},
        {**STATIC, "bodies": (block(2), OTHER), "contact": Contact(between="none")},
        {**STEPS, **moved(SWING), "damping": 1.0},
        {**STEPS, "bodies": (block(2), replace(OTHER, bonded_to=("block",)))},
    ],
)
def test_a_sound_scene_is_taken(fields: dict[str, Any]) -> None:
    assert scene(**fields).implicit


def test_the_schedule_of_a_static_analysis() -> None:
    clock = Clock(scene(**STATIC, load_steps=7, time_step=0.3, duration=2.0))
    assert (clock.steps, clock.frame_every, clock.sample_every) == (14, 1, 1)
    assert clock.time(7) == 1.0
    assert clock.time(14) == 2.0
    assert clock.dt == pytest.approx(1.0 / 7)
    assert clock.dt_limit == np.inf


def test_implicit_steps_have_no_limit() -> None:
    clock = Clock(scene(**STEPS, frame_rate=50.0))
    assert clock.dt == 1e-3
    assert clock.dt_limit == np.inf
    assert (clock.steps, clock.frame_every) == (1000, 20)


def test_the_cost_of_solving() -> None:
    """More memory, and steps that cost more the longer they are, but no more than in statics."""
    explicit = scene(time_step=1e-4)
    costs = [estimate(scene(integrator="implicit", time_step=step)) for step in (1e-6, 1e-4, 1.0)]
    static = estimate(scene(**STATIC, load_steps=1))
    assert min(cost.memory for cost in (*costs, static)) > estimate(explicit).memory
    each = [(cost.seconds - START - START_OF_SOLVERS) / cost.time_step.steps for cost in costs]
    assert each[0] < each[1] < each[2] <= static.seconds
    assert static.time_step.stable == costs[0].time_step.stable == np.inf


@pytest.mark.parametrize("fields", [STATIC, STEPS])
def test_threads_are_refused(fields: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="threads: is 2; a static analysis and implicit steps take one"):
        Simulation(scene(**fields), threads=2)

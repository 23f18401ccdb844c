"""Which steps bodies in water take, how long they are, and how they are damped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, EXPLICIT, IMPLICIT, SOFT, hung, lump, pool
from warp_mps.coupling.choice import LEAST_SUBSTEPS, damped, stable_step, substep, takes_implicit_steps
from warp_mps.fluid.limits import step_limit
from warp_mps.particles import fill_scene
from warp_mps.scene import Contact, Material, Part, Scene

STEEL = Material(7800.0, 2e11, 0.3)


def of(material: Material, **fields: object) -> tuple[Scene, object]:
    scene = pool(lump([3, 3], [3, 3], material=material), **fields)  # type: ignore[arg-type]
    return scene, fill_scene(scene)


@pytest.mark.parametrize(
    ("material", "fields", "implicit"),
    [
        (SOFT, {"contact": ALONE}, False),
        (STEEL, {"contact": ALONE}, True),
        (STEEL, {"contact": ALONE, "time_step": 1e-6}, False),
        (STEEL, {}, False),
        (replace(STEEL, retardation_time=1e-6), {"contact": ALONE}, False),
        (STEEL, EXPLICIT, False),
        (SOFT, IMPLICIT, True),
    ],
)
def test_steps_are_implicit_where_the_scene_says_so_or_that_is_quicker(
    material: Material, fields: dict, implicit: bool
) -> None:
    assert takes_implicit_steps(*of(material, **fields)) == implicit  # type: ignore[arg-type]


@pytest.mark.parametrize("material", [SOFT, STEEL])
@pytest.mark.parametrize("interval", [0.01, 0.0033, 1e-5])
def test_a_whole_number_of_stable_substeps_makes_an_interval(material: Material, interval: float) -> None:
    scene, particles = of(material, **EXPLICIT)
    dt = substep(scene, particles, interval)  # type: ignore[arg-type]
    assert interval / dt == pytest.approx(round(interval / dt))
    limit, _ = step_limit(scene, particles)  # type: ignore[arg-type]
    longest = min(stable_step(damped(scene, particles)), limit / LEAST_SUBSTEPS)  # type: ignore[arg-type]
    assert dt <= longest
    assert dt > 0.5 * min(longest, interval)


def test_stiff_contact_makes_steps_shorter() -> None:
    scene = hung(**EXPLICIT)
    assert stable_step(replace(scene, contact=Contact(stiffness=4.0))) == pytest.approx(0.5 * stable_step(scene))


def test_bodies_are_damped_as_the_theta_rule_damps() -> None:
    """In a step of the water a mode with the ratio (theta - 1/2) omega dt, in all materials, and no more."""
    part = Part(name="half", region=lump([3, 3], [1, 3]).shape, material=replace(SOFT, retardation_time=1.0))
    scene = pool(lump([3, 3], [3, 3], parts=(part,)), theta=0.7)
    particles = fill_scene(scene)
    limit, _ = step_limit(scene, particles)
    omega = 30.0
    found = damped(scene, particles)
    assert 0.5 * omega * found.bodies[0].material.retardation_time == pytest.approx(0.2 * omega * limit)
    assert found.bodies[0].parts[0].material.retardation_time == 1.0
    shorter = damped(replace(scene, time_step=0.1 * limit), particles)
    assert shorter.bodies[0].material.retardation_time == pytest.approx(0.4 * 0.1 * limit)
    assert damped(replace(scene, theta=0.5), particles) == replace(scene, theta=0.5)
    assert np.all([fill_scene(found).masses == particles.masses])

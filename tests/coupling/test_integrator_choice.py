"""Which steps bodies in water take, how long they are, and how they are damped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, EXPLICIT, IMPLICIT, SOFT, hung, lump, pool
from tests.scenes import SPRINGS
from warp_mps.coupling.integrator_choice import LEAST_SUBSTEPS, stable_step, substep, takes_implicit_steps
from warp_mps.elastic.explicit.time_step import SAFETY
from warp_mps.fluid.time_step import step_limit
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Contact, Material, Scene

STEEL = Material(7800.0, 2e11, 0.3)


def of(material: Material, **fields: object) -> tuple[Scene, object]:
    scene = pool(lump([3, 3], [3, 3], material=material), **fields)  # type: ignore[arg-type]
    return scene, fill_scene(scene)


@pytest.mark.parametrize(
    ("material", "fields", "implicit"),
    [
        (SOFT, {"contact": ALONE}, True),
        (STEEL, {"contact": ALONE}, True),
        (STEEL, {"contact": ALONE, "elasticity": SPRINGS}, False),
        (STEEL, {}, False),
        (replace(STEEL, retardation_time=1e-6), {"contact": ALONE}, False),
        (STEEL, EXPLICIT, False),
        (SOFT, IMPLICIT, True),
    ],
)
def test_steps_are_implicit_where_the_scene_says_so_or_nothing_speaks_against_it(
    material: Material, fields: dict, implicit: bool
) -> None:
    assert takes_implicit_steps(of(material, **fields)[0]) == implicit


@pytest.mark.parametrize("material", [SOFT, STEEL])
@pytest.mark.parametrize("interval", [0.01, 0.0033, 1e-5])
def test_a_whole_number_of_stable_substeps_makes_an_interval(material: Material, interval: float) -> None:
    scene, particles = of(material, **EXPLICIT)
    dt, tau = substep(scene, particles, interval)  # type: ignore[arg-type]
    assert interval / dt == pytest.approx(round(interval / dt))
    limit, _ = step_limit(scene, particles)  # type: ignore[arg-type]
    # of the fastest mode, which a force that lags by half a step damps
    omega = 2.0 * SAFETY / stable_step(scene)
    ratio = 0.5 * omega * tau
    longest = min(SAFETY * 2.0 / omega * (np.sqrt(1.0 + ratio**2) - ratio), limit / LEAST_SUBSTEPS)
    assert dt <= longest
    assert dt > 0.5 * min(longest, interval)


def test_stiff_contact_makes_steps_shorter() -> None:
    scene = hung(**EXPLICIT)
    assert stable_step(replace(scene, contact=Contact(stiffness=4.0))) == pytest.approx(0.5 * stable_step(scene))


def test_bodies_are_damped_as_the_theta_rule_damps() -> None:
    """In a step of the water, a mode with the ratio (theta - 1/2) omega dt."""
    scene = pool(lump([3, 3], [3, 3]), theta=0.7)
    particles = fill_scene(scene)
    limit, _ = step_limit(scene, particles)
    assert substep(scene, particles, 0.01)[1] == pytest.approx(0.4 * limit)
    assert substep(replace(scene, time_step=0.1 * limit), particles, 0.01)[1] == pytest.approx(0.04 * limit)
    assert substep(replace(scene, theta=0.5), particles, 0.01)[1] == 0.0

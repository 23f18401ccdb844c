"""Causes of a run that diverged: what is found by looking."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.fluid.scenes import periodic_box, tank
from tests.observers.views import blocks, view_of
from warp_mps.observers.causes import probable_cause
from warp_mps.scene import Contact, Flow, Scene


def cause(
    scene: Scene, *, time_step: float = 1e-4, limit: float = 2e-4, wall: float = 0.0, closed: bool = False
) -> str:
    """The cause in a scene, with the speed of its first wall [m/s]."""
    view = view_of(scene)
    for first, end in view.particles.ranges[len(scene.bodies) : len(scene.bodies) + 1]:
        view.velocities[first:end, 0] = wall
    return probable_cause(view, time_step=time_step, limit=limit, closed=closed)


def test_a_body_that_starts_faster_than_waves_in_it() -> None:
    """Rubber of 1 MPa and 1000 kg/m^3 in plane strain: c_p = sqrt(1.346e6 / 1e3) = 36.69 m/s."""
    scene = blocks()
    fast = replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], velocity=(-40.0, 0.0))))
    expected = "'right' starts at 40 m/s, faster than pressure waves of 36.69 m/s: check its velocity and the units"
    assert cause(fast) == expected
    slow = replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], velocity=(-30.0, 0.0))))
    assert "starts" not in cause(slow)


def test_a_time_step_above_and_below_its_limit() -> None:
    assert cause(blocks(), time_step=3e-4) == (
        "the time step of 0.0003 s is above the stability limit of 0.0002 s: take less than that"
    )
    assert cause(blocks()).startswith("what acts on the bodies is too violent for the time step of 0.0001 s, which is")
    implicit = blocks(integrator="implicit", contact=Contact(between="none"), time_step=1e-4)
    assert cause(implicit, limit=np.inf).startswith("steps of 0.0001 s are too long")


def test_water_that_starts_and_walls_that_move_too_fast() -> None:
    expected = r"'water' starts at 200 m/s, faster than the 150 m/s that a liquid is good for"
    assert cause(tank((8, 8), fluid={"velocity": (200.0, 0.0)})).startswith(expected)
    name = tank((8, 8)).walls[0].name
    expected = f"'{name}' moves at 151 m/s, faster than the 150 m/s that a liquid is good for"
    assert cause(tank((8, 8)), wall=151.0).startswith(expected)


@pytest.mark.parametrize(
    ("flow", "expected"),
    [
        ({"scheme": "corrected", "courant": 0.4}, "the scheme 'corrected' does not conserve momentum, and stirs water"),
        ({"scheme": "koshizuka_oka"}, "the scheme 'koshizuka_oka' does not conserve momentum, .* take 'conservative'$"),
        ({"courant": 0.4}, r"the CFL number of 0\.4 is above the default of 0\.2: take that or less"),
        (
            {"effective_radius": 1.5, "courant": 0.4},
            r"the effective radius of 1\.5 spacings is below the default of 3\.1",
        ),
        ({}, "the flow has become unstable; more particles, or a smaller CFL number, may help"),
    ],
)
def test_settings_of_a_flow(flow: dict, expected: str) -> None:
    assert re.match(expected, cause(tank((8, 8), flow=Flow(**flow))))


def test_a_fluid_without_a_free_surface_takes_another_scheme() -> None:
    expected = "the scheme 'conservative' with negative pressures 'allowed' stirs a fluid that fills its walls: take "
    assert cause(tank((8, 8), flow=Flow(negative_pressure="allowed")), closed=True).startswith(expected)
    right = tank((8, 8), flow=Flow(scheme="corrected", negative_pressure="allowed"))
    assert cause(right, closed=True).startswith("the flow has become unstable")
    assert cause(periodic_box((12, 12), flow=Flow(scheme="corrected")), closed=True).startswith("the flow has become")

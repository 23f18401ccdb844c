"""What a run takes, said before it takes it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.scenes import HAMILTONIAN, beam
from warp_mps.cost import estimate, refuse_too_large
from warp_mps.errors import InputError
from warp_mps.scene import Contact, Wall
from warp_mps.shapes import Box
from warp_mps.simulation import Simulation


def test_the_estimate_is_what_the_run_then_has() -> None:
    scene = beam(4, duration=0.01)
    cost, simulation = estimate(scene), Simulation(scene)
    assert cost.particles == {"beam": simulation.particles.count}
    assert (cost.dt, cost.steps) == (simulation.dt, simulation.total_steps)
    assert cost.frames == 2


def test_memory_is_refused_when_there_is_not_enough() -> None:
    scene = beam(4)
    fine = replace(scene, bodies=(replace(scene.bodies[0], spacing=1e-8),))
    with pytest.raises(InputError, match=r"body 'beam' spacing: 1e-08 m makes 3.2e\+13 particles; the run needs about"):
        refuse_too_large(fine)
    refuse_too_large(scene)


def test_walls_are_counted() -> None:
    floor = Wall(name="floor", shape=Box((0.2, 0.02), (0.08, -0.03)), spacing=0.01, path="/World/floor")
    scene = beam(4, walls=(floor,), duration=0.01)
    assert estimate(scene).particles == {**estimate(beam(4)).particles, "floor": 40}
    assert estimate(scene).seconds == estimate(beam(4, duration=0.01)).seconds
    assert estimate(scene).memory > estimate(beam(4)).memory
    with pytest.raises(InputError, match="/World/floor spacing: 1e-08 m makes"):
        refuse_too_large(replace(scene, walls=(replace(floor, spacing=1e-8),)))


def test_contact_and_friction_take_memory() -> None:
    touching = beam(4, contact=Contact(between="all"))
    memory = [
        estimate(scene).memory
        for scene in (beam(4), touching, replace(touching, contact=Contact(between="all", friction=0.1)))
    ]
    assert memory[0] < memory[1] < memory[2]


def test_damping_of_the_material_costs_time() -> None:
    plain = beam(4, duration=0.01, elasticity=HAMILTONIAN, time_step=1e-6)
    body = plain.bodies[0]
    damped = replace(plain, bodies=(replace(body, material=replace(body.material, retardation_time=1e-6)),))
    assert estimate(damped).seconds > 2.0 * estimate(plain).seconds

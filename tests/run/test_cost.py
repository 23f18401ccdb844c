"""The cost of a run, estimated before it starts."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from tests.coupling.scenes import lump, pool
from tests.scenes import HAMILTONIAN, RUBBER, beam
from warp_mps.errors import InputError
from warp_mps.run.cost import estimate, refuse_too_large
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, Fluid, Scene, Wall
from warp_mps.shapes import Box

BLOCK = lump([3, 3], [4, 4])


def test_the_estimate_is_what_the_run_then_has() -> None:
    scene = beam(4, duration=0.01)
    cost, simulation = estimate(scene), Simulation(scene)
    assert cost.particles == {"beam": simulation.particles.count}
    assert (cost.dt, cost.steps) == (simulation.dt, simulation.total_steps)
    assert cost.frames == 2


def test_the_animation_is_no_larger_than_estimated(tmp_path: Path) -> None:
    block = Body(name="block", shape=Box((0.2, 0.2)), material=RUBBER, spacing=0.005, angular_velocity=1.0)
    for outputs in ((), ("stress", "strain", "von_mises", "strain_energy")):
        scene = Scene(bodies=(block,), duration=0.002, frame_rate=10000.0, outputs=outputs)
        run_scene(scene, tmp_path, quiet=True, overwrite=True)
        size = (tmp_path / "run.usdc").stat().st_size
        assert size < estimate(scene).disk < 1.25 * size


def test_the_animation_of_water_and_bodies_is_no_larger_than_estimated(tmp_path: Path) -> None:
    """Outputs are of the bodies alone, and the remains of saves grow with the number and the size of the frames."""
    for outputs, rate in (((), 1000.0), (("stress", "von_mises"), 4000.0)):
        scene = pool(BLOCK, outputs=outputs, frame_rate=rate, duration=0.02)
        run_scene(scene, tmp_path, quiet=True, overwrite=True)
        size = (tmp_path / "run.usdc").stat().st_size
        assert size < estimate(scene).disk < 1.25 * size


def test_the_memory_of_water_and_bodies() -> None:
    """Together they take more than each alone; what touches takes its lists, and what is solved for its vectors."""
    water, both, dry = estimate(pool()), estimate(pool(BLOCK)), estimate(Scene(bodies=(BLOCK,), duration=1.0))
    assert both.memory > water.memory + dry.memory
    # a body of finer particles takes more, but not what the water keeps of those that it sees
    finer = replace(BLOCK, spacing=BLOCK.spacing / 2)
    more = estimate(pool(finer)).memory - both.memory
    assert 2.9 * dry.memory < more < 4.0 * (both.memory - water.memory)
    without = [pool(BLOCK, integrator=name, contact=Contact(between="none")) for name in ("explicit", "implicit")]
    explicit, implicit = (estimate(scene).memory for scene in without)
    assert explicit < implicit
    assert explicit < estimate(replace(without[0], contact=Contact(between="all"))).memory


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
    alone, apart = beam(4, duration=0.01), replace(scene, contact=Contact(between="none"))
    # a wall takes no time but that of contact
    assert estimate(apart).seconds == estimate(alone).seconds < estimate(scene).seconds
    assert estimate(scene).memory > estimate(beam(4)).memory
    with pytest.raises(InputError, match="/World/floor spacing: 1e-08 m makes"):
        refuse_too_large(replace(scene, walls=(replace(floor, spacing=1e-8),)))


def test_contact_and_friction_take_memory_and_time() -> None:
    touching = beam(4, contact=Contact(between="all"))
    rubbing = replace(touching, contact=Contact(between="all", friction=0.1))
    costs = [estimate(scene) for scene in (beam(4, contact=Contact(between="none")), touching, rubbing)]
    assert costs[0].memory < costs[1].memory < costs[2].memory
    assert costs[0].seconds < costs[1].seconds < costs[2].seconds


def test_damping_of_the_material_costs_time() -> None:
    plain = beam(4, duration=0.01, elasticity=HAMILTONIAN, time_step=1e-6)
    body = plain.bodies[0]
    damped = replace(plain, bodies=(replace(body, material=replace(body.material, retardation_time=1e-6)),))
    assert estimate(damped).seconds > 2.0 * estimate(plain).seconds


def test_the_estimate_of_fluids() -> None:
    """The step is that of the run, the steps those of an interval as it begins."""
    floor = Wall(name="floor", shape=Box((0.3, 0.04), (0.1, -0.02)), spacing=0.01, path="/World/floor")
    water = Fluid(name="water", shape=Box((0.2, 0.1), (0.1, 0.05)), spacing=0.01)
    scene = Scene(fluids=(water,), walls=(floor,), gravity=(0.0, -9.81), duration=0.1, frame_rate=20.0)
    cost, simulation = estimate(scene), Simulation(scene)
    assert cost.particles == {"floor": 120, "water": 200}
    assert cost.dt == cost.dt_limit == simulation.fluids.model.step_limit
    assert (cost.steps, cost.frames) == (math.ceil(0.1 / cost.dt), 3)
    assert cost.seconds > 0.0
    assert estimate(replace(scene, time_step=1e-4)).steps == 1000
    coarse = replace(scene, fluids=(replace(water, spacing=1e-8),), walls=())
    with pytest.raises(InputError, match="fluid 'water' spacing: 1e-08 m makes"):
        estimate(coarse)

"""Water and elastic bodies in one step: momentum, buoyancy, energy, mass ratios, and contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, EXPLICIT, IMPLICIT, SOFT, WAYS, afloat, hung, lump, pool, system_of
from tests.fluid.scenes import L0
from warp_mps.coupling.integrator_choice import takes_implicit_steps
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Flow, Fluid, Material, Scene, Support, Wall
from warp_mps.shapes import Box, Points

G = 9.81


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_changes_by_weight_and_walls_alone(dimension: int, way: dict, precision: str) -> None:
    """Of water and a free body together, in every interval; implicit steps solve their equation to 1e-8."""
    simulation = Simulation(afloat(500.0, dimension=dimension, **way), precision=precision)
    p = simulation.particles
    moving = np.ones(p.count, bool)
    moving[p.elastic : p.count - p.liquid] = False
    weight = p.masses[moving].sum() * np.array([0.0, -G, 0.0][:dimension])
    near = {"float64": {"explicit": 1e-13, "implicit": 1e-8}, "float32": {"explicit": 1e-6, "implicit": 1e-5}}
    for _ in range(5):
        before = p.masses[moving] @ simulation.velocities[moving]
        simulation.advance(1)
        gained = p.masses[moving] @ simulation.velocities[moving] - before
        forces = simulation.contact_forces
        expected = simulation.dt * (weight - forces[~moving].sum(axis=0))
        exchanged = simulation.dt * np.abs(forces).sum()
        np.testing.assert_allclose(gained, expected, atol=near[precision][way["integrator"]] * exchanged)


@pytest.mark.parametrize("way", WAYS)
def test_a_held_body_feels_its_buoyancy(way: dict) -> None:
    held = (Support(name="all", region=Box((10.0, 10.0))),)
    simulation = Simulation(pool(lump([4, 3], [4, 4]), cells=(12, 11), supports=held, **way))
    forces = []
    for _ in range(20):
        simulation.advance(1)
        forces.append(simulation.contact_forces[: simulation.particles.elastic].sum(axis=0))
    assert np.abs(simulation.displacements[: simulation.particles.elastic]).max() == 0.0
    np.testing.assert_allclose(np.mean(forces[10:], axis=0), [0.0, 1000.0 * G * 16 * L0**2], rtol=0.02, atol=0.05)


@pytest.mark.parametrize("way", WAYS)
def test_a_body_as_dense_as_water_stays_where_it_is(way: dict) -> None:
    simulation = Simulation(afloat(1000.0, **way))
    simulation.advance(20)
    e = simulation.particles.elastic
    u = simulation.displacements
    assert np.abs(u[:e].mean(axis=0)).max() < 0.08 * L0
    assert np.linalg.norm(simulation.velocities[:e], axis=1).max() < 0.02
    water = u[-simulation.particles.liquid :]
    assert np.abs(water.mean(axis=0)).max() < 0.015 * L0, "the water neither settles nor swells"
    assert np.abs(water).max() < 0.5 * L0, "it gives in the corners of its surface"


@pytest.mark.parametrize("way", WAYS)
def test_a_block_of_half_the_density_floats_half_in_the_water(way: dict) -> None:
    """It heaves about there, carried by its weight in the mean."""
    material = Material(500.0, 5e5, 0.3)
    simulation = Simulation(pool(lump([4, 6], [4, 4], material=material), cells=(12, 8), **way))
    heave, force = [], []
    for _ in range(50):
        simulation.advance(1)
        heave.append(simulation.displacements[:16].mean(axis=0) / L0)
        force.append(simulation.contact_forces[:16, 1].sum())
    assert (np.abs(heave).max(axis=0) < [0.05, 0.3]).all()
    assert np.mean(force) == pytest.approx(500.0 * G * 16 * L0**2, rel=0.03)
    assert simulation.record()["coupling"]["unconverged"] == 0


@pytest.mark.parametrize(
    ("density", "way"),
    [(200.0, IMPLICIT), (500.0, IMPLICIT), (500.0, EXPLICIT), (3000.0, IMPLICIT), (3000.0, EXPLICIT)],
)
def test_bodies_rise_and_sink_with_the_same_water(density: float, way: dict) -> None:
    """At first some twice the mass of the water in their place goes with them, in a narrow tank, light or heavy.

    By itself a body of a fifth of the water's density would start with 4 g.
    """
    body = lump([8, 6], [8, 6], material=Material(density, 2e6, 0.3))
    simulation = Simulation(pool(body, cells=(24, 16), **way))
    simulation.advance(3)
    e = simulation.particles.elastic
    acceleration = simulation.velocities[:e, 1].mean() / simulation.time
    added = ((1000.0 - density) * G / acceleration - density) / 1000.0
    assert added == pytest.approx(1.9, rel=0.25)
    assert abs(simulation.velocities[:e, 0].mean()) < 0.02 * abs(acceleration) * simulation.time
    assert simulation.record()["coupling"]["unconverged"] == 0


@pytest.mark.parametrize("modulus", [2e5, 5e5, 5e6])
@pytest.mark.parametrize("way", WAYS)
def test_energy_is_lost_but_not_won(way: dict, modulus: float) -> None:
    """Of a soft block that is wet all round, whose fast modes a step of the water cannot resolve.

    Explicit steps without damping of these won 30 J/m here.
    """
    scene = hung(**way)
    soft = lump([3, 3], [3, 5], material=Material(1000.0, modulus, 0.3))
    simulation = Simulation(pool(soft, cells=(10, 9), supports=scene.supports, **way))
    start, most = simulation.energy, 0.0
    for _ in range(20):
        simulation.advance(1)
        energy = simulation.energy
        most = max(most, energy.kinetic)
        # of the 30 J/m of the water's potential, which the pressure equation keeps to some 1e-4
        assert energy.balance < start.balance + 0.01
    # the water lies where its surface is, and has no way to fall
    assert most < 0.006
    assert energy.work == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_bodies_hold_the_work_that_the_water_has_done_on_them(way: dict) -> None:
    simulation = Simulation(hung(**way))
    start = simulation.solid.energy()
    simulation.advance(10)
    now, given = simulation.solid.energy(), simulation.record()["coupling"]["work_on_bodies"]
    # implicit steps count it as work from outside
    outside = now.work if takes_implicit_steps(simulation.scene) else given
    gained = now.total + now.dissipated - start.total
    assert outside == pytest.approx(given, rel=1e-9)
    assert abs(given) > 1e-3
    assert gained == pytest.approx(given, rel=0.02)


def test_collisions_are_no_work_from_outside() -> None:
    """Of water that falls on a soft post, whose foot rests."""
    foot = Support(name="foot", region=Box((0.06, 0.021), (0.5, 0.01)))
    post = Body(name="post", shape=Box((0.04, 0.2), (0.5, 0.1)), material=SOFT, spacing=0.02)
    water = Fluid(name="water", shape=Box((0.2, 0.1), (0.5, 0.3)), spacing=0.02, velocity=(0.0, -2.0))
    floor = Wall(name="floor", shape=Box((1.2, 0.08), (0.5, -0.04)), spacing=0.02)
    fields: dict = {"gravity": (0.0, -G), "duration": 0.1, "frame_rate": 100.0, "contact": ALONE}
    scene = Scene(bodies=(post,), supports=(foot,), fluids=(water,), walls=(floor,), **fields)
    system = system_of(scene)
    for interval in range(1, 11):
        system.advance(interval / scene.frame_rate)
    works = [float(work.numpy().sum()) for work in system.step.works]
    assert abs(works[1]) > 1e-3
    assert system.energy().work == pytest.approx(0.0, abs=1e-9 * sum(map(abs, works)))


def plate(density: float) -> Scene:
    """A column of water of 1 by 1 m on a clamped plate of 5 cm, of two particles and a metal's stiffness."""
    own, spacing = 0.025, 0.025
    ext, thick, height = 3 * spacing, 4 * spacing, 1.0
    metal = Material(density, 67.5e9, 0.34)
    body = Body(name="plate", shape=Box((1.0 + 2 * ext, 0.05), (0.5, -0.025)), material=metal, spacing=own)
    ends = [(-0.5 * ext, "left"), (1.0 + 0.5 * ext, "right")]
    supports = tuple(Support(name=name, region=Box((ext, 0.05), (x, -0.025))) for x, name in ends)
    sides = [(-0.5 * thick, "left"), (1.0 + 0.5 * thick, "right")]
    walls = tuple(
        Wall(name=f"{name}_wall", shape=Box((thick, height + 0.2), (x, 0.5 * height + 0.1)), spacing=spacing)
        for x, name in sides
    )
    water = Fluid(name="water", shape=Box((1.0, height), (0.5, 0.5 * height)), spacing=spacing)
    return Scene(
        bodies=(body,), supports=supports, walls=walls, fluids=(water,), gravity=(0.0, -G), contact=ALONE,
        duration=0.05, frame_rate=500.0,
    )  # fmt: skip


@pytest.mark.parametrize("ratio", [7.4, 74.0, 740.0])
def test_water_may_be_as_much_heavier_as_it_likes(ratio: float) -> None:
    """The mass of the column is so many times the plate's; it swings about its equilibrium, over five periods.

    Two particles are too soft by the same share whatever the load, so that the mean deflections are alike.
    """
    simulation = Simulation(plate(2700.0 * 7.4 / ratio))
    assert takes_implicit_steps(simulation.scene)
    middle = np.abs(simulation.particles.positions[: simulation.particles.elastic, 0] - 0.5) < 0.02
    found = []
    for _ in range(simulation.total_steps):
        simulation.advance(1)
        found.append(simulation.displacements[: len(middle)][middle, 1].mean())
    found = 1e5 * np.array(found)
    assert -3.5 < found[5:].mean() < -2.5
    assert found.min() > -7.0
    assert found.max() < 0.0
    assert np.abs(np.diff(found[15:])).max() < np.abs(np.diff(found[:10])).max()
    record = simulation.record()["coupling"]
    assert record["unconverged"] == 0
    assert record["passes"] < 4.0


@pytest.mark.parametrize("ratio", [2, 3])
def test_finer_bodies_are_the_same_to_the_water(ratio: int) -> None:
    """A stiff block in the way of water, of many particles a marker."""
    hard = Material(1000.0, 1e8, 0.3)
    held = (Support(name="all", region=Box((10.0, 10.0))),)
    fields: dict[str, Any] = {"cells": (6, 8), "room": (14, 12), "supports": held, **IMPLICIT}
    ends = [Simulation(pool(lump([6, 0], [3, 4], ratio=k, material=hard), **fields)) for k in (ratio, 1)]
    for simulation in ends:
        simulation.advance(10)
    one, other = (simulation.positions[-simulation.particles.liquid :] for simulation in ends)
    np.testing.assert_allclose(one, other, atol=1e-9 * L0)
    forces = [simulation.contact_forces[: simulation.particles.elastic] for simulation in ends]
    assert forces[1][:, 0].sum() > 1.0
    np.testing.assert_allclose(forces[0].sum(axis=0), forces[1].sum(axis=0), rtol=1e-9)


def test_a_wet_body_comes_to_rest_on_the_floor() -> None:
    body = lump([4, 1], [4, 3], material=Material(3000.0, 5e5, 0.3))
    simulation = Simulation(pool(body, cells=(12, 8), duration=1.0, **EXPLICIT))
    heights = []
    for _ in range(50):
        simulation.advance(1)
        heights.append(simulation.positions[:12, 1].min() / L0)
    assert min(heights) > 0.4, "half a spacing is a particle that lies on the wall"
    assert np.abs(np.array(heights[20:]) - 0.5).max() < 0.15
    assert simulation.energy.dissipated > 0.0
    assert simulation.record()["coupling"]["unconverged"] == 0


def test_wet_bodies_push_each_other_away() -> None:
    """Through the water, and by contact where they come near enough; none goes through the other."""
    heavy = Material(3000.0, 5e5, 0.3)
    one = lump([2, 3], [3, 2], material=heavy, velocity=(1.0, 0.0))
    other = lump([6, 3], [3, 2], name="other", material=heavy, velocity=(-1.0, 0.0))
    simulation = Simulation(pool(one, other, cells=(11, 8), **EXPLICIT))
    gaps, touched = [], 0.0
    for _ in range(15):
        simulation.advance(1)
        x = simulation.positions[:12, 0]
        gaps.append((x[6:].min() - x[:6].max()) / L0)
        touched = max(touched, simulation.energy.contact)
    assert min(gaps) > 0.7
    assert min(gaps) < 1.2
    assert touched > 0.0
    assert gaps[-1] > min(gaps)


@pytest.mark.parametrize("way", WAYS)
def test_water_may_be_shut_in_by_a_body(way: dict) -> None:
    """Its pressure is what the shell's stiffness makes of the errors of its volume: the shell gives little."""
    grid = np.stack(np.meshgrid(*(L0 * (np.arange(12) + 0.5),) * 2, indexing="ij"), -1).reshape(-1, 2)
    away = np.abs(grid - 6 * L0).max(axis=1) / L0
    shell = Body(name="shell", shape=Points(grid[(away > 2) & (away < 4)]), material=SOFT, spacing=L0)
    floor = Support(name="floor", region=Box((1.0, 2.0 * L0), (0.0, 3.01 * L0)))
    simulation = Simulation(pool(shell, cells=(12, 12), supports=(floor,), **way))
    inside = np.flatnonzero(np.abs(simulation.particles.positions - 6 * L0).max(axis=1) < 2 * L0)
    simulation.advance(15)
    assert len(inside) == 16
    assert np.abs(simulation.positions[inside] - 6 * L0).max() < 2 * L0
    assert np.abs(simulation.displacements[: simulation.particles.elastic]).max() < 0.1 * L0
    assert simulation.record()["coupling"]["unconverged"] == 0
    assert simulation.record()["fluid"]["lost"] == 0


def test_water_that_touches_no_body_leaves_it_alone() -> None:
    """The body falls freely, and the water is what it is without it; the midpoint rule is exact for a fall.

    In a scheme that evaluates the pressure at predicted positions with and without bodies.
    """
    flow = Flow(scheme="corrected")
    made = pool(lump([0, 20], [3, 3]), cells=(8, 6), theta=0.5, flow=flow, **IMPLICIT)
    both = Simulation(made)
    alone = Simulation(Scene(walls=made.walls, fluids=made.fluids, gravity=made.gravity, duration=0.2, flow=flow))
    for simulation in (both, alone):
        simulation.advance(5)
    m = alone.particles.liquid
    np.testing.assert_allclose(both.positions[-m:], alone.positions[-m:], atol=2e-3 * L0)
    fallen = both.displacements[:9]
    np.testing.assert_allclose(fallen, np.tile([0.0, -0.5 * G * 0.05**2], (9, 1)), rtol=1e-6, atol=1e-9)
    assert both.record()["coupling"]["passes"] == 1.0

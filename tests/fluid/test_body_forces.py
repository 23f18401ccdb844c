"""Body forces on fluids: gravity given as one, an oscillating drop, and elastic bodies in water under one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.bits import assert_same_bits, states
from tests.coupling.scenes import EXPLICIT, IMPLICIT, lump
from tests.fluid.scenes import L0, scene_of, tank, walls_about, water
from warp_mps.errors import InputError
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import BodyForce, Flow, Fluid, Liquid, Scene, TableMotion, VelocityField
from warp_mps.scene.filling_level import fill_to
from warp_mps.scene.tank_walls import tank as make_tank
from warp_mps.shapes import Sphere

G = 9.81
# of the drop: attraction to its centre [rad/s], and rate of stretching at the start [1/s]
OMEGA, SIGMA = 1.0, 0.5
# Monaghan & Rafiee, Int. J. Numer. Meth. Fluids 71 (2013) 537: period [s] and longest half axis [m] of a drop of 1 m
# radius, from the exact ordinary differential equations of its half axes
PERIOD, LONGEST = 4.56735, 1.41421


def fall(x: np.ndarray, t: float) -> np.ndarray:
    """Gravity along -y."""
    return np.broadcast_to([0.0, -G, 0.0][: x.shape[1]], x.shape)


@wp.func
def warp_fall(x: Any, t: Any):
    """The same as a Warp function."""
    a = type(x)()
    a[1] = type(t)(-G)
    return a


def attract(x: np.ndarray, t: float) -> np.ndarray:
    """A force per mass -Omega^2 r."""
    return -(OMEGA**2) * x


@wp.func
def warp_attract(x: wp.vec2d, t: wp.float64) -> wp.vec2d:
    """The same as a Warp function."""
    return -x


def instead_of_gravity(scene: Scene, function: Any = fall) -> Scene:
    """A scene with a body force in the place of its gravity."""
    force = BodyForce(name="fall", acceleration=function)
    return replace(scene, gravity=(), body_forces=(force,), time_step=1e-3)


def drop(l0: float, function: Any = attract, **fields: Any) -> Scene:
    """A round drop that is drawn out along x, attracted by its centre."""
    field = VelocityField(kind="stagnation", rate=SIGMA, axis=(1.0, 0.0), origin=(0.0, 0.0))
    fluid = Fluid(name="drop", shape=Sphere(1.0), spacing=l0, velocity_field=field)
    force = BodyForce(name="attraction", acceleration=function)
    return Scene(fluids=(fluid,), body_forces=(force,), frame_rate=50.0, **{"duration": 5.0, **fields})


def half_axes(simulation: Simulation) -> np.ndarray:
    """Half axes of the ellipse of the same second moments, in units of those at the start, shape [2]."""
    return np.sqrt(np.mean(simulation.positions**2, axis=0) / np.mean(simulation.particles.positions**2, axis=0))


def oscillate(simulation: Simulation, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and half axes, shapes [k] and [k, 2]."""
    times, axes = [0.0], [half_axes(simulation)]
    while simulation.time < duration:
        simulation.advance(1)
        times.append(simulation.time)
        axes.append(half_axes(simulation))
    return np.array(times), np.array(axes)


def crossings(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Times at which values change their sign."""
    k = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return times[k] + (times[k + 1] - times[k]) * values[k] / (values[k] - values[k + 1])


def test_an_attracted_drop_oscillates_as_the_exact_equations_say() -> None:
    """At 10 particles along its radius; the drop is round twice in a period."""
    simulation = Simulation(drop(0.1))
    start = simulation.energy
    times, axes = oscillate(simulation, 5.0)
    _, period = crossings(times, axes[:, 0] - axes[:, 1])
    assert period == pytest.approx(PERIOD, rel=0.01)
    assert axes.max() == pytest.approx(LONGEST, rel=0.02)
    np.testing.assert_allclose(axes[:, 0] * axes[:, 1], 1.0, atol=0.02)
    # the potential is in the work: the difference is the dissipation of the scheme
    missing = (start.balance - simulation.energy.balance) / start.kinetic
    assert 0.0 < missing < 0.15


@pytest.mark.slow
@pytest.mark.parametrize(("l0", "accuracy"), [(0.05, 0.008), (0.025, 0.006)])
def test_three_periods_of_an_attracted_drop(l0: float, accuracy: float) -> None:
    """The mean period is 0.6 % and 0.4 % too short, as dissipation makes the oscillation smaller, and so faster."""
    simulation = Simulation(drop(l0))
    times, axes = oscillate(simulation, 3.2 * PERIOD)
    third = crossings(times, axes[:, 0] - axes[:, 1])[5]
    assert third / 3.0 == pytest.approx(PERIOD, rel=accuracy)
    assert axes.max() == pytest.approx(LONGEST, rel=0.01)


def test_a_python_function_is_the_same_as_a_warp_function() -> None:
    of_python, of_warp = (Simulation(drop(0.1, function)) for function in (attract, warp_attract))
    for simulation in (of_python, of_warp):
        simulation.step_to(0.2)
    np.testing.assert_allclose(of_python.positions, of_warp.positions, atol=1e-9)
    np.testing.assert_allclose(of_python.energy.work, of_warp.energy.work, rtol=1e-9)


@pytest.mark.parametrize("function", [attract, warp_attract])
def test_graphs_kernels_and_restarts_give_the_same_bits(function: Any) -> None:
    """Restarted after the particles have been sorted."""
    scene = drop(0.1, function, time_step=1e-3)
    expected = states(Simulation(scene), 6, 2)
    assert_same_bits(states(Simulation(scene, graphs=False), 6, 2), expected)
    restored = Simulation(scene)
    restored.restore(expected[0])
    assert_same_bits(states(restored, 2), expected[1:])


@pytest.mark.parametrize("function", [fall, warp_fall])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_force_is_as_good_as_gravity_in_a_tank(function: Any, dimension: int) -> None:
    """The pressure at rest, on walls too, is rho g h, and the floor carries the weight."""
    scene = instead_of_gravity(tank((8, 8, 5)[:dimension]), function)
    simulation = Simulation(scene)
    simulation.step_to(0.1)
    fluid = slice(simulation.particles.count - simulation.particles.liquid, None)
    weight = G * float(simulation.particles.masses[fluid].sum())
    assert simulation.contact_forces.sum(axis=0)[1] == pytest.approx(-weight, rel=0.05)
    y = simulation.positions[:, 1]
    expected = 1000.0 * G * (8.0 * L0 - y)
    near = (y > -L0) & (simulation.pressures > 0.0)
    assert near.sum() > simulation.particles.liquid // 2
    np.testing.assert_allclose(simulation.pressures[near], expected[near], atol=0.08 * 1000.0 * G * 8.0 * L0)
    # the impulse of the force is no internal force
    forces = simulation.internal_forces
    assert np.linalg.norm(forces.sum(axis=0)) < 1e-6 * np.linalg.norm(forces, axis=1).sum()


def test_water_falls_alike_under_gravity_and_under_a_body_force() -> None:
    """Free fall by x = g t (t + dt)/2, the sum of a semi-implicit step, viscosity or not; the work is its energy."""
    liquid = Liquid(viscosity=1e-3)
    scene = scene_of(water([0.0, 0.0], [0.1, 0.1], liquid=liquid), time_step=1e-3, flow=Flow())
    force = BodyForce(name="fall", acceleration=fall)
    simulation = Simulation(replace(scene, body_forces=(force,)))
    simulation.step_to(0.05)
    t = simulation.time
    np.testing.assert_allclose(simulation.velocities, [[0.0, -G * t]] * simulation.particles.count, atol=1e-9)
    energy = simulation.energy
    assert energy.work == pytest.approx(energy.kinetic, rel=1e-9)


def test_implicit_viscosity_sees_the_force() -> None:
    liquid = Liquid(viscosity=1.0)
    scene = scene_of(water([0.0, 0.0], [0.1, 0.1], liquid=liquid), time_step=2e-3)
    force = BodyForce(name="fall", acceleration=fall)
    simulation = Simulation(replace(scene, body_forces=(force,)))
    assert simulation.fluids.step.implicit_viscosity is not None
    simulation.step_to(0.02)
    np.testing.assert_allclose(simulation.velocities[:, 1], -G * simulation.time, rtol=1e-5)


def test_a_moving_wall_and_a_force_add_up() -> None:
    """A tank that is raised with the acceleration of gravity, without gravity, holds water as one under gravity."""
    times = np.linspace(0.0, 0.2, 41)
    lift = TableMotion(
        times=times, displacements=np.stack([0.0 * times, 0.25 * G * times**2], axis=1), interpolation="cubic"
    )
    scene = tank((8, 8))
    walls = tuple(replace(wall, motion=lift) for wall in scene.walls)
    force = BodyForce(name="fall", acceleration=lambda x, t: 0.5 * fall(x, t))
    simulation = Simulation(replace(scene, walls=walls, gravity=(), body_forces=(force,), time_step=1e-3))
    simulation.step_to(0.1)
    fluid = slice(simulation.particles.count - simulation.particles.liquid, None)
    weight = G * float(simulation.particles.masses[fluid].sum())
    assert simulation.contact_forces.sum(axis=0)[1] == pytest.approx(-weight, rel=0.1)


@pytest.mark.parametrize("way", [EXPLICIT, IMPLICIT], ids=["explicit", "implicit"])
@pytest.mark.parametrize("function", [fall, warp_fall])
def test_a_body_in_water_under_a_force_is_as_under_gravity(way: dict[str, Any], function: Any) -> None:
    """A block as heavy as water stays afloat in it, under a body force as under gravity."""
    scene = scene_of(
        water([0.0, 0.0], [0.24, 0.12]),
        bodies=(lump([4, 6], [4, 3]),),
        walls=walls_about(np.array([0.24, 0.2]), layers=4),
        gravity=(0.0, -G),
        **way,
    )
    runs = Simulation(scene), Simulation(instead_of_gravity(scene, function))
    for simulation in runs:
        simulation.step_to(0.05)
    first, last = runs[0].particles.ranges[0]
    moved = [simulation.displacements[first:last, 1].mean() for simulation in runs]
    assert abs(moved[0]) > 1e-5
    assert moved[1] == pytest.approx(moved[0], abs=0.05 * L0)
    forces = [simulation.contact_forces[first:last].sum(axis=0)[1] for simulation in runs]
    assert forces[1] == pytest.approx(forces[0], rel=0.1)


def test_forces_on_bodies_alone_leave_the_water_alone() -> None:
    scene = scene_of(
        water([0.0, 0.0], [0.24, 0.12]),
        bodies=(lump([4, 8], [4, 3]),),
        walls=walls_about(np.array([0.24, 0.4]), layers=4),
        **EXPLICIT,
    )
    force = BodyForce(name="lift", acceleration=lambda x, t: -fall(x, t), acts_on=("lump",))
    simulation = Simulation(replace(scene, body_forces=(force,)))
    assert simulation.fluids.step.body_forces is None
    simulation.step_to(0.02)
    first, last = simulation.particles.ranges[0]
    assert (simulation.velocities[first:last, 1] > 0.1).all()


def test_fluids_are_one_liquid_for_a_force() -> None:
    scene = scene_of(water([0.0, 0.0], [0.1, 0.1]), water([0.3, 0.0], [0.4, 0.1], name="more"))
    force = BodyForce(name="fall", acceleration=fall, acts_on=("water",))
    with pytest.raises(InputError, match="body force 'fall' acts_on: leaves out more: the fluids are one liquid"):
        replace(scene, body_forces=(force,))


@pytest.mark.parametrize("function", [fall, warp_fall])
def test_water_whose_weight_is_a_body_force_passes_the_guard(function: Any, tmp_path: Path) -> None:
    """It settles by parts of a spacing, as under gravity, which is no instability."""
    walls = make_tank((0.0, 0.0), (0.4, 0.3), 0.02)
    force = BodyForce(name="weight", acceleration=function)
    scene = Scene(name="tank", fluids=(fill_to(0.16, walls),), walls=walls, body_forces=(force,), duration=0.05)
    assert run_scene(scene, tmp_path, quiet=True).status == "done"

"""Supports: held axes, moving supports, and their work and forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.scenes import beam, block, ends, scene_of
from warp_mps.errors import InputError
from warp_mps.run.simulation import Simulation
from warp_mps.scene import HarmonicMotion, Scene, Support, TableMotion
from warp_mps.shapes import Box

EVERYTHING = Box((1.0, 1.0))
GRIP = ends(0.011)[0]  # the beam's first 2 columns of particles, at 2 layers the first one
SWING = HarmonicMotion(amplitude=(0.0, 0.002), frequency=10.0, phase=0.3)
TABLE = TableMotion(
    times=np.array([0.01, 0.03, 0.05]), displacements=np.array([[0.0, 0.0], [0.002, 0.01], [0.002, -0.005]])
)
SPLINE = replace(TABLE, interpolation="cubic")


def shaken(motion: HarmonicMotion | TableMotion, **fields: object) -> Scene:
    """A beam that one end is moved of."""
    scene = {"time_step": fields.pop("time_step", 2e-5), "duration": fields.pop("duration", 0.1)}
    return beam(2, supports=(Support(name="grip", region=GRIP, motion=motion, **fields),), **scene)  # type: ignore[arg-type]


def harmonic(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity of `SWING`."""
    w = 2.0 * np.pi * 10.0
    shape = np.array([0.0, 0.002])
    return shape * (np.sin(w * t + 0.3) - np.sin(0.3)), shape * w * np.cos(w * t + 0.3)


def table(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity of `TABLE`, the velocity that of the interval that begins at t."""
    times, rows = TABLE.times, TABLE.displacements
    k = int(np.searchsorted(times, t, side="right"))
    velocity = np.zeros(2) if k in (0, len(times)) else (rows[k] - rows[k - 1]) / (times[k] - times[k - 1])
    return np.array([np.interp(t, times, row) for row in rows.T]), velocity


def spline(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity of `SPLINE`."""
    curve = CubicSpline(TABLE.times, TABLE.displacements, bc_type="clamped")
    inside = TABLE.times[0] <= t < TABLE.times[-1]
    return curve(np.clip(t, TABLE.times[0], TABLE.times[-1])), curve(t, 1) if inside else np.zeros(2)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize(
    ("motion", "formula"), [(SWING, harmonic), (TABLE, table), (SPLINE, spline)], ids=["harmonic", "table", "spline"]
)
def test_a_moving_support_follows_its_motion_at_every_step(motion, formula, precision: str) -> None:
    """61 microseconds divide none of the table's times, so that no step falls on a kink."""
    simulation = Simulation(shaken(motion, time_step=6.1e-5), precision=precision)
    held = simulation.particles.positions[:, 0] < 0.011
    assert held.sum() == 2
    rounding = {"float64": 1e-15, "float32": 1e-6}[precision]
    while simulation.time < 0.07:
        displacement, velocity = formula(simulation.time)
        np.testing.assert_allclose(simulation.displacements[held], [displacement] * 2, atol=0.01 * rounding)
        np.testing.assert_allclose(simulation.velocities[held], [velocity] * 2, atol=10 * rounding)
        np.testing.assert_array_equal(simulation.rotations[held], 0.0)
        simulation.advance(1 if simulation.step < 40 else 13)


@pytest.mark.parametrize("motion", [SWING, TABLE, SPLINE], ids=["harmonic", "table", "spline"])
def test_work_of_a_moving_support_balances_the_energy(motion: HarmonicMotion | TableMotion) -> None:
    """The error is of second order in the step, also where a table makes the velocity jump."""

    def error(steps: int) -> float:
        simulation = Simulation(shaken(motion, time_step=0.06 / steps))
        start, errors = simulation.energy.balance, []
        for _ in range(60):
            simulation.advance(steps // 60)
            errors.append(simulation.energy.balance - start)
        assert simulation.energy.work > 0.05
        return float(np.abs(errors).max() / simulation.energy.work)

    errors = np.array([error(steps) for steps in (3000, 6000, 12000)])
    print(f"relative errors of the balance: {errors}")
    assert (errors[:-1] / errors[1:] > 3.5).all()
    assert errors[-1] < 5e-5


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_motion_of_the_whole_body_takes_its_mass_times_acceleration(dimension: int) -> None:
    """Every particle is held: no deformation, and the reaction is m a - weight."""
    amplitude, gravity = np.array((0.001, 0.002, -0.003)[:dimension]), np.array((0.0, -9.81, 1.0)[:dimension])
    motion = HarmonicMotion(amplitude=amplitude, frequency=50.0, phase=0.5)
    support = Support(name="hand", region=Box([1.0] * dimension), motion=motion)
    simulation = Simulation(scene_of(block(dimension), dimension=dimension, supports=(support,), gravity=gravity))
    start = simulation.energy
    assert start.work == 0.0
    simulation.advance(777)
    mass, w = simulation.particles.masses.sum(), 2.0 * np.pi * 50.0
    phase = w * simulation.time + 0.5
    force = mass * (-(w**2) * amplitude * np.sin(phase) - gravity)
    np.testing.assert_allclose(simulation.reactions.sum(axis=0), force, rtol=1e-10)
    kinetic = 0.5 * mass * (w * np.cos(phase)) ** 2 * (amplitude @ amplitude)
    assert simulation.energy.kinetic == pytest.approx(kinetic, rel=1e-10)
    fall = mass * gravity @ amplitude * (np.sin(phase) - np.sin(0.5))
    work = kinetic - start.kinetic - fall
    assert simulation.energy.work == pytest.approx(work, abs=1e-4 * abs(work))


def test_reactions_carry_the_weight() -> None:
    """A damped block comes to rest on a clamped bottom row."""
    floor = Support(name="floor", region=Box((1.0, 0.011), (0.0, -0.015)))
    simulation = Simulation(scene_of(block(2), supports=(floor,), gravity=(0.0, -9.81), damping=2000.0))
    simulation.advance(4000)
    weight = simulation.particles.masses.sum() * 9.81
    np.testing.assert_allclose(simulation.reactions.sum(axis=0), [0.0, weight], atol=1e-6 * weight)
    free = np.abs(simulation.reactions).max(axis=1) == 0.0
    np.testing.assert_array_equal(free, simulation.particles.positions[:, 1] > -0.01)
    np.testing.assert_allclose(simulation.internal_forces[free].sum(axis=0), [0.0, 8 / 12 * weight], atol=1e-6 * weight)


@pytest.mark.parametrize(
    ("fields", "moves", "turns"),
    [
        ({}, (False, False), False),
        ({"axes": (1,)}, (True, False), True),
        ({"axes": (0, 1)}, (False, False), False),
        ({"hold_rotation": False}, (False, False), True),
        ({"axes": (1,), "hold_rotation": True}, (True, False), False),
    ],
    ids=["clamp", "roller", "both axes", "pin", "guide"],
)
def test_what_a_support_holds(fields: dict, moves: tuple[bool, bool], turns: bool) -> None:
    """A slanted pull on the free end of a beam whose first column is held."""
    support = Support(name="grip", region=GRIP, **fields)
    simulation = Simulation(beam(2, supports=(support,), gravity=(30.0, -30.0)))
    simulation.advance(500)
    held = simulation.particles.positions[:, 0] < 0.011
    for axis, free in enumerate(moves):
        assert (simulation.displacements[held, axis] != 0.0).all() == free
    assert (simulation.rotations[held] != 0.0).all() == turns
    assert (simulation.displacements[~held] != 0.0).all()
    assert (simulation.rotations[~held] != 0.0).all()


def test_held_particles_start_at_rest() -> None:
    support = Support(name="grip", region=Box((0.011, 1.0), (-0.015, 0.0)), axes=(1,))
    spinning = block(2, velocity=(1.0, 2.0), angular_velocity=3.0)
    simulation = Simulation(scene_of(spinning, supports=(support,)))
    held = simulation.particles.positions[:, 0] < -0.01
    assert (simulation.velocities[held, 1] == 0.0).all()
    assert (simulation.velocities[held, 0] != 0.0).all()
    assert (simulation.angular_velocities == 3.0).all()


def test_a_support_of_named_bodies_leaves_the_others_free() -> None:
    bodies = [block(2, name=name, shape=Box((0.04, 0.03), (x, 0.0))) for name, x in (("a", 0.0), ("b", 0.05))]
    support = Support(name="grip", region=EVERYTHING, bodies=("b",))
    simulation = Simulation(scene_of(*bodies, supports=(support,), gravity=(0.0, -1.0)))
    simulation.advance(10)
    np.testing.assert_array_equal(simulation.displacements[:, 1] == 0.0, simulation.particles.bodies == 1)


@pytest.mark.parametrize("motions", [(SWING, SWING), (None, SWING), (SWING, None)])
def test_a_moving_support_shares_no_axis_of_a_particle(motions: tuple[HarmonicMotion | None, ...]) -> None:
    supports = tuple(
        Support(name=name, region=GRIP, motion=motion, axes=axes, path=f"/World/{name}")
        for name, axes, motion in zip(("one", "two"), ((0, 1), (1,)), motions, strict=True)
    )
    with pytest.raises(InputError, match="/World/two motion: holds particles along an axis along which another"):
        Simulation(beam(2, supports=supports))


def test_two_motions_along_different_axes_are_not() -> None:
    across = HarmonicMotion(amplitude=(0.001, 0.0), frequency=20.0)
    supports = (
        Support(name="one", region=GRIP, motion=SWING, axes=(1,)),
        Support(name="two", region=GRIP, motion=across, axes=(0,)),
    )
    simulation = Simulation(beam(2, supports=supports))
    simulation.advance(500)
    held = simulation.particles.positions[:, 0] < 0.011
    x = 0.001 * np.sin(2 * np.pi * 20.0 * simulation.time)
    expected = np.array([x, harmonic(simulation.time)[0][1]])
    np.testing.assert_allclose(simulation.displacements[held], [expected] * 2, atol=1e-17)


def test_a_support_that_holds_nothing_is_refused() -> None:
    support = Support(name="grip", region=Box((0.01, 0.01), (9.0, 0.0)), path="/World/grip")
    with pytest.raises(InputError, match="/World/grip region: the support holds no particle"):
        Simulation(beam(2, supports=(support,)))

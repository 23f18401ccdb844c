"""Viscosity in steps too long for it to be explicit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.fluid.scenes import KINDS, L0, fluids_of, periodic_box, stir, tank, tolerance, total_momentum
from tests.fluid.scenes import wall_count as walls_of
from warp_mps.fluid.time_step import VISCOUS_STEP, step_limit
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Liquid

HONEY = Liquid(viscosity=1.0)


@pytest.mark.parametrize(("viscosity", "implicit"), [(1e-6, False), (1.0, True)])
def test_viscosity_is_implicit_where_it_would_limit_the_step(viscosity: float, implicit: bool) -> None:
    scene = tank((8, 8), fluid={"liquid": Liquid(viscosity=viscosity)})
    limit, found = step_limit(scene, fill_scene(scene))
    assert found is implicit
    assert (limit * viscosity > VISCOUS_STEP * L0**2) is implicit
    assert limit == step_limit(tank((8, 8)), fill_scene(scene))[0]


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_the_step_satisfies_its_equation(dimension: int, precision: str) -> None:
    """U' = u + dt (g + nu lap u'), by the operator of explicit viscosity."""
    cells = (8, 8) if dimension == 2 else (5, 5, 4)
    scene = tank(cells, fluid={"liquid": HONEY}, wall={"slip": "no"})
    fluids = fluids_of(scene, precision=precision)
    stir(fluids, amount=0.1, speed=1.0)
    w, dt = walls_of(fluids), 1e-3
    before = fluids.state.u.numpy()[w:].astype(float)
    fluids.step.time_step.dt.assign([dt])
    fluids.step.apply_viscosity()
    fluids.step.predict()
    assert fluids.step.implicit_viscosity is not None
    solved = fluids.step.implicit_viscosity.u.numpy()[w:]
    size = np.abs(before).max()
    gravity = np.asarray(scene.gravity)
    change = dt * (gravity + fluids.step.viscous_acceleration.numpy()[w:])
    np.testing.assert_allclose(solved, before + change, atol=tolerance(precision, 1e-5, 1e-4) * size)
    # stirred water is nearly still after a step of dt nu = 2.5 l0^2, but for its mean
    assert np.std(solved) < 0.3 * np.std(before)


def test_a_shear_wave_decays_as_exactly_as_steps_allow() -> None:
    """Backward Euler in a periodic box: the factor of a step is 1/(1 + dt nu k^2), k as the operator has it."""
    scene = periodic_box((16, 12), time_step=2e-3)
    fluids = fluids_of(replace(scene, fluids=(replace(scene.fluids[0], liquid=HONEY),)))
    assert fluids.step.implicit_viscosity is not None
    x = fluids.state.x.numpy()
    k = 2.0 * np.pi / (16 * L0)
    u = np.zeros_like(x)
    u[:, 1] = np.sin(k * x[:, 0])
    fluids.state.u.assign(u)
    fluids.step.time_step.dt.assign([2e-3])
    fluids.step.apply_viscosity()
    fluids.step.predict()
    decay = np.abs(fluids.step.implicit_viscosity.u.numpy()[:, 1]).max() / np.abs(u).max()
    assert decay == pytest.approx(1.0 / (1.0 + 2e-3 * k**2), rel=0.02)


def test_what_the_water_loses_the_walls_gain() -> None:
    fluids = fluids_of(tank((8, 8), fluid={"liquid": HONEY}, wall={"slip": "no"}, gravity=()))
    stir(fluids, amount=0.1, speed=1.0)
    before = total_momentum(fluids)
    fluids.step.time_step.dt.assign([1e-3])
    fluids.step.apply_viscosity()
    fluids.step.predict()
    impulse = fluids.state.impulse.numpy().sum(axis=0)
    assert np.abs(impulse).max() > 0.0
    np.testing.assert_allclose(total_momentum(fluids) - before, -impulse, atol=1e-12)


def test_honey_creeps_in_a_tank() -> None:
    """A column of it sinks slowly, with steps eighty times as long as explicit viscosity would take."""
    fluids = fluids_of(tank((6, 12), room=(18, 14), fluid={"liquid": HONEY}, wall={"slip": "no"}))
    level = fluids.readings.positions()[walls_of(fluids) :, 1].mean()
    steps = fluids.advance(0.2)
    assert steps < 0.2 / (20.0 * VISCOUS_STEP * L0**2)
    sunk = level - fluids.readings.positions()[walls_of(fluids) :, 1].mean()
    # water has lost half of its height by then
    assert 0.1 * L0 < sunk < 0.3 * level
    assert fluids.trouble() is None
    assert np.abs(fluids.velocities()).max() < 0.5

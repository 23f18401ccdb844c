"""The motion of fluid particles: viscosity, collisions, shifts, the clock, periods and losses."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.fluid.scenes import (
    KINDS,
    L0,
    box,
    fluids_of,
    pairs,
    periodic_box,
    scene_of,
    small,
    stir,
    tank,
    tolerance,
    total_momentum,
    wall_count,
    water,
)
from warp_mps.fluid.collisions import KEPT_APART, RESTITUTION
from warp_mps.fluid.fluids import Fluids
from warp_mps.fluid.shifting import LARGEST_SHIFT, SHIFT
from warp_mps.scene import Flow, Liquid, Wall

NU = 0.01
DT = 1e-4
VISCOUS = Liquid(viscosity=NU)


def predicted(fluids: Fluids, dt: float = DT) -> np.ndarray:
    """Acceleration of the fluid in the predictor [m/s^2], shape [m, d]."""
    w = wall_count(fluids)
    before = fluids.state.u.numpy().astype(float)[w:]
    fluids.step.time_step.dt.assign([dt])
    fluids.step.apply_viscosity()
    fluids.step.predict()
    return (fluids.state.u.numpy().astype(float)[w:] - before) / dt


def finished(fluids: Fluids, dt: float = DT) -> np.ndarray:
    """Change of the fluid's velocities in the end of a step without pressure, by collisions, shape [m, d]."""
    w = wall_count(fluids)
    before = fluids.state.u.numpy().astype(float)[w:]
    fluids.step.time_step.dt.assign([dt])
    fluids.state.p.zero_()
    fluids.step.correct()
    fluids.step.collide()
    fluids.step.advance_clock()
    return fluids.state.u.numpy().astype(float)[w:] - before


def put(fluids: Fluids, rows: dict[int, tuple[list[float], list[float]]]) -> None:
    """Put particles of the fluid at positions, with velocities."""
    x, u, w = fluids.state.x.numpy().copy(), fluids.state.u.numpy().copy(), wall_count(fluids)
    for k, (position, velocity) in rows.items():
        x[w + k], u[w + k] = position, velocity
    fluids.state.x.assign(x)
    fluids.state.u.assign(u)
    fluids.step.renew_neighbours()


@pytest.mark.parametrize("slip", ["free", "no"])
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_viscous_forces_are_those_of_numpy(dimension: int, precision: str, slip: str) -> None:
    """And walls hold the water back only where it does not slip: they get what it loses."""
    fluid = {"liquid": VISCOUS}
    scene = tank(small(dimension), wall={"slip": slip}, fluid=fluid, gravity=(), time_step=DT)
    fluids = fluids_of(scene, precision=precision)
    stir(fluids)
    w = wall_count(fluids)
    u = fluids.state.u.numpy().astype(float)
    _, _, weights = pairs(fluids)
    if slip == "free":
        weights[:, :w] = 0.0
    else:
        near, beside = weights[:w, w:], weights[:w, w:].sum(axis=1) > 0.0
        u[:w][beside] = -(near @ u[w:])[beside] / near.sum(axis=1)[beside, None]
    factor = NU * fluids.model.operators.laplacian
    expected = factor * (weights[w:] @ u - weights[w:].sum(axis=1)[:, None] * u[w:])
    near = tolerance(precision, 1e-9, 1e-3)
    np.testing.assert_allclose(predicted(fluids), expected, atol=near * np.abs(expected).max())
    impulse = fluids.state.impulse.numpy()[:w]
    lost = -1000.0 * L0**dimension * DT * expected.sum(axis=0)
    if slip == "free":
        assert not impulse.any()
        lost = np.zeros(dimension)
    np.testing.assert_allclose(impulse.sum(axis=0), lost, atol=near * np.abs(impulse).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_viscosity_of_a_quadratic_velocity_is_exact(dimension: int) -> None:
    """On the lattice, away from the ends."""
    cells = (14, 14, 9)[:dimension]
    block = water([0.0] * dimension, [L0 * n for n in cells], liquid=VISCOUS)
    fluids = fluids_of(scene_of(block, dimension=dimension, time_step=DT))
    x = fluids.state.x.numpy()
    middle = x.mean(axis=0)
    u = np.zeros_like(x)
    u[:, 0] = 3.0 * (x[:, 1] - middle[1]) ** 2
    u[:, 1] = (x[:, 0] - middle[0]) ** 2 + (x[:, 1] - middle[1])
    fluids.state.u.assign(u)
    inside = np.abs(x - middle).max(axis=1) < 1.1 * L0
    expected = NU * np.array([6.0, 2.0, 0.0][:dimension])
    found = predicted(fluids)[inside]
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-8, atol=1e-12)


def channel_error(cells: int) -> float:
    """Error of a flow along a channel that starts from rest, relative to its speed (root mean squares)."""
    height, g, end, spacing = 0.2, 0.1, 1.0, 0.2 / cells
    width, t = 16 * spacing, 4 * spacing
    walls = tuple(
        Wall(name=name, shape=box([0.0, low], [width, low + t]), spacing=spacing, slip="no")
        for name, low in (("floor", -t), ("ceiling", height))
    )
    body = water([0.0, 0.0], [width, height], spacing=spacing, liquid=VISCOUS)
    flow = Flow(domain=([0.0, -t], [width, height + t]), periodic=(0,))
    fluids = fluids_of(scene_of(body, walls=walls, gravity=(g, 0.0), flow=flow))
    fluids.advance(end)
    w = wall_count(fluids)
    y, u = fluids.readings.positions()[w:, 1], fluids.velocities()[w:]
    expected = 0.5 * g / NU * y * (height - y)
    for k in np.pi * np.arange(1, 40, 2) / height:
        expected -= 4.0 * g / (NU * height * k**3) * np.sin(k * y) * np.exp(-(k**2) * NU * end)
    speed = np.sqrt(np.mean(expected**2))
    assert np.abs(u[:, 1]).max() < 0.05 * speed
    return float(np.sqrt(np.mean((u[:, 0] - expected) ** 2)) / speed)


def test_a_flow_along_a_channel_is_that_of_poiseuille() -> None:
    """While it builds up, between walls without slip, with an error of the second order in the spacing.

    The row beside a wall is too fast, for the wall's velocity is that of its particles, half a spacing behind its face.
    """
    coarse, fine = channel_error(8), channel_error(16)
    assert coarse < 0.06
    assert fine < 0.25 * coarse


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_two_particles_that_approach_collide(precision: str) -> None:
    """Along their line, with the coefficient of restitution, and momentum kept; what is across stays."""
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0])), precision=precision)
    gap = 0.4 * L0
    put(fluids, {0: ([0.3, 0.3], [0.5, 0.2]), 1: ([0.3 + gap, 0.3], [-0.1, 0.0])})
    du = finished(fluids)
    expected = 0.5 * (1.0 + RESTITUTION) * 0.6
    near = tolerance(precision, 1e-12, 1e-6)
    np.testing.assert_allclose(du[0], [-expected, 0.0], atol=near)
    np.testing.assert_allclose(du[1], [expected, 0.0], atol=near)
    np.testing.assert_allclose(du[2:], 0.0, atol=near)
    # what is changed is changed from the start of the step on
    x = fluids.state.x.numpy()
    np.testing.assert_allclose(x[:2, 0], [0.3 - DT * expected, 0.3 + gap + DT * expected], atol=near)


@pytest.mark.parametrize(
    ("gap", "speed"), [(0.4 * L0, 0.3), (1.001 * KEPT_APART * L0, -0.3), (0.4 * L0, 0.0)], ids=["part", "far", "rest"]
)
def test_what_parts_or_is_far_does_not_collide(gap: float, speed: float) -> None:
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0])))
    put(fluids, {0: ([0.3, 0.3], [0.0, 1.0]), 1: ([0.3 + gap, 0.3], [speed, -1.0])})
    assert not finished(fluids).any()


def test_a_particle_bounces_off_a_wall_which_gets_its_impulse() -> None:
    fluids = fluids_of(tank((8, 8), room=(16, 20), gravity=()))
    w, walls = wall_count(fluids), fluids.state.x.numpy()[: wall_count(fluids)]
    floor = int(np.argmin(np.linalg.norm(walls - [12.5 * L0, -0.5 * L0], axis=1)))
    put(fluids, {0: ([walls[floor, 0], walls[floor, 1] + 0.7 * L0], [0.0, -0.4])})
    du = finished(fluids)
    np.testing.assert_allclose(du[0], [0.0, 0.4 * (1.0 + RESTITUTION)], rtol=1e-12)
    impulse = fluids.state.impulse.numpy()
    np.testing.assert_allclose(impulse[floor], -1000.0 * L0**2 * du[0], rtol=1e-12)
    assert np.count_nonzero(impulse.any(axis=1)) == 1
    assert w == len(impulse)


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_collisions_keep_momentum_and_take_energy(dimension: int, precision: str) -> None:
    """Of many particles that are too close to each other and to walls."""
    fluids = fluids_of(tank(small(dimension), gravity=()), precision=precision)
    stir(fluids, amount=0.7, speed=1.0)
    before, energy = total_momentum(fluids), fluids.energy().kinetic
    du = finished(fluids)
    hit = np.abs(du).max(axis=1) > 0.0
    assert hit.sum() > 5
    change = total_momentum(fluids) - before + fluids.state.impulse.numpy().sum(axis=0)
    np.testing.assert_allclose(change, 0.0, atol=tolerance(precision, 1e-12, 1e-5))
    assert fluids.energy().kinetic < energy


@pytest.mark.parametrize("dimension", [2, 3])
def test_shifts_even_out_the_particles_inside_and_leave_the_surface(dimension: int) -> None:
    scene = tank((16, 16) if dimension == 2 else (9, 9, 6), gravity=(), flow=Flow(scheme="corrected"))
    fluids = fluids_of(scene)
    stir(fluids, amount=0.05, speed=0.0)
    w = wall_count(fluids)
    gap, r, weights = pairs(fluids)
    before = fluids.state.x.numpy()[w:].copy()
    dense = weights[w:].sum(axis=1) >= 0.97 * fluids.model.operators.number_density
    fluids.step.pressure.surface.assign((~dense).astype(np.int32))
    fluids.step.time_step.displacement.assign([0.1 * L0])
    finished(fluids)
    moved = fluids.state.x.numpy()[w:] - before
    slope = np.einsum("nm,nmd->nd", (weights / r)[w:], gap[w:]) / fluids.model.operators.number_density
    shift = -SHIFT * 0.1 * L0 * slope
    length = np.linalg.norm(shift, axis=1)[:, None]
    shift *= np.minimum(1.0, LARGEST_SHIFT * L0 / length)
    still = ~moved.any(axis=1)
    np.testing.assert_allclose(moved[~still], shift[~still], atol=1e-12 * L0)
    beside = (weights[w:, w:] > 0.0) @ ~dense > 0
    np.testing.assert_array_equal(still, ~dense | beside)
    assert 0 < still.sum() < len(still)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_an_interval_takes_the_steps_that_its_fastest_particle_asks_for(precision: str, speed: float) -> None:
    """And ends at its time to the last bit, whatever the steps are."""
    flow = Flow(courant=0.25)
    fluids = fluids_of(scene_of(water([0.0, 0.0], [4 * L0, 4 * L0], velocity=(speed, 0.0)), flow=flow))
    limit = 0.25 * L0 / speed if speed else 0.05
    assert fluids.model.step_limit == pytest.approx(limit)
    for end in (0.1, 0.1 + 1.0 / 3.0):
        before = float(fluids.state.time.numpy()[0])
        assert fluids.advance(end) == np.ceil((end - before) / limit - 1e-6)
        assert fluids.state.time.numpy()[0] == end
    assert fluids.state.steps.numpy()[0] == sum(np.ceil(t / limit - 1e-6) for t in (0.1, 1.0 / 3.0))


def test_a_wall_that_moves_fast_shortens_the_steps() -> None:
    fluids = fluids_of(tank((8, 8)))
    w, u = wall_count(fluids), fluids.state.u.numpy()
    u[w // 2] = [30.0, 40.0]
    fluids.state.u.assign(u)
    fluids.step.time_step.set_target(1.0)
    fluids.step.set_time_step()
    assert fluids.step.time_step.dt.numpy()[0] == pytest.approx(0.2 * L0 / 50.0, rel=1e-3)


def test_a_step_that_is_given_is_kept_below() -> None:
    scene = scene_of(water([0.0, 0.0], [4 * L0, 4 * L0]), time_step=1e-3)
    assert fluids_of(scene).advance(0.0205) == 21


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_particles_go_round_a_period(precision: str) -> None:
    """A body of water that fills a periodic box flows through it unhindered."""
    scene = periodic_box((14, 13))
    fluids = fluids_of(scene, precision=precision)
    start, size = fluids.readings.positions(), np.array([14, 13]) * L0
    velocity = np.array([1.3, -0.7])
    fluids.state.u.assign(np.broadcast_to(velocity, start.shape))
    fluids.advance(0.5)
    x = fluids.readings.positions()
    assert (x >= 0.0).all()
    assert (x <= size).all()
    expected = np.mod(start + 0.5 * velocity, size)
    gap = x - expected
    gap -= size * np.round(gap / size)
    np.testing.assert_allclose(gap, 0.0, atol=tolerance(precision, 1e-12, 1e-4) * size.max())
    np.testing.assert_allclose(fluids.velocities(), np.broadcast_to(velocity, x.shape), rtol=tolerance(precision))
    assert fluids.readings.lost() == 0


def test_what_leaves_the_domain_is_lost_and_stays_where_it_left() -> None:
    """The rest goes on as if it had never been there."""
    flow = Flow(domain=([-0.5, -0.5], [0.5, 0.5]))
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0], liquid=Liquid(viscosity=0.0)), flow=flow))
    put(fluids, {0: ([0.49, 0.3], [3.0, 0.0]), 1: ([0.47, 0.3], [1.0, 0.0])})
    fluids.advance(0.02)
    assert fluids.readings.lost() == 1
    first = fluids.readings.positions()[0]
    assert first[0] > 0.5
    assert not fluids.velocities()[0].any()
    assert re.fullmatch(
        r"1 of 64 fluid particles have left the domain, as particle 0 .*: there is a leak", fluids.trouble() or ""
    )
    fluids.advance(0.025)
    np.testing.assert_array_equal(fluids.readings.positions()[0], first)
    assert not fluids.velocities()[0].any()
    # its neighbour went on alone
    np.testing.assert_allclose(fluids.velocities()[1], [1.0, 0.0], atol=1e-12)
    assert fluids.pressures()[0] == 0.0


def test_the_pressure_of_the_rest_does_not_move_what_is_lost() -> None:
    """Water whose uppermost row is thrown out of the domain, with the rows below it under pressure."""
    fluids = fluids_of(tank((8, 12), flow=Flow(domain=([-0.5, -0.5], [0.5, 12.0 * L0]))))
    upper = fluids.readings.positions()[:, 1] > 11.0 * L0
    upper[: wall_count(fluids)] = False
    u = fluids.velocities()
    u[upper] = [0.0, 5.0]
    fluids.state.u.assign(u)
    fluids.advance(3e-3)
    assert fluids.readings.lost() == upper.sum() == 8
    first = fluids.readings.positions()
    for k in range(4, 30):
        fluids.advance(k * 1e-3)
        np.testing.assert_array_equal(fluids.readings.positions()[upper], first[upper])
        assert not fluids.velocities()[upper].any()
    # as deep as what is left
    pressure = fluids.pressures()[wall_count(fluids) :].max() / (1000.0 * 9.81 * L0)
    assert 9.5 < pressure < 12.0


def test_the_work_of_walls_that_drag_the_water_along() -> None:
    """What sliding walls without slip do by viscosity is what the water gains, at first."""
    fluids = fluids_of(tank((8, 8), wall={"slip": "no"}, fluid={"liquid": VISCOUS}, gravity=()))
    w, u = wall_count(fluids), fluids.state.u.numpy()
    u[:w] = [0.0, 0.7]
    fluids.state.u.assign(u)
    predicted(fluids)
    impulse, work = fluids.state.impulse.numpy(), fluids.state.work.numpy()
    assert impulse[:, 1].min() < 0.0
    np.testing.assert_allclose(work, -0.7 * impulse[:, 1], rtol=1e-12)
    assert total_momentum(fluids)[1] == pytest.approx(-impulse[:, 1].sum())

"""Pressure forces against NumPy, and what fluid and walls give to each other."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import (
    KINDS,
    L0,
    SCHEMES,
    fluids_of,
    pairs,
    periodic_box,
    slopes,
    small,
    stir,
    tank,
    tolerance,
    wall_count,
)  # fmt: skip
from warp_mps.fluid.fluids import Fluids
from warp_mps.scene import Flow

DT = 1e-4
RHO = 1000.0
# of a few spacings of water, so that nothing moves by more than a small part of a spacing
PRESSURE = 1000.0


def find_planes(fluids: Fluids) -> np.ndarray:
    """Let the fluids find the faces of walls beside them; depths, shape [m]."""
    fluids.step.pressure.find_planes()
    depth: np.ndarray = fluids.step.pressure.depth.numpy()
    return depth


def pushed(fluids: Fluids, p: np.ndarray) -> np.ndarray:
    """Change of the fluid's velocities by pressures over DT, shape [m, d]; nothing collides."""
    fluids.step.time_step.dt.assign([DT])
    fluids.state.p.assign(p)
    w = wall_count(fluids)
    before = fluids.state.u.numpy().astype(float)[w:]
    fluids.step.forces.find_slopes()
    fluids.step.correct()
    fluids.step.collide()
    fluids.step.advance_clock()
    assert not fluids.step.velocity_change.numpy().any()
    return fluids.state.u.numpy().astype(float)[w:] - before


def along(fluids: Fluids, gap: np.ndarray, c: np.ndarray, p: np.ndarray, g: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Slopes along walls of what pressures differ by from those of water at rest, shape [m, d]."""
    w, normal, depth = (
        wall_count(fluids),
        fluids.step.pressure.normal.numpy().astype(float),
        fluids.step.pressure.depth.numpy().astype(float),
    )
    slope = np.zeros_like(normal)
    for k in np.flatnonzero(depth > 0.0):
        tangential = np.eye(gap.shape[2]) - np.outer(normal[k], normal[k])
        rest = RHO * (c[k, :w] @ (g - a[:w])) / c[k, :w].sum()
        pull = c[k, w:] * (p - p[k] - gap[k, w:] @ rest) @ gap[k, w:]
        spread = np.einsum("m,md,me->de", c[k, w:], gap[k, w:], gap[k, w:])
        slope[k] = tangential @ pull / (np.trace(tangential @ spread) / (gap.shape[2] - 1))
    return slope


def expected_push(fluids: Fluids, p: np.ndarray, gravity: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Change of the fluid's velocities, and the impulses on the walls, as the module's text has them."""
    w, scheme = wall_count(fluids), SCHEMES[fluids.model.scheme]
    gap, r, weights = pairs(fluids)
    gap, c = gap[w:], slopes(fluids, r, weights)[w:]
    scale = fluids.step.pressure.density_scale.numpy().astype(float)
    scales = np.broadcast_to(np.concatenate((np.zeros(w), scale)), c.shape).copy()
    scales[:, :w] = scale[:, None]
    even = 0.5 * (scales + scale[:, None])
    p_j = np.broadcast_to(np.concatenate((np.zeros(w), p)), weights[w:].shape).copy()
    p_j[:, :w] = p[:, None] + RHO * np.einsum("nmd,md->nm", gap[:, :w], gravity - a[:w])
    if fluids.model.clip:
        p_j[:, :w] = np.maximum(p_j[:, :w], 0.0)
    near = weights[w:, w:] > 0.0
    least = np.minimum(p, np.where(near, p[None, :], np.inf).min(axis=1))
    total, difference = p[:, None] + p_j, p_j - p[:, None]
    pair_of = {
        "conservative": np.where(total >= 0.0, total, difference),
        "corrected": difference,
        "koshizuka_oka": p_j - least[:, None],
    }
    slope = along(fluids, gap, c, p, gravity, a)
    step = np.zeros_like(p_j)
    step[:, :w] = np.einsum("nmd,nd->nm", gap[:, :w], slope)
    pair_of["conservative"] = pair_of["conservative"] + step
    forces = -(c * (even if scheme == "conservative" else 1.0) * pair_of[scheme])[..., None] * gap
    walls = (c * even)[:, :w] * pair_of["conservative"][:, :w]
    impulse = DT * L0 ** gap.shape[2] * (walls[..., None] * gap[:, :w]).sum(axis=0)
    if scheme == "corrected":
        moments = np.einsum("nm,nmd,nme->nde", c, gap, gap)
        turns = np.array([np.linalg.inv(m) if np.linalg.det(m) > 0.1 else np.eye(len(m)) for m in moments])
        forces = np.einsum("nde,nme->nmd", turns, forces)
    return DT / RHO * forces.sum(axis=1), impulse


@pytest.mark.parametrize("negative", ["clipped", "allowed"])
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_forces_are_those_of_numpy(dimension: int, precision: str, scheme: str, negative: str) -> None:
    """Of any pressures, in a tank whose walls accelerate."""
    scene = tank(small(dimension), flow=Flow(scheme=scheme, negative_pressure=negative))
    fluids = fluids_of(scene, precision=precision)
    stir(fluids, amount=0.05, speed=0.0)
    w, rng = wall_count(fluids), np.random.default_rng(5)
    a = fluids.state.a.numpy().astype(float)
    a[:w] = rng.uniform(-5.0, 5.0, a[:w].shape)
    fluids.state.a.assign(a)
    p = PRESSURE * rng.uniform(0.0 if fluids.model.clip else -1.0, 1.0, len(a) - w)
    fluids.step.pressure.density_scale.assign(rng.uniform(0.94, 1.06, len(p)))
    assert (find_planes(fluids) > 0.0).any() == (scheme == "conservative")
    du, impulse = expected_push(fluids, p, np.asarray(scene.gravity), a)
    near = tolerance(precision, 1e-11, 1e-4)
    np.testing.assert_allclose(pushed(fluids, p), du, atol=near * np.abs(du).max())
    np.testing.assert_allclose(fluids.state.impulse.numpy(), impulse, atol=near * np.abs(impulse).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_the_fluid_gains_the_walls_lose(dimension: int) -> None:
    """Of the conservative scheme, to rounding; the particles among themselves keep it as well."""
    fluids = fluids_of(tank(small(dimension)))
    stir(fluids, amount=0.05)
    assert (find_planes(fluids) > 0.0).any()
    p = PRESSURE * np.random.default_rng(1).uniform(0.0, 1.0, len(fluids.state.p))
    gained = RHO * L0**dimension * pushed(fluids, p)
    impulse = fluids.state.impulse.numpy()
    assert np.abs(gained.sum(axis=0) + impulse.sum(axis=0)).max() < 1e-14 * np.abs(gained).sum()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_force_on_a_wall_is_its_pressure(scheme: str) -> None:
    """Whatever the scheme: under a uniform pressure p a floor of length b bears p b."""
    fluids = fluids_of(tank((12, 8), lid=True, gravity=(), flow=Flow(scheme=scheme)))
    pushed(fluids, np.full(len(fluids.state.p), PRESSURE))
    x, impulse = fluids.state.x.numpy()[: wall_count(fluids)], fluids.state.impulse.numpy() / DT
    middle = np.abs(x[:, 0] - 6 * L0) < 2 * L0
    np.testing.assert_allclose(impulse[middle & (x[:, 1] < 0.0)].sum(axis=0), [0.0, -4 * L0 * PRESSURE], atol=1e-9)
    np.testing.assert_allclose(impulse[middle & (x[:, 1] > 0.0)].sum(axis=0), [0.0, 4 * L0 * PRESSURE], atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_corrected_gradient_of_a_linear_pressure_is_exact(dimension: int) -> None:
    """Wherever the particles lie, up to the row below the surface; walls at rest continue the pressure's slope."""
    scene = tank(small(dimension), flow=Flow(scheme="corrected", negative_pressure="allowed"))
    fluids = fluids_of(scene)
    stir(fluids, amount=0.2, speed=0.0)
    w = wall_count(fluids)
    gravity = np.asarray(scene.gravity)
    p = RHO * fluids.state.x.numpy()[w:] @ gravity
    fluids.step.time_step.dt.assign([1e-9])
    fluids.state.p.assign(p)
    before = fluids.state.u.numpy()[w:].copy()
    fluids.step.correct()
    fluids.step.collide()
    fluids.step.advance_clock()
    inside = fluids.state.x.numpy()[w:, 1] < fluids.state.x.numpy()[w:, 1].max() - 0.6 * L0
    du = fluids.state.u.numpy()[w:] - before
    np.testing.assert_allclose(du[inside] / 1e-9, np.broadcast_to(-gravity, du[inside].shape), atol=1e-7)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_no_force_under_a_uniform_pressure_on_the_lattice(scheme: str) -> None:
    fluids = fluids_of(periodic_box((14, 13), flow=Flow(scheme=scheme)))
    du = pushed(fluids, np.full(len(fluids.state.p), PRESSURE))
    assert np.abs(du).max() < 1e-12 * DT / RHO * PRESSURE / L0


def test_two_particles_are_pushed_apart_along_their_line() -> None:
    """By hand, and whatever lies far off."""
    fluids = fluids_of(tank((8, 8)))
    w, x = wall_count(fluids), fluids.state.x.numpy()
    ops = fluids.model.operators
    x[w], x[w + 1] = [0.1, 0.4], [0.1 + 1.2 * L0, 0.4 + 0.9 * L0]
    fluids.state.x.assign(x)
    fluids.step.renew_neighbours()
    p = np.zeros(len(fluids.state.p))
    p[0], p[1] = 300.0, 500.0
    du = pushed(fluids, p)[:2]
    r = 1.5 * L0
    size = DT / RHO * ops.gradient * (1.0 - r / ops.radius) ** 3 * r / ops.radius**2 * 800.0
    np.testing.assert_allclose(du[0], -size * np.array([0.8, 0.6]), rtol=1e-9)
    np.testing.assert_allclose(du[1], size * np.array([0.8, 0.6]), rtol=1e-9)


def test_the_work_of_a_wall_is_its_impulse_along_its_way() -> None:
    fluids = fluids_of(tank(small(2)))
    w = wall_count(fluids)
    u = fluids.state.u.numpy()
    u[:w] = np.random.default_rng(2).uniform(-1.0, 1.0, (w, 2))
    fluids.state.u.assign(u)
    fluids.step.time_step.dt.assign([DT])
    fluids.state.p.assign(np.full(len(fluids.state.p), PRESSURE))
    fluids.step.correct()
    fluids.step.collide()
    fluids.step.advance_clock()
    impulse, work = fluids.state.impulse.numpy(), fluids.state.work.numpy()
    assert np.abs(impulse).max() > 0.0
    np.testing.assert_allclose(work, -(impulse * u[:w]).sum(axis=1), atol=1e-12 * np.abs(work).max())


def test_what_walls_show_is_the_pressure_of_the_water_beside_them() -> None:
    fluids = fluids_of(tank((8, 8), lid=True, flow=Flow(negative_pressure="allowed")))
    w = wall_count(fluids)
    gravity = np.array([0.0, -9.81])
    fluids.state.p.assign(RHO * fluids.state.x.numpy()[w:] @ gravity)
    shown = fluids.pressures()
    x = fluids.readings.positions()
    beside = (fluids.step.neighbours.count.numpy() > 0) & (
        np.linalg.norm(x - np.clip(x, 0.0, 8 * L0), axis=1) < 2.0 * L0
    )
    assert beside[:w].sum() > 40
    np.testing.assert_allclose(shown[beside], RHO * (x @ gravity)[beside], atol=1e-9 * np.abs(shown).max())


def test_walls_above_the_water_show_no_pressure() -> None:
    """And none shows less than 0 where pressures are clipped."""
    fluids = fluids_of(tank((8, 8), room=(8, 16)))
    fluids.state.p.assign(RHO * 9.81 * (8 * L0 - fluids.state.x.numpy()[wall_count(fluids) :, 1]))
    shown, y = fluids.pressures(), fluids.readings.positions()[:, 1]
    assert shown.min() == 0.0
    beside = shown[: wall_count(fluids)]
    assert beside[y[: wall_count(fluids)] > 10.5 * L0].max() == 0.0
    assert beside.max() > RHO * 9.81 * 8.0 * L0

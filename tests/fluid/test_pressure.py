"""The pressure Poisson equation: its rows against NumPy, the free surface, and closed domains."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import KINDS, L0, SCHEMES, fluids_of, pairs, periodic_box, slopes, small, stir, tank, tolerance
from tests.fluid.scenes import wall_count as walls_of
from warp_mps.fluid.fluids import Fluids
from warp_mps.fluid.pressure import (
    DAMPING,
    LARGEST_ERROR,
    LARGEST_SCALE,
    ORIGINAL_SHARE,
    SURFACE_DENSITY,
    SURFACE_NEIGHBOURS,
)
from warp_mps.scene import Flow, HarmonicMotion

DT = 1e-3
RHO = 1000.0
SHAKEN = {"motion": HarmonicMotion(amplitude=(0.0, 0.0), frequency=1.0)}


def assembled(fluids: Fluids) -> Fluids:
    """The fluids after a solve over DT, their state otherwise as it was."""
    fluids._dt.assign([DT])
    fluids._assemble()
    fluids._project()
    return fluids


def dense(fluids: Fluids) -> tuple[np.ndarray, np.ndarray]:
    """Entries off the diagonal with their sign turned, shape [m, m], and the diagonal."""
    matrix = fluids._matrix
    first, count = matrix.first.numpy(), matrix.count.numpy()
    index, value = matrix.index.numpy(), matrix.value.numpy()
    entries = np.zeros((len(first), len(first)))
    for row, (start, length) in enumerate(zip(first, count, strict=True)):
        assert len(set(index[start : start + length].tolist())) == length
        entries[row, index[start : start + length]] = value[start : start + length]
    return entries, matrix.diagonal.numpy().astype(float)


def source(fluids: Fluids, e: np.ndarray, div: np.ndarray) -> np.ndarray:
    """Source of -lap p per density, as the module's text has it."""
    if fluids._scheme == SCHEMES.index("koshizuka_oka"):
        return ORIGINAL_SHARE * e / DT**2
    e = np.clip(e, -LARGEST_ERROR, LARGEST_ERROR)
    return -(1.0 + np.abs(e)) * div / DT + np.abs(div) * e / DT + e / (fluids._relaxation * DT)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_rows_are_those_of_numpy(dimension: int, precision: str, scheme: str) -> None:
    """Of a stirred tank whose walls accelerate."""
    scene = tank(small(dimension), flow=Flow(scheme=scheme))
    fluids = fluids_of(scene, precision=precision)
    stir(fluids, amount=0.15)
    w, rng, ops = walls_of(fluids), np.random.default_rng(3), fluids.operators
    wall_u, wall_a = rng.uniform(-1.0, 1.0, (2, w, dimension))
    u, a = fluids.state.u.numpy(), fluids.state.a.numpy()
    u[:w], a[:w] = wall_u, 5.0 * wall_a
    fluids.state.u.assign(u)
    fluids.state.a.assign(a)
    fluids.state.carried.assign(rng.uniform(0.0, 1.0, len(u) - w))
    before = rng.uniform(0.0, 100.0, len(u) - w)
    fluids.state.p.assign(before)
    assembled(fluids)

    gap, r, weights = pairs(fluids)
    gap, r, weights = gap[w:], r[w:], weights[w:]
    entries, diagonal = dense(fluids)
    near = tolerance(precision, 1e-10, 2e-5)
    np.testing.assert_allclose(fluids.state.n.numpy(), weights.sum(axis=1), rtol=near)
    np.testing.assert_allclose(entries, ops.laplacian * weights[:, w:], rtol=10 * near, atol=near * ops.laplacian)
    c = slopes(fluids, np.where(weights > 0.0, r, 1.0), weights)
    uneven = np.einsum("nm,nmd->nd", c, gap)
    damping = (scheme == "conservative") * DAMPING * (uneven**2).sum(axis=1)
    np.testing.assert_allclose(diagonal, ops.laplacian * weights[:, w:].sum(axis=1) + damping, rtol=10 * near)
    scale = np.clip(dimension / (c * r**2).sum(axis=1), 1.0 - LARGEST_SCALE, 1.0 + LARGEST_SCALE)
    # the bounds are numbers of single precision
    np.testing.assert_allclose(fluids._scale.numpy(), scale, rtol=max(near, 1e-7))

    gravity = np.asarray(scene.gravity, float)
    free = u.astype(float)
    free[:w] += DT * (gravity - a[:w])
    pull = np.einsum("nmd,nmd->nm", gap, free[None, :] - free[w:, None]) * (weights > 0.0) / r**3
    e = weights.sum(axis=1) / ops.number_density - 1.0
    slope = np.einsum("nmd,md->nm", gap[:, :w], gravity - a[:w])
    rhs = RHO * source(fluids, e, ops.divergence * pull.sum(axis=1))
    rhs += RHO * ops.laplacian * (weights[:, :w] * slope).sum(axis=1)
    few = (weights > 0.0).sum(axis=1) < SURFACE_NEIGHBOURS * ops.neighbours
    surface = (e + 1.0 < SURFACE_DENSITY) & few
    load = 0.5 * L0 * RHO * 9.81 * fluids.state.carried.numpy()
    rhs += damping * np.where(surface, load, before)
    np.testing.assert_allclose(fluids._rhs.numpy(), rhs, rtol=near, atol=2.0 * near * np.abs(rhs).max())
    np.testing.assert_array_equal(fluids._matrix.active.numpy(), ~surface)
    assert 0 < surface.sum() < len(surface)
    np.testing.assert_allclose(fluids.state.p.numpy()[surface], load[surface], rtol=near)


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_the_solution_satisfies_the_rows(dimension: int, precision: str) -> None:
    flow = Flow(negative_pressure="allowed", tolerance=1e-5)
    fluids = fluids_of(tank(small(dimension), flow=flow), precision=precision)
    stir(fluids, amount=0.1)
    assembled(fluids)
    entries, diagonal = dense(fluids)
    active, p, rhs = fluids._matrix.active.numpy() == 1, fluids.state.p.numpy(), fluids._rhs.numpy()
    residual = (rhs - (diagonal * p - entries @ p))[active]
    surface_part = entries[np.ix_(active, ~active)] @ p[~active]
    assert np.linalg.norm(residual) < 2e-5 * np.linalg.norm(rhs[active] + surface_part)
    assert p[active].min() < 0.0
    done = fluids.statistics()
    assert (done.solves, done.stagnated + done.exhausted) == (1, 0)


def test_negative_pressures_are_clipped_or_kept() -> None:
    found = {}
    for choice in ("clipped", "allowed"):
        fluids = fluids_of(tank(flow=Flow(negative_pressure=choice)))
        stir(fluids, amount=0.1)
        found[choice] = assembled(fluids).state.p.numpy()
    assert found["allowed"].min() < 0.0
    np.testing.assert_array_equal(found["clipped"], np.maximum(found["allowed"], 0.0))


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_of_the_surface(dimension: int) -> None:
    """The upper row of a tank, and none that has two rows above it, beside the walls or not."""
    fluids = assembled(fluids_of(tank(small(dimension))))
    height = fluids.state.x.numpy()[walls_of(fluids) :, 1]
    rows_above = np.round((height.max() - height) / L0)
    surface = fluids._matrix.active.numpy() == 0
    assert surface[rows_above == 0].all()
    assert not surface[rows_above >= 2].any()


def test_a_drop_far_away_is_of_the_surface_and_has_no_pressure() -> None:
    fluids = fluids_of(tank((8, 4)))
    x, w = fluids.state.x.numpy(), walls_of(fluids)
    x[w] = [0.05, 0.4]
    fluids.state.x.assign(x)
    fluids.lists.renew(fluids.state.x, fluids.state.lost)
    assembled(fluids)
    assert fluids._matrix.active.numpy()[0] == 0
    assert fluids.state.p.numpy()[0] == 0.0
    assert fluids.state.n.numpy()[0] == 0.0


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_in_a_closed_domain_the_least_pressure_is_0(precision: str) -> None:
    """There only differences of pressure are known: the equation has a solution all the same."""
    fluids = fluids_of(periodic_box((14, 13), flow=Flow(tolerance=1e-6)), precision=precision)
    stir(fluids, amount=0.1)
    assembled(fluids)
    entries, diagonal = dense(fluids)
    p, rhs = fluids.state.p.numpy(), fluids._rhs.numpy()
    assert p.min() == 0.0
    assert fluids._matrix.active.numpy().all()
    # up to a constant, which the damping of changes sees
    residual = rhs - rhs.mean() - (diagonal * p - entries @ p)
    constant = diagonal - entries.sum(axis=1)
    residual -= constant * (constant @ residual) / (constant @ constant)
    assert np.linalg.norm(residual) < 5e-6 * np.linalg.norm(rhs - rhs.mean())


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_water_that_fills_a_tank_has_the_pressure_of_its_depth(dimension: int, precision: str) -> None:
    """On the lattice, where the Laplacian of a linear field is exact, walls and all."""
    scene = tank(small(dimension), lid=True, flow=Flow(tolerance=1e-9 if precision == "float64" else 1e-5))
    fluids = fluids_of(scene, precision=precision)
    u = fluids.state.u.numpy()
    u[walls_of(fluids) :, 1] = -DT * 9.81
    fluids.state.u.assign(u)
    assembled(fluids)
    assert fluids._matrix.singular.numpy()[0] == 1
    height = fluids.state.x.numpy()[walls_of(fluids) :, 1]
    depth = height.max() - height
    np.testing.assert_allclose(
        fluids.state.p.numpy(), RHO * 9.81 * depth, atol=tolerance(precision, 1e-8, 1e-3) * RHO * 9.81 * depth.max()
    )


def test_a_tank_that_accelerates_leans_the_pressure() -> None:
    """Isobars stand across g - a: the walls' acceleration is that of the water's frame."""
    scene = tank((8, 8), lid=True, flow=Flow(tolerance=1e-9), wall=SHAKEN)
    fluids = fluids_of(scene)
    w = walls_of(fluids)
    a, u = fluids.state.a.numpy(), fluids.state.u.numpy()
    a[:w] = [3.0, 0.0]
    # after the step the walls have the speed that their acceleration gives them
    u[:w], u[w:] = DT * a[:w], [0.0, -DT * 9.81]
    fluids.state.a.assign(a)
    fluids.state.u.assign(u)
    assembled(fluids)
    x = fluids.state.x.numpy()[w:]
    expected = RHO * (x @ [-3.0, -9.81])
    found = fluids.state.p.numpy()
    np.testing.assert_allclose(found - found.mean(), expected - expected.mean(), atol=1e-6 * np.ptp(expected))


@pytest.mark.parametrize(("scale", "sign"), [(1.0, 0), (0.98, 1), (1.02, -1)])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_source_restores_the_density(scheme: str, scale: float, sign: int) -> None:
    """Inside water at rest it pushes apart what is too dense, and draws together what is too thin."""
    fluids = fluids_of(tank((14, 14), flow=Flow(scheme=scheme)))
    x = fluids.state.x.numpy()
    middle = int(np.argmin(np.linalg.norm(x - 0.5 * 14 * L0, axis=1)))
    x[:] = x[middle] + scale * (x - x[middle])
    fluids.state.x.assign(x)
    fluids.lists.renew(fluids.state.x, fluids.state.lost)
    rhs = assembled(fluids)._rhs.numpy()[middle - walls_of(fluids)]
    unit = RHO / (DT * fluids._relaxation)
    assert np.sign(rhs if abs(rhs) > 1e-9 * unit else 0.0) == sign


def test_a_closed_tank_that_has_lost_a_particle_is_still_closed() -> None:
    fluids = fluids_of(tank((12, 12), lid=True, flow=Flow(tolerance=1e-6)))
    stir(fluids, amount=0.05)
    lost = fluids.state.lost.numpy()
    lost[walls_of(fluids) + 5] = 1
    fluids.state.lost.assign(lost)
    fluids.lists.renew(fluids.state.x, fluids.state.lost)
    assembled(fluids)
    done = fluids.statistics()
    assert done.stagnated + done.exhausted == 0
    assert done.worst_residual < 1e-6
    assert fluids.state.p.numpy().min() == 0.0

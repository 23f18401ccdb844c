"""The exchange between water and markers: its matrix and its right-hand side against dense products."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.coupling.scenes import bed, hung, lump, pool, system_of
from tests.fluid.scenes import KINDS, L0, pairs, stir, tolerance
from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.coupling.water import WetFluids

RHO, DT = 1000.0, 1e-3


PLACES = {"hung": hung, "bed": bed}


def stirred(dimension: int, precision: str, *, ratio: int = 1, place: str = "hung") -> WetFluids:
    """Water that is stirred about a block, with its equation assembled, and mobilities of all kinds."""
    system = system_of(PLACES[place](dimension, ratio=ratio), precision=precision)
    water = system.water
    stir(water)
    water._dt.assign([DT])
    water._assemble()
    inputs = [water._walls, water._markers.count, *water._listed()]
    water._launch(water._coupling.find_wet, water._m, inputs, [water._wet])
    rng = np.random.default_rng(1)
    free = 1.0 / water._markers.masses
    water.mobility.array.assign(rng.uniform(0.1, 1.0, len(free)) * free)
    return water


def arms(water: WetFluids) -> np.ndarray:
    """C (x_ij - tilt_i) from fluid particles to markers, shape [m, markers, d]."""
    gap, _, weights = pairs(water)
    w, e = water._walls, water._markers.count
    arm = gap[w:, :e] - water._tilt.numpy().astype(float)[:, None]
    return water.operators.laplacian * weights[w:, :e, None] * arm


def answers(water: WetFluids) -> np.ndarray:
    """What the markers' answer adds to the matrix, shape [m, m]."""
    c, b = arms(water), water.mobility.array.numpy().astype(float)
    return RHO * water._volume * np.einsum("j,kjd,ljd->kl", b, c, c)


def doubles(values: Any) -> wp.array:
    return wp.array(np.asarray(values, float), dtype=wp.float64, device="cpu")


def product(water: WetFluids, p: np.ndarray, *, fresh: bool) -> np.ndarray:
    """What is added to a product with the matrix, less its diagonal part."""
    q, other = doubles(np.zeros(len(p))), doubles(np.full(len(p), np.nan))
    control = wp.full(CONTROLS, int(fresh), dtype=wp.int32, device="cpu")
    both = (doubles(p), other) if fresh else (other, doubles(p))
    water._rest(control, *both, q)
    return q.numpy()


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_products_are_those_of_the_dense_matrix(dimension: int, precision: str, place: str) -> None:
    water = stirred(dimension, precision, place=place)
    assert water._tilt.numpy()[water._wet.numpy() == 1].any() or place == "hung"
    dense, near = answers(water), tolerance(precision)
    before = water._matrix.diagonal.numpy().astype(float)
    water._stiffen()
    after = water._matrix.diagonal.numpy().astype(float)
    scale = np.abs(dense).max()
    np.testing.assert_allclose(after - before, np.diag(dense), atol=near * np.abs(after).max())
    np.testing.assert_allclose(
        water._own.numpy()[np.diag(dense) > 0.0], np.diag(dense)[np.diag(dense) > 0.0], rtol=near
    )
    rest = dense - np.diag(np.diag(dense))
    rng = np.random.default_rng(2)
    for fresh in (True, False):
        p = rng.uniform(-1.0, 1.0, len(dense))
        found = product(water, p, fresh=fresh)
        np.testing.assert_allclose(found, rest @ p, atol=10.0 * near * scale)
    assert np.linalg.matrix_rank(dense) > water._markers.count or place == "bed"


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_answer_is_symmetric_and_takes_no_energy_from_nowhere(dimension: int, place: str) -> None:
    """As the device has it, column by column: eigenvalues are not negative, and dry rows are empty."""
    water = stirred(dimension, "float64", place=place)
    water._own.zero_()
    water._stiffen()
    m, own = water._m, water._own.numpy()
    matrix = np.array([product(water, unit, fresh=True) for unit in np.eye(m)]) + np.diag(own)
    scale = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * scale)
    assert np.linalg.eigvalsh(matrix).min() > -1e-12 * scale
    wet = np.abs(arms(water)).sum(axis=(1, 2)) > 0.0
    assert 0 < wet.sum() < m
    assert np.abs(matrix[wet]).max(axis=1).min() > 0.0
    assert not matrix[~wet].any()


@pytest.mark.parametrize(("place", "ratio"), [("hung", 1), ("hung", 2), ("bed", 2)])
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_right_hand_side_and_forces(dimension: int, precision: str, place: str, ratio: int) -> None:
    """-rho sum_j c (a_j - b_j F_j) . x_ij about markers that accelerate, and F = V sum_l c p_l x_lj on them."""
    water = stirred(dimension, precision, ratio=ratio, place=place)
    rng, near, e, c = np.random.default_rng(3), tolerance(precision), water._markers.count, arms(water)
    p, force, a = rng.uniform(size=water._m), rng.normal(size=(e, dimension)), rng.normal(size=(e, dimension))
    out = wp.zeros_like(water._approximate)
    water._respond(water._fresh, doubles(p), doubles(np.full(len(p), np.nan)), out)
    expected = water._volume * np.einsum("kjd,k->jd", c, p)
    np.testing.assert_allclose(out.numpy(), expected, atol=10.0 * near * np.abs(expected).max())
    water._about.assign(force)
    accelerations = np.concatenate((a, np.zeros((len(water.state.x) - e, dimension))))
    water.state.a.assign(accelerations)
    water._launch(water._coupling.answer, e, [water.mobility.array, water._about, water.state.a], [water._answer])
    rhs = doubles(np.zeros(water._m))
    head = [water._walls, e, *water._geometry(), water._density, *water._listed(), water._wet]
    water._launch(water._coupling.couple, water._m, [*head, water.state.x, water._tilt, water._answer], [rhs])
    left = water.mobility.array.numpy()[:, None] * force - a
    expected = RHO * np.einsum("kjd,jd->k", c, left)
    np.testing.assert_allclose(rhs.numpy(), expected, atol=10.0 * near * np.abs(expected).max())


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_markers_that_accelerate_are_walls_that_do(dimension: int, place: str) -> None:
    """Their part of the right-hand side is what a wall with their accelerations would have there."""
    water = stirred(dimension, "float64", place=place)
    e = water._markers.count
    still = water._rhs.numpy().copy()
    a = np.zeros(water.state.x.numpy().shape)
    a[:e] = np.random.default_rng(4).normal(size=(e, dimension))
    water.state.a.assign(a)
    # as a wall, u* of which is h (g - a): the pressure alone makes its velocity
    u = water.state.u.numpy()
    u[:e] += DT * a[:e]
    water.state.u.assign(u)
    water._assemble()
    as_wall = water._rhs.numpy().copy()
    water._about.zero_()
    water._launch(water._coupling.answer, e, [water.mobility.array, water._about, water.state.a], [water._answer])
    rhs = doubles(still)
    head = [water._walls, e, *water._geometry(), water._density, *water._listed(), water._wet]
    water._launch(water._coupling.couple, water._m, [*head, water.state.x, water._tilt, water._answer], [rhs])
    assert np.abs(rhs.numpy() - still).max() > 1e-3 * np.abs(still).max()
    np.testing.assert_allclose(rhs.numpy(), as_wall, atol=1e-9 * np.abs(still).max())


def test_approximate_forces_carry_the_pressure() -> None:
    """The force of a uniform pressure on a flat face is the pressure, in the equation's approximation as in the step's.

    They need not agree marker by marker: what the equation answers for is gone where all agrees.
    """
    system = system_of(pool(lump([0, 0], [14, 4]), cells=(14, 12)))
    water, e = system.water, system._markers.count
    water._dt.assign([DT])
    water._assemble()
    pressure = 3000.0
    water.state.p.fill_(pressure)
    water._respond(water._fresh, water.state.p, water.state.p, water._approximate)
    water._pressed.zero_()
    gravity, water._gravity = water._gravity, type(water._gravity)()
    water._push_walls(e, water._one, [water._pressed, water._spare])
    water._gravity = gravity
    x = water.state.x.numpy()[:e]
    middle = np.abs(x[:, 0] - 7 * L0) < 2 * L0
    for forces in (water._approximate.numpy(), water._pressed.numpy()):
        assert -forces[middle, 1].sum() == pytest.approx(pressure * 4 * L0, rel=0.05)
        assert abs(forces[middle, 0].sum()) < 1e-9 * pressure * L0

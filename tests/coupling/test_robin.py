"""The Robin term of the markers: its matrix and its right-hand side against dense products."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.coupling.scenes import bed, hung, lump, pool, system_of
from tests.fluid.scenes import KINDS, L0, pairs, stir, tolerance
from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.coupling.hydroelastic import Hydroelastic

RHO, DT = 1000.0, 1e-3


PLACES = {"hung": hung, "bed": bed}


def stirred(dimension: int, precision: str, *, ratio: int = 1, place: str = "hung") -> Hydroelastic:
    """Water that is stirred about a block, with its equation assembled, and mobilities of all kinds."""
    system = system_of(PLACES[place](dimension, ratio=ratio), precision=precision)
    stir(system.fluids)
    assemble(system)
    system.step.passes.robin.begin()
    rng = np.random.default_rng(1)
    free = 1.0 / system.markers.masses
    system.step.mobility.array.assign(rng.uniform(0.1, 1.0, len(free)) * free)
    return system


def assemble(system: Hydroelastic) -> None:
    """Assemble the pressure Poisson equation of a time step."""
    system.fluids.step.time_step.dt.assign([DT])
    system.fluids.step.assemble()


def arms(system: Hydroelastic) -> np.ndarray:
    """C (x_ij - tilt_i) from fluid particles to markers, shape [m, markers, d]."""
    gap, _, weights = pairs(system.fluids)
    w, e = system.fluids.model.walls, system.markers.count
    arm = gap[w:, :e] - system.fluids.step.pressure.tilt.numpy().astype(float)[:, None]
    return system.fluids.model.operators.laplacian * weights[w:, :e, None] * arm


def answers(system: Hydroelastic) -> np.ndarray:
    """What the Robin term adds to the matrix, shape [m, m]."""
    c, b = arms(system), system.step.mobility.array.numpy().astype(float)
    return RHO * system.fluids.model.volume * np.einsum("j,kjd,ljd->kl", b, c, c)


def doubles(values: Any) -> wp.array:
    return wp.array(np.asarray(values, float), dtype=wp.float64, device="cpu")


def product(system: Hydroelastic, p: np.ndarray, *, fresh: bool) -> np.ndarray:
    """The addition to a product with the matrix, less its diagonal part."""
    q, other = doubles(np.zeros(len(p))), doubles(np.full(len(p), np.nan))
    control = wp.full(CONTROLS, int(fresh), dtype=wp.int32, device="cpu")
    both = (doubles(p), other) if fresh else (other, doubles(p))
    system.step.passes.robin.multiply(control, *both, q)
    return q.numpy()


@pytest.mark.long
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_products_are_those_of_the_dense_matrix(dimension: int, precision: str, place: str) -> None:
    system = stirred(dimension, precision, place=place)
    pressure, robin = system.fluids.step.pressure, system.step.passes.robin
    assert pressure.tilt.numpy()[robin.wet.numpy() == 1].any() or place == "hung"
    dense, near = answers(system), tolerance(precision)
    before = pressure.matrix.diagonal.numpy().astype(float)
    robin.add_to_diagonal()
    after = pressure.matrix.diagonal.numpy().astype(float)
    scale = np.abs(dense).max()
    np.testing.assert_allclose(after - before, np.diag(dense), atol=near * np.abs(after).max())
    np.testing.assert_allclose(
        robin.diagonal.numpy()[np.diag(dense) > 0.0], np.diag(dense)[np.diag(dense) > 0.0], rtol=near
    )
    rest = dense - np.diag(np.diag(dense))
    rng = np.random.default_rng(2)
    for fresh in (True, False):
        p = rng.uniform(-1.0, 1.0, len(dense))
        found = product(system, p, fresh=fresh)
        np.testing.assert_allclose(found, rest @ p, atol=10.0 * near * scale)
    assert np.linalg.matrix_rank(dense) > system.markers.count or place == "bed"


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_robin_term_is_symmetric_and_positive(dimension: int, place: str) -> None:
    """As the device has it, column by column: eigenvalues are not negative, and dry rows are empty."""
    system = stirred(dimension, "float64", place=place)
    robin = system.step.passes.robin
    robin.diagonal.zero_()
    robin.add_to_diagonal()
    m, own = system.fluids.model.count, robin.diagonal.numpy()
    matrix = np.array([product(system, unit, fresh=True) for unit in np.eye(m)]) + np.diag(own)
    scale = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * scale)
    assert np.linalg.eigvalsh(matrix).min() > -1e-12 * scale
    wet = np.abs(arms(system)).sum(axis=(1, 2)) > 0.0
    assert 0 < wet.sum() < m
    assert np.abs(matrix[wet]).max(axis=1).min() > 0.0
    assert not matrix[~wet].any()


@pytest.mark.parametrize(("place", "ratio"), [("hung", 1), ("hung", 2), ("bed", 2)])
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_right_hand_side_and_forces(dimension: int, precision: str, place: str, ratio: int) -> None:
    """-rho sum_j c (a_j - b_j F_j) . x_ij about markers that accelerate, and F = V sum_l c p_l x_lj on them."""
    system = stirred(dimension, precision, ratio=ratio, place=place)
    rng, near, e, c = np.random.default_rng(3), tolerance(precision), system.markers.count, arms(system)
    m, state, robin = system.fluids.model.count, system.fluids.state, system.step.passes.robin
    p, force, a = rng.uniform(size=m), rng.normal(size=(e, dimension)), rng.normal(size=(e, dimension))
    expected = system.fluids.model.volume * np.einsum("kjd,k->jd", c, p)
    np.testing.assert_allclose(robin.forces_of(p), expected, atol=10.0 * near * np.abs(expected).max())
    robin.linearization.assign(force)
    state.a.assign(np.concatenate((a, np.zeros((len(state.x) - e, dimension)))))
    rhs = doubles(np.zeros(m))
    robin.add_to_rhs(rhs)
    left = system.step.mobility.array.numpy()[:, None] * force - a
    expected = RHO * np.einsum("kjd,jd->k", c, left)
    np.testing.assert_allclose(rhs.numpy(), expected, atol=10.0 * near * np.abs(expected).max())


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_markers_that_accelerate_are_walls_that_do(dimension: int, place: str) -> None:
    """Their part of the right-hand side is what a wall with their accelerations would have there."""
    system = stirred(dimension, "float64", place=place)
    e, state, pressure, robin = (
        system.markers.count,
        system.fluids.state,
        system.fluids.step.pressure,
        system.step.passes.robin,
    )
    still = pressure.rhs.numpy().copy()
    a = np.zeros(state.x.numpy().shape)
    a[:e] = np.random.default_rng(4).normal(size=(e, dimension))
    state.a.assign(a)
    # as a wall, u* of which is h (g - a): the pressure alone makes its velocity
    u = state.u.numpy()
    u[:e] += DT * a[:e]
    state.u.assign(u)
    assemble(system)
    as_wall = pressure.rhs.numpy().copy()
    robin.linearization.zero_()
    rhs = doubles(still)
    robin.add_to_rhs(rhs)
    assert np.abs(rhs.numpy() - still).max() > 1e-3 * np.abs(still).max()
    np.testing.assert_allclose(rhs.numpy(), as_wall, atol=1e-9 * np.abs(still).max())


def test_approximate_forces_carry_the_pressure() -> None:
    """The force of a uniform pressure on a flat face is the pressure, in the equation's approximation as in the step's.

    They need not agree marker by marker: the term is gone where the passes have converged.
    """
    system = system_of(pool(lump([0, 0], [14, 4]), cells=(14, 12), gravity=(0.0, 0.0)))
    fluid, e = system.fluids.step, system.markers.count
    robin, forces = system.step.passes.robin, system.step.passes.pressure_force
    assemble(system)
    pressure = 3000.0
    fluid.state.p.fill_(pressure)
    robin.find_forces(fluid.state.p)
    work = wp.zeros(e, dtype=wp.float64, device="cpu")
    fluid.forces.add_wall_impulse(e, wp.ones(1, dtype=wp.float64, device="cpu"), forces, work)
    x = fluid.state.x.numpy()[:e]
    middle = np.abs(x[:, 0] - 7 * L0) < 2 * L0
    for found in (robin.forces.numpy(), forces.numpy()):
        assert -found[middle, 1].sum() == pytest.approx(pressure * 4 * L0, rel=0.05)
        assert abs(found[middle, 0].sum()) < 1e-9 * pressure * L0

"""The tangent of the Hamiltonian model against differences of its forces, and its blocks against itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.elastic.hamiltonian.test_control import compressed
from tests.elastic.hamiltonian.test_kernels import PLANES, irregular, strained_state
from tests.elastic.states import Strained, strain
from tests.scenes import random
from warp_mps.core.types import numeric_types
from warp_mps.elastic.implicit.tangent_operator import Tangent
from warp_mps.scene import LAWS

every_law = pytest.mark.parametrize("law", LAWS)
every_plane = pytest.mark.parametrize(("dimension", "plane"), PLANES)


def tangent(held: Strained, *, inertia: float = 0.0, fixed: Any = None, precision: str = "float64") -> Tangent:
    n, d = held.particles.positions.shape
    numbers = numeric_types(d, precision)
    mass = wp.array(held.particles.masses, dtype=numbers.real, device="cpu")
    factor = wp.array([inertia], dtype=wp.float64, device="cpu")
    fixed = np.zeros((n, d), bool) if fixed is None else fixed
    return Tangent(held.model, held.state.u, mass, fixed, factor, types=numbers, device="cpu")


def dense(operator: Tangent, size: int) -> np.ndarray:
    """The operator as a matrix, a column for each direction."""
    columns, q = [], wp.zeros(size, dtype=wp.float64, device="cpu")
    for direction in np.eye(size):
        operator.multiply(wp.array(direction, dtype=wp.float64, device="cpu"), q)
        columns.append(q.numpy().copy())
    return np.stack(columns, axis=1)


def states(held: Strained) -> list[np.ndarray]:
    """A state with random strains, and one that is compressed to where the control grows."""
    return [strained_state(held), compressed(held)]


@pytest.mark.parametrize("nu", [0.3, 0.49])
@every_law
@every_plane
def test_product_is_the_change_of_the_forces(dimension: int, plane: str, law: str, nu: float) -> None:
    held = strain(irregular(dimension, plane=plane, law=law, nu=nu))
    for u in states(held):
        matrix = dense(tangent(held.put(u)), u.size)
        change, step = np.empty_like(matrix), 1e-7
        for column, direction in enumerate(np.eye(u.size)):
            ends = [held.put(u + sign * step * direction.reshape(u.shape)).forces for sign in (1.0, -1.0)]
            change[:, column] = (ends[1] - ends[0]).ravel() / (2 * step)
        np.testing.assert_allclose(matrix, change, atol=2e-8 * np.abs(matrix).max())


@pytest.mark.parametrize("nu", [0.3, 0.49])
@every_law
@every_plane
def test_tangent_is_symmetric(dimension: int, plane: str, law: str, nu: float) -> None:
    held = strain(irregular(dimension, plane=plane, law=law, nu=nu))
    for u in states(held):
        matrix = dense(tangent(held.put(u), inertia=3.0e5), u.size)
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-14 * np.abs(matrix).max())


@every_plane
def test_inertia_adds_the_masses(dimension: int, plane: str) -> None:
    held = strain(irregular(dimension, plane=plane))
    u = strained_state(held)
    held.put(u)
    added = dense(tangent(held, inertia=3.0e5), u.size) - dense(tangent(held), u.size)
    expected = np.diag(np.repeat(3.0e5 * held.particles.masses, dimension))
    np.testing.assert_allclose(added, expected, atol=1e-9 * expected.max())


@every_law
@every_plane
def test_at_rest_the_blocks_are_those_of_the_tangent(dimension: int, plane: str, law: str) -> None:
    held = strain(irregular(dimension, plane=plane, law=law))
    n, d = held.particles.positions.shape
    held.put(np.zeros((n, d)))
    operator = tangent(held, inertia=3.0e5)
    operator.prepare(operator.operator, None)
    matrix = dense(operator, n * d).reshape(n, d, n, d)
    expected = np.stack([matrix[i, :, i, :] for i in range(n)])
    np.testing.assert_allclose(operator.block.numpy(), expected, atol=1e-13 * np.abs(expected).max())


@every_plane
def test_blocks_of_an_incompressible_material_are_nearly_those_of_the_tangent(dimension: int, plane: str) -> None:
    """Their eigenvalues are within a factor of 3: they count a share of lambda in place of its means."""
    held = strain(irregular(dimension, plane=plane, nu=0.49))
    n, d = held.particles.positions.shape
    held.put(np.zeros((n, d)))
    operator = tangent(held)
    operator.prepare(operator.operator, None)
    matrix = dense(operator, n * d).reshape(n, d, n, d)
    for i in range(n):
        ratios = np.linalg.eigvals(np.linalg.solve(matrix[i, :, i, :], operator.block.numpy()[i])).real
        assert 1 / 3 < ratios.min() <= ratios.max() < 3


@every_law
def test_blocks_are_positive_and_inverted_among_free_axes(law: str) -> None:
    """In any state; with all axes free, one held, and all held."""
    held = strain(irregular(3, law=law))
    held.put(strained_state(held, 0.5))
    n, d = held.particles.positions.shape
    fixed = np.zeros((n, d), bool)
    fixed[1, 0] = fixed[2] = True
    operator = tangent(held, fixed=fixed)
    operator.prepare(operator.operator, None)
    blocks = operator.block.numpy()
    assert np.linalg.eigvalsh(blocks).min() > 0.0
    r = random(n, d) * ~fixed
    z = wp.zeros(n * d, dtype=wp.float64, device="cpu")
    operator.apply(wp.array(r.ravel(), dtype=wp.float64, device="cpu"), z)
    found = z.numpy().reshape(n, d)
    np.testing.assert_allclose(found[0], np.linalg.solve(blocks[0], r[0]))
    np.testing.assert_allclose(found[1], [0.0, *np.linalg.solve(blocks[1][1:, 1:], r[1, 1:])])
    assert (found[2] == 0.0).all()


@every_law
@every_plane
def test_single_precision_gives_the_same_product(dimension: int, plane: str, law: str) -> None:
    products = []
    for precision in ("float64", "float32"):
        held = strain(irregular(dimension, plane=plane, law=law), precision)
        u = strained_state(held) - 0.1
        direction = wp.array(random(u.size, seed=9), dtype=wp.float64, device="cpu")
        q = wp.zeros(u.size, dtype=wp.float64, device="cpu")
        tangent(held.put(u), precision=precision).multiply(direction, q)
        products.append(q.numpy())
    np.testing.assert_allclose(products[1], products[0], atol=2e-5 * np.abs(products[0]).max())

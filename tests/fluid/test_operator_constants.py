"""The operators: exact on a full lattice for the fields that they are scaled by."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.core.weights import weight
from warp_mps.fluid.operator_constants import Operators, operators

L0 = 0.02
CASES = [(dimension, radius) for dimension in (2, 3) for radius in (2.1, 3.1)]


def offsets(dimension: int, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x_ij, r and w of the neighbours on a full lattice."""
    line = np.arange(-4, 5) * L0
    x = np.stack(np.meshgrid(*[line] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    r = np.linalg.norm(x, axis=1)
    near = (r > 0.0) & (r < radius * L0)
    return x[near], r[near], weight(r[near], radius * L0)


@pytest.mark.parametrize(("dimension", "radius"), CASES)
def test_what_a_full_lattice_holds(dimension: int, radius: float) -> None:
    ops = operators(dimension, L0, radius)
    _, r, w = offsets(dimension, radius)
    assert ops.neighbours == len(r) == {(2, 2.1): 12, (2, 3.1): 28, (3, 2.1): 32, (3, 3.1): 122}[dimension, radius]
    assert ops.radius == pytest.approx(radius * L0)
    assert ops.number_density == pytest.approx(w.sum())
    assert ops.smooth_density == pytest.approx(1.0 + np.sum((1.0 - (r / ops.radius) ** 2) ** 4))


@pytest.mark.parametrize(("dimension", "radius"), CASES)
def test_the_divergence_of_every_linear_velocity_is_exact_but_for_its_shear(dimension: int, radius: float) -> None:
    """It is the trace of the velocity gradient: shear and rotation give none."""
    ops = operators(dimension, L0, radius)
    x, r, _ = offsets(dimension, radius)
    gradient = np.random.default_rng(1).uniform(-1.0, 1.0, (dimension, dimension))
    found = ops.divergence * np.sum(np.sum(x * (x @ gradient.T), axis=1) / r**3)
    assert found == pytest.approx(np.trace(gradient), abs=1e-12)
    assert ops.divergence * np.sum(1.0 / r) == pytest.approx(dimension)


@pytest.mark.parametrize(("dimension", "radius"), CASES)
def test_the_laplacian_of_every_quadratic_is_exact(dimension: int, radius: float) -> None:
    ops = operators(dimension, L0, radius)
    x, _, w = offsets(dimension, radius)
    hessian = np.random.default_rng(2).uniform(-1.0, 1.0, (dimension, dimension))
    slope = np.arange(1.0, dimension + 1.0)
    difference = x @ slope + 0.5 * np.einsum("ni,ij,nj->n", x, hessian, x)
    assert ops.laplacian * np.sum(w * difference) == pytest.approx(np.trace(hessian), abs=1e-10)


@pytest.mark.parametrize(("dimension", "radius"), CASES)
def test_the_gradient_of_every_linear_field_is_exact(dimension: int, radius: float) -> None:
    ops = operators(dimension, L0, radius)
    x, r, w = offsets(dimension, radius)
    slope = np.arange(1.0, dimension + 1.0)
    smooth = (1.0 - r / ops.radius) ** 3 / ops.radius**2
    np.testing.assert_allclose(ops.gradient * ((smooth * (x @ slope)) @ x), slope, rtol=1e-12)
    np.testing.assert_allclose(ops.original_gradient * ((w * (x @ slope) / r**2) @ x), slope, rtol=1e-12)


def test_factors_scale_with_the_spacing() -> None:
    one, two = operators(2, 1.0, 3.1), operators(2, 2.0, 3.1)
    assert two == Operators(
        radius=2.0 * one.radius, number_density=one.number_density,
        smooth_density=one.smooth_density, neighbours=one.neighbours,
        divergence=2.0 * one.divergence, laplacian=0.25 * one.laplacian, gradient=one.gradient,
        original_gradient=one.original_gradient, beyond=one.beyond,
    )  # fmt: skip


@pytest.mark.parametrize("rows", [1, 2])
@pytest.mark.parametrize(("dimension", "radius"), CASES)
def test_what_lies_beyond_a_surface_makes_a_linear_pressure_exact(dimension: int, radius: float, rows: int) -> None:
    """In the two rows below it, the sum over the neighbours and the part added to the diagonal cancel."""
    ops = operators(dimension, L0, radius)
    x, _, w = offsets(dimension, radius)
    depth = (rows - 0.5) * L0
    there = x[:, 1] < depth
    missing = 1.0 - w[there].sum() / ops.number_density
    beyond = ops.number_density * missing * (ops.beyond[0] + ops.beyond[1] * missing)
    change = np.sum(w[there] * -x[there, 1])
    assert beyond * depth == pytest.approx(change, rel=1e-9)
    assert min(ops.beyond) > 0.0

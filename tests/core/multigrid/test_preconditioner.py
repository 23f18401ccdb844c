"""The multigrid preconditioner: few iterations whatever the size, and an inverse that conjugate gradients may use."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
import warp as wp

from tests.core.linear.systems import System, laplacian, on_device
from warp_mps.core.device import open_device
from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Statistics
from warp_mps.core.multigrid.cell_kernels import cell_kernels
from warp_mps.core.multigrid.particle_kernels import particle_kernels
from warp_mps.core.multigrid.preconditioner import SCALE, MultigridPreconditioner, declare_kernels
from warp_mps.core.types import numeric_types


@pytest.fixture(autouse=True)
def device() -> Any:
    return open_device("cpu")


def vector(values: np.ndarray) -> wp.array:
    return wp.array(values, dtype=wp.float64, device="cpu")


def make_multigrid(
    system: System, *, reach: float = 2.1, margin: float = 0.0, spare: int = 0, periodic: tuple[int, ...] = ()
) -> MultigridPreconditioner:
    """On a domain that is larger than the particles' box by a margin on all sides."""
    d = system.positions.shape[1]
    numbers = numeric_types(d)
    positions = np.vstack((system.positions, np.full((spare, d), np.nan)))
    low, high = np.floor(system.positions.min(axis=0)) - margin, np.ceil(system.positions.max(axis=0)) + margin
    points = wp.array(positions, dtype=numbers.vec, device="cpu")
    return MultigridPreconditioner(
        points, low=low, high=high, reach=reach, types=numbers, device="cpu", periodic=periodic
    )


def solve(
    system: System,
    preconditioner: MultigridPreconditioner | None,
    *,
    spare: int = 0,
    singular: bool | None = None,
    **options: Any,
) -> tuple[np.ndarray, Statistics]:
    """Solution and statistics of one solve, from zero."""
    n, numbers = system.n + spare, numeric_types(system.positions.shape[1])
    solver = ConjugateGradient(n, types=numbers, device="cpu", preconditioner=preconditioner, **options)
    x = vector(np.zeros(n))
    b = vector(np.append(system.b, np.full(spare, np.nan)))
    solver.solve(on_device(system, spare=spare, singular=singular), b, x)
    return x.numpy()[: system.n], solver.read_statistics()


def as_matrix(multigrid: MultigridPreconditioner, system: System) -> np.ndarray:
    """The preconditioner's part P V P^T, between all rows."""
    matrix = on_device(system)
    inverse = vector(np.where(system.active != 0, 1.0 / system.diagonal, 0.0))
    multigrid.prepare(matrix, inverse)
    columns = []
    for unit in np.eye(system.n):
        z = vector(np.zeros(system.n))
        multigrid.apply(vector(unit), z)
        columns.append(z.numpy())
    return np.array(columns).T


CASES = {
    "tank": ((120, 15), 2.1, 0.0),
    "column": ((50, 60), 3.1, 0.0),
    "box": ((14, 13, 12), 2.1, 0.0),
    "box, wide reach": ((14, 10, 12), 3.1, 0.0),
    "scattered surface": ((60, 60), 3.1, 0.02),
}


@pytest.mark.parametrize("name", CASES)
def test_few_iterations_to_the_solution(name: str) -> None:
    shape, reach, scatter = CASES[name]
    system = laplacian(shape, reach=reach, scatter=scatter)
    x, statistics = solve(system, make_multigrid(system, reach=reach), tolerance=1e-8)
    exact = scipy.sparse.linalg.spsolve(system.inner, system.b[system.unknowns])
    np.testing.assert_allclose(x[system.unknowns], exact, rtol=0, atol=1e-6 * np.abs(exact).max())
    _, jacobi = solve(system, None, tolerance=1e-8)
    assert statistics.iterations <= min(22, 0.5 * jacobi.iterations)
    assert statistics.last_residual <= 1e-8


def test_iterations_do_not_grow_with_the_unknowns() -> None:
    small, large = laplacian((25, 25)), laplacian((150, 150))
    _, few = solve(small, make_multigrid(small))
    _, many = solve(large, make_multigrid(large))
    assert many.iterations <= few.iterations + 3


PERIODIC = {
    "both axes": ((50, 50), (0, 1), 3.1),
    "odd numbers of cells": ((47, 34), (0, 1), 2.1),
    "one axis": ((60, 31), (1,), 2.1),
    "few cells": ((7, 40), (0,), 3.1),
    "space, one axis": ((14, 13, 12), (1,), 2.1),
    "space, all axes": ((12, 14, 11), (0, 1, 2), 2.1),
}


@pytest.mark.parametrize("name", PERIODIC)
def test_a_period_costs_no_iterations(name: str) -> None:
    """Within two of the closed box, where cells that end at the period take half as many again and more."""
    shape, periodic, reach = PERIODIC[name]
    system = laplacian(shape, reach=reach, surface=False, periodic=periodic)
    closed = laplacian(shape, reach=reach, surface=False)
    multigrid = make_multigrid(system, reach=reach, periodic=periodic)
    x, statistics = solve(system, multigrid, singular=True)
    _, expected = solve(closed, make_multigrid(closed, reach=reach), singular=True)
    _, unaware = solve(system, make_multigrid(system, reach=reach), singular=True)
    assert statistics.iterations <= expected.iterations + 2
    assert unaware.iterations > 1.5 * statistics.iterations
    assert system.residual(x) <= 1.01e-6
    np.testing.assert_array_equal(solve(system, multigrid, singular=True)[0], x)


def test_positions_beyond_a_period_are_those_within() -> None:
    system = laplacian((30, 26), surface=False, periodic=(0, 1))
    expected, statistics = solve(system, make_multigrid(system, periodic=(0, 1)), singular=True)
    multigrid = make_multigrid(system, periodic=(0, 1))
    multigrid.positions.assign(system.positions + np.random.default_rng(3).integers(-1, 2, (system.n, 2)) * (30, 26))
    x, beyond = solve(system, multigrid, singular=True)
    assert beyond.iterations == statistics.iterations
    np.testing.assert_allclose(x, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("shape", [(13, 11), (6, 5, 5)])
@pytest.mark.parametrize(("sign", "surface"), [(1.0, True), (-1.0, True), (0.0, True), (1.0, False)])
def test_it_is_symmetric_and_positive_whatever_the_matrix(
    shape: tuple[int, ...], sign: float, surface: bool, periodic: bool
) -> None:
    axes = tuple(range(len(shape))) if periodic else ()
    system = laplacian(shape, scatter=0.1 * surface, surface=surface, periodic=axes)
    weights = system.weights.copy()
    # with signs of their own where it is 0
    flips = np.random.default_rng(7).choice((-1.0, 1.0), size=(system.n, system.n))
    weights.data *= sign if sign else (flips * flips.T)[weights.nonzero()]
    turned = System(system.positions, weights, system.diagonal, system.active, system.b)
    multigrid = make_multigrid(system, periodic=axes)
    matrix = as_matrix(multigrid, turned)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * np.abs(matrix).max())
    eigenvalues = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
    assert eigenvalues.min() >= -1e-12 * eigenvalues.max()
    if sign:
        # as many directions as there are cells are corrected, but what does not follow its neighbours is left alone
        cells = np.sum(multigrid.levels[0].diagonal.numpy() > 0.0)
        assert np.sum(eigenvalues > 1e-6 * eigenvalues.max()) == (cells if sign > 0.0 else 0)
    np.testing.assert_array_equal(matrix[system.active == 0], 0.0)


@pytest.mark.parametrize("surface", [True, False])
@pytest.mark.parametrize(
    ("shape", "periodic"), [((11, 9), ()), ((11, 9, 8), ()), ((13, 11), (0, 1)), ((9, 8, 7), (2,))]
)
def test_matrix_of_the_cells_is_the_sum_of_the_entries_between_them(
    shape: tuple[int, ...], periodic: tuple[int, ...], surface: bool
) -> None:
    system = laplacian(shape, scatter=0.1 * surface, surface=surface, periodic=periodic)
    multigrid = make_multigrid(system, periodic=periodic)
    as_matrix(multigrid, system)
    level = multigrid.levels[0]
    dims = np.array([level.dims[axis] for axis in range(len(shape))])
    wraps = np.isin(np.arange(len(shape)), periodic)
    widths = np.where(wraps, np.array(shape) / dims, 2.1)
    low = np.where(wraps, 0.0, np.floor(system.positions.min(axis=0)))
    cells = np.clip(np.floor((system.positions - low) / widths), 0, dims - 1)
    cell = cells.astype(int) @ np.concatenate(([1], np.cumprod(dims)[:-1]))
    gather = scipy.sparse.csr_matrix((system.active, (np.arange(system.n), cell)), shape=(system.n, level.size))
    scale = SCALE * 2.1 / widths.min()
    couplings = (gather.T @ system.weights @ gather).toarray() * scale
    np.fill_diagonal(couplings, 0.0)
    coupled = system.weights @ system.active
    share = np.minimum(coupled / system.diagonal, 1.0)
    excess = gather.T @ (share * (system.diagonal - coupled)) * 2 * scale
    found = np.zeros_like(couplings)
    there = level.there.numpy().reshape(level.size, -1)
    np.add.at(found, (np.arange(level.size)[:, None], there), level.coupling.numpy().reshape(there.shape))
    np.testing.assert_allclose(found, couplings, atol=1e-12)
    np.testing.assert_allclose(level.excess.numpy(), excess, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_interpolation_is_linear_and_collecting_is_its_transpose(dimension: int) -> None:
    # no cell is empty: the last ones have particles for at least half of their width
    system = laplacian((14, 12, 10)[:dimension], surface=False)
    multigrid = make_multigrid(system)
    as_matrix(multigrid, system)
    level = multigrid.levels[0]
    dims = np.array([level.dims[axis] for axis in range(dimension)])
    axes = np.meshgrid(*[2.1 * (np.arange(length) + 0.5) for length in dims], indexing="ij")
    slope = np.array([2.0, -1.0, 0.5])[:dimension]
    field = sum(s * x for s, x in zip(slope, axes, strict=True)).ravel(order="F")
    z = vector(np.zeros(system.n))
    multigrid.prolongate(vector(field), z)
    inner = np.all((system.positions > 1.06) & (system.positions < 2.1 * dims - 1.06), axis=1)
    np.testing.assert_allclose(z.numpy()[inner], (system.positions @ slope)[inner], rtol=1e-12)

    r = np.random.default_rng(2).normal(size=system.n)
    multigrid.restrict(vector(r))
    assert level.r.numpy().sum() == pytest.approx(r.sum(), rel=1e-10)
    assert level.r.numpy() @ field == pytest.approx(r @ z.numpy(), rel=1e-10)


def test_rows_of_a_surface_cost_no_iterations() -> None:
    """Unknowns whose diagonals are several times their couplings, as those that a free surface makes nearly known."""
    system = laplacian((50, 40), surface=False)
    _, without = solve(system, make_multigrid(system), singular=True)
    diagonal = system.diagonal * np.where(system.positions[:, 1] > 39.0, 5.0, 1.0)
    surface = System(system.positions, system.weights, diagonal, system.active, system.b)
    x, statistics = solve(surface, make_multigrid(surface))
    assert statistics.iterations <= without.iterations + 1
    assert surface.residual(x) <= 1.01e-6


def test_singular_system() -> None:
    system = laplacian((40, 35), surface=False)
    shifted = System(system.positions, system.weights, system.diagonal, system.active, system.b + 0.3)
    x, statistics = solve(shifted, make_multigrid(system), singular=True, tolerance=1e-8)
    assert statistics.iterations <= 20
    assert system.residual(x) <= 1.01e-8


@pytest.mark.parametrize("margin", [-6.0, 0.7, 200.0])
def test_a_domain_that_does_not_fit_costs_iterations_only(margin: float) -> None:
    """Particles outside are kept at the edge; a nearly empty domain gets wider cells."""
    system = laplacian((40, 30))
    multigrid = make_multigrid(system, margin=margin)
    assert multigrid.levels[0].size <= system.n
    x, statistics = solve(system, multigrid, tolerance=1e-8)
    assert system.residual(x) <= 1.01e-8
    _, jacobi = solve(system, None, tolerance=1e-8)
    assert statistics.iterations < jacobi.iterations


def test_order_of_the_particles_does_not_matter() -> None:
    system = laplacian((40, 30))
    _, before = solve(system, make_multigrid(system))
    order = np.random.default_rng(0).permutation(system.n)
    weights = system.weights[order][:, order].tocsr()
    weights.sort_indices()
    shuffled = System(system.positions[order], weights, system.diagonal[order], system.active[order], system.b[order])
    _, after = solve(shuffled, make_multigrid(shuffled))
    assert abs(after.iterations - before.iterations) <= 1


def test_rows_beyond_the_count_do_not_matter() -> None:
    """Their positions are no numbers."""
    system = laplacian((30, 20))
    expected, _ = solve(system, make_multigrid(system))
    x, _ = solve(system, make_multigrid(system, spare=50), spare=50)
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_graph_and_eager_give_the_same_bits() -> None:
    system = laplacian((40, 30))
    expected, _ = solve(system, make_multigrid(system))
    solver = ConjugateGradient(system.n, types=numeric_types(2), device="cpu", preconditioner=make_multigrid(system))
    matrix, b, x = on_device(system), vector(system.b), vector(np.zeros(system.n))
    with wp.ScopedCapture(device="cpu") as capture:
        x.zero_()
        solver.solve(matrix, b, x)
    for _ in range(2):
        x.fill_(1.0)
        wp.capture_launch(capture.graph)
        np.testing.assert_array_equal(x.numpy(), expected)


@pytest.mark.long
@pytest.mark.parametrize("multigrid", [False, True])
def test_entries_in_single_precision_leave_the_solution_in_double(multigrid: bool) -> None:
    """The residual falls far below what single precision can tell apart."""
    system = laplacian((50, 40))
    # 24 bits are enough for these
    weights = system.weights.copy()
    weights.data = np.round(weights.data * 2**12) / 2**12
    diagonal = np.asarray(weights.sum(axis=1)).ravel()
    rounded = System(system.positions, weights, diagonal, system.active, system.b)
    numbers = numeric_types(2, "float32")
    points = wp.array(system.positions, dtype=numbers.vec, device="cpu")
    domain = {"low": np.zeros(2), "high": np.array((50.0, 40.0)), "reach": 2.1}
    preconditioner = MultigridPreconditioner(points, **domain, types=numbers, device="cpu") if multigrid else None
    solver = ConjugateGradient(system.n, types=numbers, device="cpu", tolerance=1e-11, preconditioner=preconditioner)
    x = vector(np.zeros(system.n))
    solver.solve(on_device(rounded, real=wp.float32), vector(system.b), x)
    assert solver.read_statistics().stagnated == 0
    assert rounded.residual(x.numpy()) <= 1.01e-11


def test_moving_particles_are_followed() -> None:
    """The same preconditioner at new positions is as good as one made for them."""
    system = laplacian((40, 30))
    multigrid = make_multigrid(system)
    solve(system, multigrid)
    mirrored = np.array((40.0, 0.0)) + system.positions * (-1.0, 1.0)
    turned = System(mirrored, system.weights, system.diagonal, system.active, system.b)
    multigrid.positions.assign(turned.positions)
    _, statistics = solve(turned, multigrid)
    _, expected = solve(turned, make_multigrid(turned))
    assert statistics.iterations == expected.iterations


@pytest.mark.long
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    for module in declare_kernels(numbers):
        wp.compile_aot_module(module, arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    for make in (particle_kernels, cell_kernels):
        names = vars(make(numbers))
        assert [name for name in names if f".entry {make.__name__}__locals__{name}_" not in code] == []

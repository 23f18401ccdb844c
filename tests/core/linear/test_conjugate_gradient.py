"""Conjugate gradients against SciPy's and Warp's own, and what a solve must leave alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg
import warp as wp
import warp.optim.linear
import warp.sparse

from tests.core.linear.systems import System, laplacian, on_device
from warp_mps.core.device import open_device
from warp_mps.core.linear.conjugate_gradient import ChunkSums, ConjugateGradient, Matrix, Operator, declare_kernels
from warp_mps.core.linear.kernels import solver_kernels
from warp_mps.core.linear.sum_kernels import CHUNK, sum_kernels
from warp_mps.core.types import numeric_types


@pytest.fixture(autouse=True)
def device() -> Any:
    return open_device("cpu")


def vector(values: np.ndarray) -> wp.array:
    return wp.array(values, dtype=wp.float64, device="cpu")


def make_solver(n: int, **options: Any) -> ConjugateGradient:
    return ConjugateGradient(n, types=numeric_types(2), device="cpu", **options)


def solve(
    system: System, *, x: np.ndarray | None = None, singular: bool | None = None, **options: Any
) -> tuple[np.ndarray, Any]:
    """Solution and statistics of one solve."""
    solver = make_solver(system.n, **options)
    guess = vector(np.zeros(system.n) if x is None else x)
    solver.solve(on_device(system, singular=singular), vector(system.b), guess)
    return guess.numpy(), solver.read_statistics()


SYSTEMS = {
    "tank": lambda: laplacian((60, 12)),
    "column, wide reach": lambda: laplacian((20, 40), reach=3.1),
    "box": lambda: laplacian((9, 8, 7)),
    "scattered surface": lambda: laplacian((30, 30), scatter=0.2),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_solution_is_that_of_a_direct_solver(name: str) -> None:
    system = SYSTEMS[name]()
    x, statistics = solve(system, tolerance=1e-12)
    exact = np.zeros(system.n)
    exact[system.unknowns] = scipy.sparse.linalg.spsolve(system.inner, system.b[system.unknowns])
    np.testing.assert_allclose(x, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert statistics.stagnated == statistics.exhausted == 0


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-10])
def test_reported_residual_is_the_true_one(tolerance: float) -> None:
    system = laplacian((50, 20))
    x, statistics = solve(system, tolerance=tolerance)
    assert statistics.last_residual == pytest.approx(system.residual(x), rel=1e-3)
    assert system.residual(x) <= tolerance * (1 + 1e-6)
    assert statistics.worst_residual == statistics.last_residual


def test_an_operator_is_solved_as_its_matrix() -> None:
    """To the same bits: the solver uses its product alone."""
    system = laplacian((30, 30), scatter=0.2)
    matrix, kernels = on_device(system), solver_kernels(numeric_types(2))
    unknown = vector(system.active.astype(float))

    def multiply(control: wp.array, x: wp.array, p: wp.array, q: wp.array) -> None:
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, unknown]
        wp.launch(kernels.multiply, system.n, [*rows, control, x, p], [q], device="cpu")

    operator = Operator(matrix.rows, matrix.diagonal, matrix.active, multiply)
    # known values enter the rows of the unknowns
    start = np.where(system.active != 0, 0.0, np.cos(np.arange(system.n)))
    solutions = []
    for kind in (matrix, operator):
        x = vector(start)
        make_solver(system.n, tolerance=1e-8).solve(kind, vector(system.b), x)
        solutions.append(x.numpy())
    assert (solutions[0] == solutions[1]).all()
    assert system.residual(solutions[1]) < 1e-8 * 100
    assert np.abs(solutions[1]).max() > 0.0


def test_as_many_iterations_as_scipy() -> None:
    system = laplacian((50, 20))
    inverse = scipy.sparse.diags(1.0 / system.inner.diagonal())
    iterates: list[Any] = []
    b = system.b[system.unknowns]
    scipy.sparse.linalg.cg(system.inner, b, rtol=1e-6, atol=0.0, M=inverse, callback=iterates.append)
    _, statistics = solve(system, tolerance=1e-6)
    assert statistics.last_iterations == len(iterates)


@pytest.mark.long
def test_as_many_iterations_as_warp() -> None:
    system = laplacian((20, 10))
    inner = system.inner.tocoo()
    n = inner.shape[0]
    entries = [wp.array(part, dtype=wp.int32, device="cpu") for part in (inner.row, inner.col)]
    matrix = warp.sparse.bsr_from_triplets(n, n, *entries, vector(inner.data))
    # without the offsets of a batch Warp's dots take hundreds of times longer on a CPU
    offsets = wp.array([0, n], dtype=wp.int32, device="cpu")
    operator = warp.optim.linear.aslinearoperator(matrix, batch_offsets=offsets)
    diagonal = warp.optim.linear.preconditioner(matrix, "diag")
    x = vector(np.zeros(n))
    iterations, _, _ = warp.optim.linear.cg(
        operator, vector(system.b[system.unknowns]), x, tol=1e-8, M=diagonal, check_every=1
    )
    ours, statistics = solve(system, tolerance=1e-8)
    assert abs(statistics.last_iterations - iterations) <= 1
    np.testing.assert_allclose(ours[system.unknowns], x.numpy(), rtol=0, atol=1e-6 * np.abs(ours).max())


def test_a_solution_as_the_guess_takes_no_iteration_and_is_kept() -> None:
    system = laplacian((30, 20))
    x, _ = solve(system, tolerance=1e-8)
    again, statistics = solve(system, x=x, tolerance=1e-8)
    assert statistics.last_iterations == 0
    np.testing.assert_array_equal(again, x)


def test_a_residual_that_is_nan_stays_the_worst() -> None:
    system = laplacian((12, 10))
    matrix = on_device(system)
    solver = make_solver(system.n, tolerance=1e-8)
    for b in (system.b, np.full(system.n, np.nan), system.b):
        solver.solve(matrix, vector(b), vector(np.zeros(system.n)))
    statistics = solver.read_statistics()
    assert statistics.last_residual < 1e-8
    assert np.isnan(statistics.worst_residual)
    assert solver.count_unsolved() == 1


def test_statistics_go_on_from_those_of_another() -> None:
    system = laplacian((12, 10))
    matrix = on_device(system)
    first, second = (make_solver(system.n, tolerance=1e-8) for _ in range(2))
    for solver in (first, first):
        solver.solve(matrix, vector(system.b), vector(np.zeros(system.n)))
    second.assign(first.statistics.numpy())
    second.solve(matrix, vector(system.b), vector(np.zeros(system.n)))
    statistics = second.read_statistics()
    assert (statistics.solves, statistics.iterations) == (3, 3 * statistics.last_iterations)


def test_a_near_guess_saves_iterations() -> None:
    system = laplacian((30, 20))
    x, cold = solve(system, tolerance=1e-6)
    _, warm = solve(system, x=x * (1 + 1e-4 * np.sin(np.arange(system.n))), tolerance=1e-6)
    assert 0 < warm.last_iterations < 0.7 * cold.last_iterations


def test_no_right_hand_side_has_no_solution_but_zero() -> None:
    system = laplacian((12, 10))
    nothing = System(system.positions, system.weights, system.diagonal, system.active, np.zeros(system.n))
    x, statistics = solve(nothing)
    assert statistics.last_iterations == 0
    assert statistics.last_residual == 0.0
    np.testing.assert_array_equal(x, 0.0)
    x, statistics = solve(nothing, x=np.ones(system.n) * system.active, tolerance=1e-9)
    assert statistics.last_residual <= 1e-9
    np.testing.assert_allclose(x, 0.0, atol=1e-7)


def test_a_residual_below_the_floor_is_left() -> None:
    system = laplacian((12, 10))
    x, statistics = solve(system, floor=1.01 * float(np.linalg.norm(system.b)))
    assert statistics.last_iterations == 0
    np.testing.assert_array_equal(x, 0.0)


def test_rows_that_are_no_unknowns_are_known_values() -> None:
    """A linear field on the boundary of a regular lattice is continued into it."""
    system = laplacian((16, 16), surface=False)
    inside = np.all(np.abs(system.positions - 8.0) < 6.0, axis=1)
    field = system.positions @ (2.0, -1.0)
    b = system.matrix @ field
    known = System(system.positions, system.weights, system.diagonal, inside.astype(np.int32), b)
    x, _ = solve(known, x=np.where(inside, 0.0, field), tolerance=1e-12)
    np.testing.assert_allclose(x, field, atol=1e-9)
    np.testing.assert_array_equal(x[~inside], field[~inside])


@pytest.mark.parametrize("flagged", [True, False])
def test_singular_system(flagged: bool) -> None:
    """A right-hand side that has a mean can only be met when the mean is taken out."""
    system = laplacian((24, 20), surface=False)
    shifted = System(system.positions, system.weights, system.diagonal, system.active, system.b + 0.3)
    x, statistics = solve(shifted, singular=flagged, tolerance=1e-9, max_iterations=500)
    if flagged:
        assert statistics.last_residual <= 1e-9
        assert system.residual(x) <= 1.01e-9
        assert abs(x.mean()) < 1e-12 * np.abs(x).max()
    else:
        assert statistics.last_residual > 0.01
        assert statistics.stagnated + statistics.exhausted == 1


def test_a_consistent_singular_system_needs_no_flag() -> None:
    system = laplacian((24, 20), surface=False)
    x, statistics = solve(system, tolerance=1e-9)
    assert statistics.last_residual <= 1e-9
    assert system.residual(x) <= 1.01e-9


def test_rows_beyond_the_count_are_untouched() -> None:
    system = laplacian((14, 12))
    expected, _ = solve(system)
    spare = 2 * CHUNK + 5
    solver = make_solver(system.n + spare)
    beyond = np.full(spare, np.nan)
    x = vector(np.append(np.zeros(system.n), beyond))
    solver.solve(on_device(system, spare=spare), vector(np.append(system.b, beyond)), x)
    np.testing.assert_array_equal(x.numpy()[: system.n], expected)
    np.testing.assert_array_equal(x.numpy()[system.n :], beyond)


def test_a_system_can_shrink_and_grow_between_solves() -> None:
    """Nothing of a solve, not even of one that failed, is left to the next."""
    system, small = laplacian((14, 12)), laplacian((9, 9))
    expected, _ = solve(system)
    solver = make_solver(system.n)
    broken = vector(np.full(system.n, np.nan))
    matrix = on_device(system)
    solver.solve(matrix, broken, vector(np.zeros(system.n)))
    assert solver.read_statistics().stagnated == 1
    assert np.isnan(solver.read_statistics().worst_residual)
    spare = system.n - small.n
    solver.solve(on_device(small, spare=spare), vector(np.append(small.b, np.zeros(spare))), vector(np.zeros(system.n)))
    x = vector(np.zeros(system.n))
    solver.solve(matrix, vector(system.b), x)
    np.testing.assert_array_equal(x.numpy(), expected)


def test_graph_and_eager_give_the_same_bits() -> None:
    system = laplacian((40, 30))
    expected, once = solve(system)
    solver, matrix = make_solver(system.n), on_device(system)
    b, x = vector(system.b), vector(np.zeros(system.n))
    with wp.ScopedCapture(device="cpu") as capture:
        x.zero_()
        solver.solve(matrix, b, x)
    for _ in range(2):
        x.fill_(1.0)
        wp.capture_launch(capture.graph)
        np.testing.assert_array_equal(x.numpy(), expected)
    statistics = solver.read_statistics()
    assert statistics.solves == 2
    assert statistics.iterations == 2 * once.iterations
    assert statistics.most_iterations == once.iterations


def test_too_few_iterations_are_flagged() -> None:
    system = laplacian((30, 20))
    x, statistics = solve(system, max_iterations=7)
    assert (statistics.last_iterations, statistics.exhausted, statistics.stagnated) == (7, 1, 0)
    assert statistics.last_residual == pytest.approx(system.residual(x), rel=1e-9)


def test_a_tolerance_below_the_rounding_error_is_flagged_and_ends() -> None:
    system = laplacian((30, 20))
    x, statistics = solve(system, tolerance=1e-30)
    assert (statistics.exhausted, statistics.stagnated) == (0, 1)
    assert statistics.last_iterations < 1000
    assert system.residual(x) < 1e-12


def test_the_worst_row_is_where_the_true_residual_is_largest() -> None:
    system = laplacian((30, 20))
    solver = make_solver(system.n, max_iterations=7)
    x = vector(np.zeros(system.n))
    solver.solve(on_device(system), vector(system.b), x)
    residual = np.abs(system.b - system.matrix @ x.numpy())
    assert solver.worst_row() == system.unknowns[np.argmax(residual[system.unknowns])]
    assert residual.max() > 0.0
    row, b = int(system.unknowns[77]), system.b.copy()
    b[row] = np.nan
    solver.solve(on_device(system), vector(b), x)
    assert solver.worst_row() == row


def test_an_indefinite_matrix_is_flagged() -> None:
    system = laplacian((10, 10))
    indefinite = System(system.positions, 3.0 * system.weights, system.diagonal, system.active, system.b)
    _, statistics = solve(indefinite, max_iterations=300)
    assert statistics.stagnated == 1
    assert statistics.last_residual > 1e-6


@pytest.mark.parametrize("n", [0, 1])
def test_tiny_systems(n: int) -> None:
    solver = make_solver(n)
    none = wp.empty(0, dtype=wp.int32, device="cpu")
    ones = wp.ones(n, dtype=wp.int32, device="cpu")
    zeros = wp.zeros(n, dtype=wp.int32, device="cpu")
    rows = wp.array([n], dtype=wp.int32, device="cpu")
    matrix = Matrix(rows, zeros, zeros, none, vector(np.empty(0)), vector(np.full(n, 4.0)), ones)
    x = vector(np.zeros(n))
    solver.solve(matrix, vector(np.full(n, 6.0)), x)
    np.testing.assert_array_equal(x.numpy(), np.full(n, 1.5))
    assert solver.read_statistics().last_iterations == n


def test_an_unknown_without_neighbours_is_left_out() -> None:
    system = laplacian((10, 10))
    lonely = system.diagonal.copy()
    lonely[4] = 0.0
    alone = System(system.positions, system.weights, lonely, system.active, system.b)
    x, statistics = solve(alone, x=np.full(system.n, 0.25))
    assert x[4] == 0.25
    assert statistics.last_residual <= 1e-6


@pytest.mark.parametrize("n", [0, 1, CHUNK, CHUNK * CHUNK + 77])
def test_sums_of_chunks_leave_nothing_out(n: int) -> None:
    rng = np.random.default_rng(1)
    a, b, c = rng.integers(-9, 9, (3, n)).astype(float)
    sums = ChunkSums(n, types=numeric_types(2), device="cpu").launch(vector(a), vector(b), vector(c))
    np.testing.assert_array_equal(sums.numpy()[0], [a @ b, a @ c])


@pytest.mark.long
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_every_kernel_compiles_for_cuda(precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(2, precision)
    for module in declare_kernels(numbers):
        wp.compile_aot_module(module, arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    declared = [(made.__name__, name) for made in (solver_kernels, sum_kernels) for name in vars(made(numbers))]
    missing = [name for factory, name in declared if f".entry {factory}__locals__{name}_" not in code]
    assert missing == []

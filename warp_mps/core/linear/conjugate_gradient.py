"""The preconditioned conjugate gradient method on a device, without host synchronization.

The loop is `wp.capture_while`: a solve can be part of a captured graph, and gives the same bits outside of one. Dot
products are sums of fixed chunks, so that they do not depend on the schedule of the device.

References:
    Hestenes, M. R. and Stiefel, E., J. Res. Natl. Bur. Stand. 49 (1952) 409.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
import warp as wp

from warp_mps.core.counters import whole_numbers
from warp_mps.core.linear import kernels as names
from warp_mps.core.linear.kernels import METHOD, solver_kernels
from warp_mps.core.linear.sum_kernels import CHUNK, sum_kernels
from warp_mps.core.types import NumericTypes

MAX_RESTARTS = 4


class Matrix(NamedTuple):
    """A symmetric matrix in rows: (A x)_i = diagonal_i x_i - sum_k value_k x[index_k].

    Rows that are not active, without a positive diagonal or beyond `rows` are not unknowns: their x is a Dirichlet
    value, which stays as given and enters the rows of the unknowns.

    Attributes:
        rows: Number of rows in use, int32, shape [1].
        first: First entry of each row, int32, shape [capacity].
        count: Number of entries of each row, int32, shape [capacity].
        index: Column of each entry, int32, shape [entries].
        value: Entries off the diagonal, with their sign turned, shape [entries].
        diagonal: Entries of the diagonal, shape [capacity].
        active: 0 in rows that are not unknowns, int32, shape [capacity].
        singular: Not 0 if constants are in the null space, as in a closed domain without a free surface, int32,
            shape [1]. The means of the unknowns are then subtracted from b and x. None if that is excluded.
    """

    rows: wp.array
    first: wp.array
    count: wp.array
    index: wp.array
    value: wp.array
    diagonal: wp.array
    active: wp.array
    singular: wp.array | None = None


# launches of (control, x, p, q)
Product = Callable[[wp.array, wp.array, wp.array, wp.array], None]


class Operator(NamedTuple):
    """A symmetric matrix that is given by its product alone; its unknowns are those of a `Matrix`.

    Attributes:
        rows: Number of rows in use, int32, shape [1].
        diagonal: The diagonal, or a replacement that the preconditioner takes for it, shape [capacity].
        active: 0 in rows that are not unknowns, int32, shape [capacity].
        multiply: Launches q = A x in a restart pass (`control[RESTART]` not 0), else q = A p, from (control, x, p, q);
            only the rows of the unknowns count.
        singular: As that of a `Matrix`.
    """

    rows: wp.array
    diagonal: wp.array
    active: wp.array
    multiply: Product
    singular: wp.array | None = None


class Preconditioner(Protocol):
    """An approximate inverse, symmetric and positive, of the matrix."""

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Launch the setup for a new matrix.

        Args:
            matrix: The matrix, of the kind that the preconditioner supports: a `Matrix`, an `Operator` or either.
            inverse: Inverse of its diagonal, 0 in rows that are not unknowns, float64, shape [capacity].
        """

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Launch z = M^-1 r; z comes in as D^-1 r, and must stay 0 in rows that are not unknowns.

        Args:
            r: Residual, float64, shape [capacity].
            z: Preconditioned residual, float64, shape [capacity].
        """


class Jacobi:
    """The inverse of the diagonal, which the solver itself applies."""

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Nothing to launch."""

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Nothing to launch."""


@dataclass(frozen=True)
class Statistics:
    """Statistics of a solver since its start.

    Attributes:
        solves: Number of solves.
        iterations: Iterations of all solves together.
        most_iterations: Iterations of the longest.
        worst_residual: Largest true residual that a solve ended with, relative to b.
        stagnated: Solves that ended above the tolerance because the true residual no longer decreased.
        exhausted: Solves that ended above the tolerance because they reached the largest number of iterations.
        last_iterations: Iterations of the last solve.
        last_residual: True residual of the last solve, relative to b.
    """

    solves: int
    iterations: int
    most_iterations: int
    worst_residual: float
    stagnated: int
    exhausted: int
    last_iterations: int
    last_residual: float


class ConjugateGradient:
    """Solves A x = b for a symmetric, positive (semi-)definite A.

    Args:
        capacity: Largest number of rows.
        types: Number types of the matrix; b, x and the sums are float64.
        device: Warp device.
        tolerance: Norm of b - A x to reach, relative to that of b, or to that of the first residual where b is 0.
        max_iterations: Largest number of iterations of a solve.
        floor: Norm of b - A x that counts as converged whatever that of b.
        preconditioner: The preconditioner; by default the diagonal.

    Attributes:
        statistics: Values that `read_statistics` returns, float64; zero it to restart the count.
        tolerance: As given.
    """

    def __init__(
        self,
        capacity: int,
        *,
        types: NumericTypes,
        device: Any,
        tolerance: float = 1e-6,
        max_iterations: int = 10_000,
        floor: float = 0.0,
        preconditioner: Preconditioner | None = None,
    ) -> None:
        self._n, self._device = capacity, device
        self._kernels = solver_kernels(types)
        self.tolerance, self._floor, self._max_iterations = tolerance, floor, max_iterations
        self._preconditioner = preconditioner or Jacobi()
        self._sums = ChunkSums(capacity, types=types, device=device)
        vectors = [wp.zeros(capacity, dtype=wp.float64, device=device) for _ in range(7)]
        self._inverse, self._rhs, self._r, self._z, self._p, self._q, self._mask = vectors
        self._running = wp.zeros(1, dtype=wp.int32, device=device)
        self._control = wp.zeros(names.CONTROLS, dtype=wp.int32, device=device)
        self._scalars = wp.zeros(names.SCALARS, dtype=wp.float64, device=device)
        self.statistics = wp.zeros(names.STATISTICS, dtype=wp.float64, device=device)

    def solve(
        self,
        matrix: Matrix | Operator,
        b: wp.array,
        x: wp.array,
        *,
        extra_product: Product | None = None,
        reuse_preconditioner: bool = False,
    ) -> None:
        """Launch a solve.

        Args:
            matrix: The matrix, symmetric among the unknowns.
            b: Right-hand side, float64, shape [capacity].
            x: Initial guess (warm start) in, solution out, float64, shape [capacity].
            extra_product: Launches q += B x in a restart pass (`control[RESTART]` not 0), else q += B p, from
                (control, x, p, q): a symmetric matrix B beside the rows, whose diagonal is part of `matrix.diagonal`.
            reuse_preconditioner: Whether the preconditioner is that of the last solve, for the same matrix.
        """
        kernels = self._kernels
        vectors = [self._inverse, self._rhs, self._r, self._z, self._p, self._q]
        self._launch(kernels.prepare, self._n, [matrix.rows, matrix.active, matrix.diagonal, b], vectors)
        self._remove_mean(matrix, self._rhs)
        if not reuse_preconditioner:
            self._preconditioner.prepare(matrix, self._inverse)
        square = self._sums.launch(self._rhs, self._rhs, self._rhs)
        outputs = [self._running, self._control, self._scalars]
        self._launch(kernels.start_solve, 1, [self.tolerance, self._floor, square], outputs)
        wp.capture_while(self._running, self._iterate, matrix=matrix, x=x, extra_product=extra_product)
        self._remove_mean(matrix, x)

    def read_statistics(self) -> Statistics:
        """Statistics so far; waits for the device."""
        values = self.statistics.numpy()
        return Statistics(
            solves=int(values[names.SOLVES]),
            iterations=int(values[names.SUM]),
            most_iterations=int(values[names.MOST]),
            worst_residual=float(values[names.WORST]),
            stagnated=int(values[names.STAGNATED]),
            exhausted=int(values[names.EXHAUSTED]),
            last_iterations=int(values[names.ITERATIONS_NOW]),
            last_residual=float(values[names.RESIDUAL_NOW]),
        )

    def count_unsolved(self) -> int:
        """Number of solves so far that ended above the tolerance; waits for the device."""
        values = self.statistics.numpy()
        return int(values[names.STAGNATED] + values[names.EXHAUSTED])

    def assign(self, statistics: np.ndarray) -> None:
        """Continue from what `statistics` held, of which residuals may be infinite or NaN.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        residuals = [names.WORST, names.RESIDUAL_NOW]
        whole_numbers(np.delete(statistics, residuals))
        self.statistics.assign(statistics)

    def worst_row(self) -> int:
        """Row of the largest residual of the last solve; NaN counts as the largest."""
        return int(np.argmax(np.abs(self._r.numpy())))

    def _iterate(self, matrix: Matrix | Operator, x: wp.array, extra_product: Product | None) -> None:
        """One pass of the loop: an iteration or a restart, as `control` says."""
        kernels, n = self._kernels, self._n
        inverse, control, scalars = self._inverse, self._control, self._scalars
        self._multiply(matrix, x)
        if extra_product:
            extra_product(control, x, self._p, self._q)
        pq = self._sums.launch(self._p, self._q, self._q)
        self._launch(kernels.step_length, 1, [pq], [control, scalars])
        inputs = [inverse, control, scalars, self._rhs, self._p, self._q]
        self._launch(kernels.update_solution, n, inputs, [x, self._r, self._z])
        self._preconditioner.apply(self._r, self._z)
        products = self._sums.launch(self._r, self._z, self._r)
        limits = [self.tolerance, self._max_iterations, MAX_RESTARTS]
        outputs = [control, scalars, self.statistics, self._running]
        self._launch(kernels.check_convergence, 1, [*limits, products], outputs)
        self._launch(kernels.update_direction, n, [inverse, scalars, self._z], [self._p])

    def _multiply(self, matrix: Matrix | Operator, x: wp.array) -> None:
        """Launch q = A p, or A x in a restart pass."""
        if isinstance(matrix, Operator):
            matrix.multiply(self._control, x, self._p, self._q)
            return
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, self._inverse]
        self._launch(self._kernels.multiply, self._n, [*rows, self._control, x, self._p], [self._q])

    def _remove_mean(self, matrix: Matrix | Operator, v: wp.array) -> None:
        """Subtract the mean of the unknowns from v, if the matrix is singular."""
        if matrix.singular is None:
            return
        self._launch(self._kernels.mark_unknowns, self._n, [self._inverse], [self._mask])
        sums = self._sums.launch(self._mask, v, self._mask)
        self._launch(self._kernels.remove_mean, self._n, [matrix.singular, self._inverse, sums], [v])

    def _launch(self, kernel: Any, n: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, n, inputs, outputs, device=self._device)


class ChunkSums:
    """Dot products of vectors as sums of fixed chunks: the same bits whatever the schedule of the device.

    Args:
        n: Length of the vectors.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, n: int, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device = sum_kernels(types), device
        # on a CPU a thread walks through consecutive elements, on a GPU consecutive threads read consecutive elements
        self._contiguous = not wp.get_device(device).is_cuda
        self._lengths = [n]
        while self._lengths[-1] > 1 or len(self._lengths) < 2:
            self._lengths.append(max(1, -(-self._lengths[-1] // CHUNK)))
        self._levels = [wp.zeros(length, dtype=wp.vec2d, device=device) for length in self._lengths[1:]]

    def launch(self, a: wp.array, b: wp.array, c: wp.array) -> wp.array:
        """Launch the dots a.b and a.c.

        Returns:
            An array whose first element will hold the two; the next launch overwrites it.
        """
        across, along = self._strides(0)
        kernels, levels = self._kernels, self._levels
        wp.launch(kernels.dot_products, len(levels[0]), [across, along, a, b, c], [levels[0]], device=self._device)
        for k in range(1, len(levels)):
            across, along = self._strides(k)
            inputs = [across, along, self._lengths[k], levels[k - 1]]
            wp.launch(kernels.sum_chunks, len(levels[k]), inputs, [levels[k]], device=self._device)
        return levels[-1]

    def _strides(self, level: int) -> tuple[int, int]:
        """Distances between the first elements of two threads, and between two elements of one thread."""
        return (CHUNK, 1) if self._contiguous else (1, self._lengths[level + 1])


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare the solver's kernels, and return the names of their modules."""
    solver_kernels(types)
    sum_kernels(types)
    return [types.module(METHOD)]

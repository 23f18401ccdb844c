"""Preconditioned conjugate gradients on a device, without a word to the host.

Method of Hestenes & Stiefel, J. Res. Natl. Bur. Stand. 49 (1952) 409, preconditioned. The loop is `wp.capture_while`:
a solve can be part of a captured graph, and gives the same bits outside of one. Dots are sums of fixed chunks, so that
they do not depend on the device's schedule.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
import warp as wp

from warp_mps.core.linear import kernels as names
from warp_mps.core.linear.kernels import CHUNK, METHOD, solver_kernels
from warp_mps.core.types import NumericTypes

MAX_RESTARTS = 4


class Matrix(NamedTuple):
    """A symmetric matrix in rows: (A x)_i = diagonal_i x_i - sum_k value_k x[index_k].

    A row that is no unknown (not active, without a positive diagonal, or beyond `rows`) is left out: its x stays as it
    is given, and enters the rows of the unknowns as a known value (Dirichlet).

    Attributes:
        rows: Number of rows in use, int32, shape [1].
        first: First entry of each row, int32, shape [capacity].
        count: Number of entries of each row, int32, shape [capacity].
        index: Column of each entry, int32, shape [entries].
        value: Entries off the diagonal, with their sign turned, shape [entries].
        diagonal: Entries of the diagonal, shape [capacity].
        active: 0 in rows that are no unknowns, int32, shape [capacity].
        singular: Not 0 if constants are in the null space, as in a closed domain without a free surface, int32,
            shape [1]. The means of the unknowns are then taken out of b and x. None if that can never be.
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
    """A symmetric matrix that is given by its product alone; what is no unknown counts as in a `Matrix`.

    Attributes:
        rows: Number of rows in use, int32, shape [1].
        diagonal: The diagonal, or what the preconditioner is to take for it, shape [capacity].
        active: 0 in rows that are no unknowns, int32, shape [capacity].
        multiply: Launches q = A x in a restart pass (`control[RESTART]` not 0), else q = A p, from (control, x, p, q);
            only the rows of the unknowns count.
        singular: As of a `Matrix`.
    """

    rows: wp.array
    diagonal: wp.array
    active: wp.array
    multiply: Product
    singular: wp.array | None = None


class Preconditioner(Protocol):
    """An approximate inverse, symmetric and positive, of the matrix."""

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Launch what a new matrix needs.

        Args:
            matrix: The matrix, of the kind that it is for: a `Matrix`, an `Operator` or either.
            inverse: Inverse of its diagonal, 0 in rows that are no unknowns, float64, shape [capacity].
        """

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Launch z = M^-1 r; z comes in as r times the inverse of the diagonal, and must stay 0 where r is 0 for good.

        Args:
            r: Residual, float64, shape [capacity].
            z: Preconditioned residual, float64, shape [capacity].
        """


class Jacobi:
    """The inverse of the diagonal, which the solver applies by itself."""

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Nothing to launch."""

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Nothing to launch."""


@dataclass(frozen=True)
class Statistics:
    """What a solver has done so far.

    Attributes:
        solves: Number of solves.
        iterations: Iterations of all solves together.
        most_iterations: Iterations of the longest.
        worst_residual: Largest true residual that a solve ended with, relative to b.
        stagnated: Solves that ended above the tolerance because the true residual did not fall any more.
        exhausted: Solves that ended above the tolerance because they had no iteration left.
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
        tolerance: Norm of b - A x that is asked for, relative to that of b (or, where b is 0, to the first one).
        max_iterations: Iterations after which a solve ends as it is.
        floor: Norm of b - A x below which any solution will do.
        preconditioner: The diagonal by default.

    Attributes:
        statistics: What `read_statistics` reads, float64; zero it to start counting anew.
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
        self, matrix: Matrix | Operator, b: wp.array, x: wp.array, *, rest: Product | None = None, same: bool = False
    ) -> None:
        """Launch a solve.

        Args:
            matrix: The matrix, symmetric among the unknowns.
            b: Right-hand side, float64, shape [capacity].
            x: First guess in, solution out, float64, shape [capacity].
            rest: Launches the sum of q and of a symmetric matrix times x if `control[RESTART]` is not 0, else times p,
                from (control, x, p, q): what the rows do not hold but for its diagonal, which is in `matrix.diagonal`.
            same: Whether the matrix is that of the last solve, so that the preconditioner need not be made anew.
        """
        kernels = self._kernels
        vectors = [self._inverse, self._rhs, self._r, self._z, self._p, self._q]
        self._launch(kernels.prepare, self._n, [matrix.rows, matrix.active, matrix.diagonal, b], vectors)
        self._centre(matrix, self._rhs)
        if not same:
            self._preconditioner.prepare(matrix, self._inverse)
        square = self._sums.launch(self._rhs, self._rhs, self._rhs)
        outputs = [self._running, self._control, self._scalars]
        self._launch(kernels.begin, 1, [self.tolerance, self._floor, square], outputs)
        wp.capture_while(self._running, self._iterate, matrix=matrix, x=x, rest=rest)
        self._centre(matrix, x)

    def read_statistics(self) -> Statistics:
        """What was done so far; waits for the device."""
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
        """Solves so far that ended above the tolerance; waits for the device."""
        values = self.statistics.numpy()
        return int(values[names.STAGNATED] + values[names.EXHAUSTED])

    def worst_row(self) -> int:
        """Row of the largest residual of the last solve, one that is no number before all others."""
        return int(np.argmax(np.abs(self._r.numpy())))

    def _iterate(self, matrix: Matrix | Operator, x: wp.array, rest: Product | None) -> None:
        """One pass of the loop: an iteration or a fresh start, as `control` says."""
        kernels, n = self._kernels, self._n
        inverse, control, scalars = self._inverse, self._control, self._scalars
        self._multiply(matrix, x)
        if rest:
            rest(control, x, self._p, self._q)
        pq = self._sums.launch(self._p, self._q, self._q)
        self._launch(kernels.measure_step, 1, [pq], [control, scalars])
        inputs = [inverse, control, scalars, self._rhs, self._p, self._q]
        self._launch(kernels.advance, n, inputs, [x, self._r, self._z])
        self._preconditioner.apply(self._r, self._z)
        products = self._sums.launch(self._r, self._z, self._r)
        limits = [self.tolerance, self._max_iterations, MAX_RESTARTS]
        outputs = [self._running, control, scalars, self.statistics]
        self._launch(kernels.decide, 1, [*limits, products], outputs)
        self._launch(kernels.turn, n, [inverse, scalars, self._z], [self._p])

    def _multiply(self, matrix: Matrix | Operator, x: wp.array) -> None:
        """Q = A p, or A x in a fresh pass."""
        if isinstance(matrix, Operator):
            matrix.multiply(self._control, x, self._p, self._q)
            return
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, self._inverse]
        self._launch(self._kernels.multiply, self._n, [*rows, self._control, x, self._p], [self._q])

    def _centre(self, matrix: Matrix | Operator, v: wp.array) -> None:
        """Take the mean of the unknowns out of v, if the device says that the matrix is singular."""
        if matrix.singular is None:
            return
        self._launch(self._kernels.mark, self._n, [self._inverse], [self._mask])
        sums = self._sums.launch(self._mask, v, self._mask)
        self._launch(self._kernels.centre, self._n, [matrix.singular, self._inverse, sums], [v])

    def _launch(self, kernel: Any, n: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, n, inputs, outputs, device=self._device)


class ChunkSums:
    """Sums over vectors, made of sums of fixed chunks: the same bits whatever the schedule.

    Args:
        n: Length of the vectors.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, n: int, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device = solver_kernels(types), device
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
        wp.launch(kernels.dots, len(levels[0]), [across, along, a, b, c], [levels[0]], device=self._device)
        for k in range(1, len(levels)):
            across, along = self._strides(k)
            inputs = [across, along, self._lengths[k], levels[k - 1]]
            wp.launch(kernels.fold, len(levels[k]), inputs, [levels[k]], device=self._device)
        return levels[-1]

    def _strides(self, level: int) -> tuple[int, int]:
        """Distances between the first elements of two threads, and between two elements of one thread."""
        return (CHUNK, 1) if self._contiguous else (1, self._lengths[level + 1])


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare the solver's kernels, and return the names of their modules."""
    solver_kernels(types)
    return [types.module(METHOD)]

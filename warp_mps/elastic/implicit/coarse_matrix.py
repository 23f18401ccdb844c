"""The coarse matrix of the two-level preconditioner on the host: a dense block for each body, and their inverses."""

from __future__ import annotations

import numpy as np

from warp_mps.elastic.implicit.aggregates import Aggregates

SHIFT_GROWTH = 100.0
# rows of the tiles of the factorization: products of tiles are far below the size that a BLAS shares among threads
# (2^18 multiplications in OpenBLAS), which would make the bits depend on their number
TILE = 32
# smallest diagonal entry, relative to the largest: below it a motion has no stiffness, as a rotation of one particle
NO_STIFFNESS = 1e-14


class CoarseMatrix:
    """Layout of the coarse matrix: the dense blocks of the bodies one after the other.

    Attributes:
        total: Entries of all blocks.
        sizes: Rows of each block, shape [bodies].
        first: First row of the block of each row, shape [rows].
        block: First entry of the block of each row, shape [rows].
        size: Rows of the block of each row, shape [rows].

    Args:
        aggregates: The aggregates.
        modes: Unknowns of each.
    """

    def __init__(self, aggregates: Aggregates, modes: int) -> None:
        _, body, counts = np.unique(aggregates.bodies, return_inverse=True, return_counts=True)
        self.sizes = modes * counts
        self._starts = np.concatenate(([0], np.cumsum(self.sizes**2)))
        self.total = int(self._starts[-1])
        first = np.cumsum(self.sizes) - self.sizes
        self.first, self.block, self.size = (
            np.repeat(values[body], modes) for values in (first, self._starts[:-1], self.sizes)
        )
        rows, columns = aggregates.rows, aggregates.columns
        self._entries = (aggregates.colours[columns], rows)
        here, mode = modes * rows, np.arange(modes)
        inside = here - self.first[here], modes * columns - self.first[here]
        row, column = inside[0][:, None, None] + mode, inside[1][:, None, None] + mode[:, None]
        # indices of the response to a unit motion of a column: the motion, then the force
        self._places = self.block[here][:, None, None] + row * self.size[here][:, None, None] + column

    def inverse(self, answers: np.ndarray, shift: float) -> np.ndarray:
        """Positive inverses of the blocks, one after the other.

        Args:
            answers: Forces and moments on the aggregates while those of a colour move, shape [colours, modes,
                aggregates, modes].
            shift: Smallest shift of the diagonal, relative to it.
        """
        colour, row = self._entries
        flat = np.zeros(self.total)
        flat[self._places] = answers[colour, :, row, :]
        for size, start in zip(self.sizes, self._starts[:-1], strict=True):
            block = flat[start : start + size**2].reshape(size, size)
            block[:] = positive_inverse(block, shift)
        return flat


def positive_inverse(matrix: np.ndarray, shift: float) -> np.ndarray:
    """Inverse of a symmetric matrix, whose diagonal is shifted until it is positive definite.

    Args:
        matrix: The matrix, shape [m, m].
        shift: Smallest shift of its diagonal, relative to it.

    Returns:
        The inverse; 0 in rows without stiffness, and entirely 0 if the matrix is not finite.
    """
    diagonal = np.diagonal(matrix)
    there = diagonal > NO_STIFFNESS * diagonal.max(initial=0.0)
    scale = np.where(there, 1.0 / np.sqrt(np.where(there, diagonal, 1.0)), 0.0)
    scaled = 0.5 * (matrix + matrix.T) * np.outer(scale, scale)
    while shift < 1.0:
        try:
            np.fill_diagonal(scaled, 1.0 + shift)
            lower = _gram(_inverse_factor(scaled), len(matrix))
        except np.linalg.LinAlgError:
            shift *= SHIFT_GROWTH
            continue
        found = (lower + np.tril(lower, -1).T) * np.outer(scale, scale)
        # the factorization may have accepted NaN
        return found if np.isfinite(found).all() else np.zeros_like(matrix)
    return np.zeros_like(matrix)


def _inverse_factor(matrix: np.ndarray) -> np.ndarray:
    """L^-1 of a matrix L L^T, by a right-looking Cholesky factorization in tiles.

    Args:
        matrix: The matrix, shape [m, m].

    Returns:
        The tiles of L^-1, whose last rows are those of the unit matrix, shape [k, k, TILE, TILE].

    Raises:
        LinAlgError: The matrix is not positive definite.
    """
    count = -(-len(matrix) // TILE)
    unit = np.eye(count * TILE)
    whole = unit.copy()
    whole[: len(matrix), : len(matrix)] = matrix
    rest, found = (array.reshape(count, TILE, count, TILE).swapaxes(1, 2).copy() for array in (whole, unit))
    for k in range(count):
        inverse = np.linalg.inv(np.linalg.cholesky(rest[k, k]))
        found[k, : k + 1] = inverse @ found[k, : k + 1]
        below = rest[k + 1 :, k] @ inverse.T
        across = below.swapaxes(1, 2).copy()
        for column in range(len(below)):
            rest[k + 1 + column :, k + 1 + column] -= below[column:] @ across[column]
        found[k + 1 :, : k + 1] -= below[:, None] @ found[k, : k + 1]
    return found


def _gram(factor: np.ndarray, size: int) -> np.ndarray:
    """The lower triangle of F^T F, shape [size, size], of the tiles of a lower triangular F, shape [k, k, b, b]."""
    product = np.zeros_like(factor)
    for k in range(len(factor)):
        row = factor[k, : k + 1]
        # a copy, so that a tile times itself is a product of two
        for i, tile in enumerate(row.swapaxes(1, 2).copy()):
            product[i, : i + 1] += tile @ row[: i + 1]
    rows = TILE * len(factor)
    return np.tril(product.swapaxes(1, 2).reshape(rows, rows)[:size, :size])

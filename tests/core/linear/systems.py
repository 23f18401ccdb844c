"""Model systems for the linear solver: the Laplacian of MPS on particles that have left their lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse
import warp as wp
from scipy.spatial import cKDTree

from warp_mps.core.linear.conjugate_gradient import Matrix


@dataclass(frozen=True)
class System:
    """A x = b with some rows that are no unknowns, all in NumPy; `weights` are the entries off the diagonal."""

    positions: np.ndarray
    weights: scipy.sparse.csr_matrix
    diagonal: np.ndarray
    active: np.ndarray
    b: np.ndarray

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.b)

    @property
    def unknowns(self) -> np.ndarray:
        """Rows that are unknowns."""
        return np.flatnonzero(self.active)

    @property
    def matrix(self) -> scipy.sparse.csr_matrix:
        """All rows, with the diagonal."""
        return (scipy.sparse.diags(self.diagonal) - self.weights).tocsr()

    @property
    def inner(self) -> scipy.sparse.csc_matrix:
        """The matrix of the unknowns alone."""
        return self.matrix[self.unknowns][:, self.unknowns].tocsc()

    def residual(self, x: np.ndarray) -> float:
        """Norm of b - A x in the rows of the unknowns, relative to that of b."""
        difference = (self.b - self.matrix @ x)[self.unknowns]
        return float(np.linalg.norm(difference) / np.linalg.norm(self.b[self.unknowns]))


def laplacian(
    shape: tuple[int, ...],
    *,
    reach: float = 2.1,
    surface: bool = True,
    scatter: float = 0.0,
    periodic: tuple[int, ...] = (),
) -> System:
    """A box of particles, a spacing of 1 apart and each shifted by up to a tenth.

    Args:
        shape: Particles along each axis.
        reach: Effective radius.
        surface: Whether the top layer is a free surface, where x = 0; if not, the system is singular.
        scatter: Share of the particles inside that are no unknowns either.
        periodic: Axes along which the box repeats itself, at least twice as long as the effective radius.
    """
    rng = np.random.default_rng(5)
    axes = np.meshgrid(*[np.arange(length) + 0.5 for length in shape], indexing="ij")
    positions = np.stack(axes, axis=-1).reshape(-1, len(shape))
    n = len(positions)
    active = np.ones(n, dtype=np.int32)
    if surface:
        active[positions[:, -1] > shape[-1] - 1] = 0
    active[rng.random(n) < scatter] = 0
    positions += rng.uniform(-0.1, 0.1, positions.shape)
    period = np.where(np.isin(np.arange(len(shape)), periodic), shape, 0)
    positions = np.where(period > 0, positions % np.maximum(period, 1), positions)
    tree = cKDTree(positions - np.where(period > 0, 0.0, positions.min(axis=0)), boxsize=period)
    i, j = tree.query_pairs(reach, output_type="ndarray").T
    apart = positions[i] - positions[j]
    apart -= period * np.round(apart / np.maximum(period, 1))
    w = reach / np.linalg.norm(apart, axis=1) - 1.0
    half = scipy.sparse.coo_matrix((w, (i, j)), shape=(n, n))
    weights = (half + half.T).tocsr()
    weights.sort_indices()
    diagonal = np.asarray(weights.sum(axis=1)).ravel()
    b = rng.normal(size=n) + 3.0 * np.cos(3.0 * positions[:, 0] / shape[0])
    if not surface:
        b -= b[active != 0].mean()
    return System(positions, weights, diagonal, active, b * active)


def on_device(
    system: System, *, spare: int = 0, singular: bool | None = None, real: type = wp.float64, device: str = "cpu"
) -> Matrix:
    """The matrix of a system, with some rows to spare, which hold numbers that would be noticed."""

    def rows(values: np.ndarray, dtype: type, beyond: float) -> wp.array:
        return wp.array(np.append(values, np.full(spare, beyond)), dtype=dtype, device=device)

    start = system.weights.indptr
    return Matrix(
        rows=wp.array([system.n], dtype=wp.int32, device=device),
        first=rows(start[:-1], wp.int32, 0),
        count=rows(np.diff(start), wp.int32, 3),
        index=wp.array(system.weights.indices, dtype=wp.int32, device=device),
        value=wp.array(system.weights.data, dtype=real, device=device),
        diagonal=rows(system.diagonal, real, 7.0),
        active=rows(system.active, wp.int32, 1),
        singular=None if singular is None else wp.array([int(singular)], dtype=wp.int32, device=device),
    )

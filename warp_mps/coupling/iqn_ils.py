"""The interface quasi-Newton method with an inverse Jacobian from a least-squares model (IQN-ILS).

It accelerates a fixed-point iteration x = H(x). With residuals r = H(x) - x, and the columns of V and W the differences
of r and of H(x) between passes, of this step and of the last ones, the next iterate is

    x = H(x) - W c,    c = argmin |V c - r|

(Degroote, Bathe and Vierendeels 2009), solved by QR; columns that add little to those before them are filtered
(Haelterman et al. 2016).

References:
    Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87 (2009) 793.
    Haelterman, R., et al., Computers & Structures 171 (2016) 9 (filtering of columns).
"""

from __future__ import annotations

import numpy as np

from warp_mps.core.counters import whole_numbers

# a column is dropped if its diagonal entry in R is below this part of the largest
FILTER = 1e-6


class InterfaceQuasiNewton:
    """Finds the next iterate of a fixed-point iteration.

    Args:
        steps: Number of earlier steps whose columns are reused.
    """

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._earlier: list[np.ndarray] = []
        self._columns: list[np.ndarray] = []
        self._last: np.ndarray | None = None

    def add(self, x: np.ndarray, value: np.ndarray) -> None:
        """Add a pass: x and H(x), both of shape [n]."""
        now = np.stack((value - x, value))
        if self._last is not None:
            self._columns.insert(0, now - self._last)
        self._last = now

    def next_iterate(self) -> np.ndarray:
        """The next iterate, shape [n]; H(x) while there are no columns."""
        assert self._last is not None
        residual, value = self._last
        known = [np.array(self._columns), *self._earlier] if self._columns else self._earlier
        if not known:
            return value
        columns = np.concatenate(known)[: len(residual)]
        v, w = columns[:, 0].T, columns[:, 1].T
        q, r = np.linalg.qr(v)
        left = np.abs(np.diag(r))
        keep = left > FILTER * left.max()
        if not keep.any():
            return value
        if not keep.all():
            q, r = np.linalg.qr(v[:, keep])
        return value - w[:, keep] @ np.linalg.solve(r, q.T @ residual)

    def end_step(self) -> None:
        """Keep the columns of the step that ends."""
        if self._columns:
            self._earlier.insert(0, np.array(self._columns))
            del self._earlier[self._steps :]
        self._columns, self._last = [], None

    def forget(self) -> None:
        """Drop all columns: H is another one."""
        self._earlier, self._columns, self._last = [], [], None

    @property
    def memory(self) -> np.ndarray:
        """Columns of V and W of earlier steps, newest first, shape [columns, 2, n]; with `sizes`, for a checkpoint."""
        return np.concatenate(self._earlier) if self._earlier else np.zeros((0, 2, 0))

    @property
    def sizes(self) -> np.ndarray:
        """Number of columns of each earlier step."""
        return np.array([len(step) for step in self._earlier], int)

    def assign(self, memory: np.ndarray, sizes: np.ndarray) -> None:
        """Continue from what `memory` and `sizes` gave, between two steps.

        Raises:
            ValueError: A size is no whole number of 0 or more, or they are not those of the columns.
        """
        if (columns := sum(whole_numbers(sizes))) != len(memory):
            raise ValueError(f"learnt_sizes name {columns} columns, learnt holds {len(memory)}")
        self._earlier = [step.copy() for step in np.split(memory, np.cumsum(sizes)[:-1])] if len(sizes) else []
        self._columns, self._last = [], None

"""Tables for prolongation and restriction between two levels of cells, and of the neighbours of each cell.

Prolongation interpolates linearly, axis by axis, from coarse cells (ABOVE a cell) to cells (BELOW a coarse one);
restriction is its transpose.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import warp as wp

# coarse cells above a cell along an axis, and cells below a coarse one
ABOVE, BELOW = 2, 4


def coarse_dims(dims: np.ndarray) -> np.ndarray:
    """Cells of the next level along each axis."""
    return -(-dims // 2)


def cell_neighbours(dims: np.ndarray, wraps: np.ndarray) -> np.ndarray:
    """Numbers of the 3^d cells around each cell, shape [cells, 3^d]; beyond an edge the cell itself.

    The first axis runs fastest, both through the cells and through the offsets to the cells around one.

    Args:
        dims: Cells along each axis.
        wraps: Whether each axis is periodic.
    """
    around = np.zeros((1, 1), dtype=np.int64)
    for n, wrap in zip(reversed(dims), reversed(wraps), strict=True):
        here = np.arange(n)[:, None]
        there = here + np.arange(-1, 2)
        there = there % n if wrap else np.where((there < 0) | (there >= n), -1, there)
        combined = around[:, None, :, None] * n + there[None, :, None, :]
        outside = (around[:, None, :, None] < 0) | (there[None, :, None, :] < 0)
        around = np.where(outside, -1, combined).reshape(len(around) * n, -1)
    own = np.arange(len(around))[:, None]
    return np.where(around < 0, own, around).astype(np.int32)


def interpolation(n: int, coarse: int, wraps: bool) -> tuple[np.ndarray, np.ndarray]:
    """Linear interpolation from coarse cells to the centres of n cells of an axis.

    A coarse cell covers two cells, or one at the end of an odd number of them.

    Returns:
        The coarse cells, and their weights, shape [n, ABOVE].
    """
    here = np.arange(n)
    near, far = here // 2, here // 2 - 1 + 2 * (here % 2)
    if wraps:
        far %= coarse
    inside = (far >= 0) & (far < coarse) & (far != near)
    if wraps and n % 2 == 1:
        # the last cell is in the middle of its coarse cell
        inside[-1] = False
    share = np.where(inside, 0.25, 0.0)
    return np.stack((near, np.where(inside, far, near)), axis=1), np.stack((1.0 - share, share), axis=1)


def transpose(cells: np.ndarray, shares: np.ndarray, coarse: int, wraps: bool) -> tuple[np.ndarray, np.ndarray]:
    """Transpose of an interpolation.

    Returns:
        The cells that each coarse one is interpolated to, and its weights there, shape [coarse, BELOW].
    """
    n = len(cells)
    there = 2 * np.arange(coarse)[:, None] + np.arange(-1, 3)
    counts, there = (there >= 0) & (there < n), there % n
    if wraps:
        # each cell once, where the period is so short that it comes again
        counts = np.stack([(there[:, k, None] != there[:, :k]).all(axis=1) for k in range(BELOW)], axis=1)
    weights = np.where(cells[there] == np.arange(coarse)[:, None, None], shares[there], 0.0).sum(axis=2)
    return there, np.where(counts, weights, 0.0)


class TransferTable:
    """Cells of another level and their weights, for each cell of a level, axis by axis.

    Args:
        tables: Cells and weights along each axis, shape [cells, most].
        ivec: Warp type of whole numbers along each axis.
        device: Warp device.
    """

    def __init__(self, tables: list[tuple[np.ndarray, np.ndarray]], *, ivec: Any, device: Any) -> None:
        starts = itertools.accumulate((len(cells) for cells, _ in tables[:-1]), initial=0)
        self.first = ivec(*starts)
        cells, shares = (np.concatenate(parts).ravel() for parts in zip(*tables, strict=True))
        self.cell = wp.array(cells, dtype=wp.int32, device=device)
        self.share = wp.array(shares, dtype=wp.float64, device=device)

    @property
    def inputs(self) -> list[Any]:
        """Arguments of a kernel."""
        return [self.first, self.cell, self.share]

"""Tables of cells: neighbours, and linear weights of interpolation, with and without a period."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from warp_mps.core.device import open_device
from warp_mps.core.multigrid.cell_numbering import cell_type
from warp_mps.core.multigrid.transfer_tables import (
    ABOVE,
    BELOW,
    TransferTable,
    cell_neighbours,
    interpolation,
    transpose,
)
from warp_mps.core.types import numeric_types

SIZES = [1, 2, 3, 4, 5, 8, 9]


@pytest.mark.parametrize("dims", [(5, 4), (1, 3), (2, 3, 4), (3, 1, 1)])
def test_surroundings(dims: tuple[int, ...]) -> None:
    d = len(dims)
    strides = np.concatenate(([1], np.cumprod(dims)[:-1])).astype(int)
    cells = list(itertools.product(*[range(n) for n in dims]))
    for wraps in itertools.product((False, True), repeat=d):
        found = cell_neighbours(np.array(dims), np.array(wraps))
        assert found.shape == (len(cells), 3**d)
        for cell in cells:
            # the first axis runs fastest
            for k, offset in enumerate(itertools.product((-1, 0, 1), repeat=d)):
                there = np.add(cell, offset[::-1])
                there = np.where(wraps, there % dims, there)
                outside = np.any((there < 0) | (there >= dims))
                assert found[np.dot(cell, strides), k] == np.dot(cell if outside else there, strides)


def dense(cells: np.ndarray, shares: np.ndarray, others: int) -> np.ndarray:
    """A table as a matrix."""
    matrix = np.zeros((len(cells), others))
    np.add.at(matrix, (np.arange(len(cells))[:, None], cells), shares)
    return matrix


@pytest.mark.parametrize("n", SIZES)
def test_interpolation_without_a_period(n: int) -> None:
    coarse = -(-n // 2)
    weights = dense(*interpolation(n, coarse, False), coarse)
    np.testing.assert_array_equal(weights.sum(axis=1), 1.0)
    centres, between = 2.0 * np.arange(coarse) + 1.0, np.arange(n) + 0.5
    inner = (between > centres[0]) & (between < centres[-1])
    np.testing.assert_array_equal((weights @ centres)[inner], between[inner])


@pytest.mark.parametrize("n", SIZES)
def test_interpolation_across_a_period(n: int) -> None:
    coarse = -(-n // 2)
    weights = dense(*interpolation(n, coarse, True), coarse)
    np.testing.assert_array_equal(weights.sum(axis=1), 1.0)
    if n % 2 == 0:
        # no cell is a special one
        np.testing.assert_array_equal(weights, np.roll(weights, (2, 1), axis=(0, 1)))
    else:
        np.testing.assert_array_equal(weights[-1], np.eye(coarse)[-1])


@pytest.mark.parametrize("wraps", [False, True])
@pytest.mark.parametrize("n", SIZES)
def test_transpose(n: int, wraps: bool) -> None:
    coarse = -(-n // 2)
    table = interpolation(n, coarse, wraps)
    below = transpose(*table, coarse, wraps)
    assert table[0].shape == table[1].shape == (n, ABOVE)
    assert below[0].shape == below[1].shape == (coarse, BELOW)
    np.testing.assert_array_equal(dense(*below, n), dense(*table, coarse).T)


def test_tables_of_several_axes() -> None:
    tables = [interpolation(5, 3, False), interpolation(4, 2, True), interpolation(1, 1, False)]
    along = TransferTable(tables, ivec=cell_type(numeric_types(3)), device=open_device("cpu"))
    cell, share = along.cell.numpy().reshape(-1, ABOVE), along.share.numpy().reshape(-1, ABOVE)
    for first, (cells, shares) in zip(along.first, tables, strict=True):
        np.testing.assert_array_equal(cell[first : first + len(cells)], cells)
        np.testing.assert_array_equal(share[first : first + len(cells)], shares)

"""Tables of prescribed motions: the slopes that make a table's rows a smooth curve.

The cubic curve through the rows is the spline with continuous second derivative whose slope is 0 at both ends, so that
a motion that is constant outside its table starts and stops without a jump of its velocity.

References:
    de Boor, A Practical Guide to Splines, Springer (1978), chapter IV.
"""

from __future__ import annotations

import numpy as np


def clamped_slopes(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Slopes of the cubic spline through the rows of a table, 0 at its ends.

    The second derivative is continuous at row k where, with h_k = t_k+1 - t_k and d_k = (x_k+1 - x_k)/h_k,

        h_k m_k-1 + 2 (h_k-1 + h_k) m_k + h_k-1 m_k+1 = 3 (h_k d_k-1 + h_k-1 d_k)

    which is solved by elimination.

    Args:
        times: Times, increasing [s], shape [n].
        rows: Values, shape [n, k].

    Returns:
        Slopes [1/s], shape [n, k].
    """
    h = np.diff(times)
    steep = np.diff(rows, axis=0) / h[:, None]
    before, after = h[:-1, None], h[1:, None]
    right = 3.0 * (after * steep[:-1] + before * steep[1:])
    diagonal = 2.0 * (h[:-1] + h[1:])
    columns = [_eliminated(h.tolist(), diagonal.tolist(), column.tolist()) for column in right.T]
    return np.column_stack(columns)


def _eliminated(h: list[float], diagonal: list[float], right: list[float]) -> list[float]:
    """Solution of the equations for one column; Python's floats are faster here than numbers of arrays."""
    upper, slopes = [0.0], [0.0]
    for k in range(1, len(h)):
        pivot = diagonal[k - 1] - h[k] * upper[-1]
        upper.append(h[k - 1] / pivot)
        slopes.append((right[k - 1] - h[k] * slopes[-1]) / pivot)
    slopes.append(0.0)
    for k in range(len(h) - 2, 0, -1):
        slopes[k] -= upper[k] * slopes[k + 1]
    return slopes


def table_values(times: np.ndarray, rows: np.ndarray, interpolation: str, at: float) -> np.ndarray:
    """Values of a table at a time, constant outside it.

    Args:
        times: Times, increasing [s], shape [n].
        rows: Values, shape [n, k].
        interpolation: ``linear`` or ``cubic``.
        at: The time [s].

    Returns:
        Values, shape [k].
    """
    if at <= times[0] or at >= times[-1]:
        return rows[0] if at <= times[0] else rows[-1]
    k = int(np.searchsorted(times, at, side="left"))
    span = times[k] - times[k - 1]
    s = (at - times[k - 1]) / span
    move = rows[k] - rows[k - 1]
    if interpolation == "linear":
        return rows[k - 1] + s * move
    first, last = span * clamped_slopes(times, rows)[k - 1 : k + 1]
    return rows[k - 1] + s * (s * (3.0 - 2.0 * s) * move + (1.0 - s) * ((1.0 - s) * first - s * last))

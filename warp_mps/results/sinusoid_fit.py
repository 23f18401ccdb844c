"""Least-squares fits of sinusoids: y(t) = C + sum_k [a_k sin(omega_k t) + b_k cos(omega_k t)].

For given omega the fit is linear; an unknown omega is where its residual is least (variable projection). It is
found by a scan about the peak of the spectrum and refined by golden-section search, so neither the sampling nor the
length of the record quantizes it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# The peak of a short record's spectrum lies within two bins of its frequency; its residual is a valley one bin wide.
SCAN_BINS = 2.0
SCAN_STEPS = 160
PADDING = 8
# Smallest distance of two sinusoids that the record can separate [bins].
LEAST_DISTANCE = 0.25
LEAST_SAMPLES = 8


def fit(times: np.ndarray, values: np.ndarray, omegas: Sequence[float]) -> tuple[np.ndarray, float]:
    """Fit sinusoids of given frequencies and a constant.

    Args:
        times: Times [s], shape [m].
        values: Values, shape [m].
        omegas: Angular frequencies [rad/s].

    Returns:
        Coefficients a_1, b_1, a_2, b_2, ..., C and the sum of the squared residuals.
    """
    columns = [function(omega * times) for omega in omegas for function in (np.sin, np.cos)]
    basis = np.column_stack([*columns, np.ones_like(times)])
    coefficients = np.linalg.lstsq(basis, values, rcond=None)[0]
    return coefficients, float(np.sum((values - basis @ coefficients) ** 2))


def dominant(times: np.ndarray, values: np.ndarray, *, beside: Sequence[float] = ()) -> float:
    """Angular frequency of the sinusoid that fits best, beside others of known frequencies [rad/s].

    Args:
        times: Times, increasing [s], shape [m].
        values: Values, shape [m].
        beside: Angular frequencies that are fitted together with it [rad/s].

    Raises:
        ValueError: There are too few samples, or nothing varies.
    """
    require_samples(times)
    coefficients, residual = fit(times, values, beside)
    rest = values - values.mean() if not beside else values - evaluate(times, beside, coefficients)
    if residual <= 1e-24 * float(np.sum(values**2)):
        raise ValueError("the history does not vary" if not beside else "nothing is left beside the known frequencies")

    def cost(omega: float) -> float:
        return fit(times, values, [*beside, omega])[1]

    width = 2.0 * np.pi / (times[-1] - times[0])
    peak = _spectrum_peak(times, rest)
    lowest = max(peak - SCAN_BINS * width, LEAST_DISTANCE * width)
    grid = np.linspace(lowest, peak + SCAN_BINS * width, SCAN_STEPS + 1)
    allowed = [omega for omega in grid if all(abs(omega - other) > LEAST_DISTANCE * width for other in beside)]
    best = min(allowed, key=cost)
    return _golden(cost, best - (grid[1] - grid[0]), best + (grid[1] - grid[0]))


def evaluate(times: np.ndarray, omegas: Sequence[float], coefficients: np.ndarray) -> np.ndarray:
    """The fitted function at given times, shape [m]."""
    values = np.full_like(times, coefficients[-1])
    for omega, a, b in zip(omegas, coefficients[0::2], coefficients[1::2], strict=False):
        values += a * np.sin(omega * times) + b * np.cos(omega * times)
    return values


def require_samples(times: np.ndarray) -> None:
    """Refuse a history that is too short to fit.

    Raises:
        ValueError: It is.
    """
    if len(times) < LEAST_SAMPLES:
        raise ValueError(f"{len(times)} samples are too few to fit a frequency; at least {LEAST_SAMPLES} are needed")


def _spectrum_peak(times: np.ndarray, values: np.ndarray) -> float:
    """Angular frequency of the highest peak of the spectrum, from evenly spaced, windowed samples [rad/s]."""
    even = np.linspace(times[0], times[-1], len(times))
    sampled = np.interp(even, times, values) * np.hanning(len(times))
    size = PADDING * len(times)
    spectrum = np.abs(np.fft.rfft(sampled, size))
    return float(2.0 * np.pi * np.argmax(spectrum) / (size * (even[1] - even[0])))


def _golden(cost: Callable[[float], float], low: float, high: float) -> float:
    """Where a function with one valley between two bounds is least, by golden-section search."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = cost(left), cost(right)
    while high - low > 1e-10 * high:
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = cost(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = cost(right)
    return 0.5 * (low + high)

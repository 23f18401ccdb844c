"""Measures: numbers drawn from the history of a probe.

y(t) is the chosen component of the probe between the measurement's start and end, sampled at t_1 < ... < t_m.

- ``frequency``: the omega [rad/s], or omega / 2 pi where the unit is Hz, of the best fit y = A cos(omega t) +
  B sin(omega t) + C in the least-squares sense, over A, B, C and omega; at least one period must lie in the window. A
  second mode of relative amplitude e that is twice as fast or more shifts it by less than about 0.3 e / periods^2.
- ``period``: 2 pi / omega of that fit [s].
- ``amplitude``: sqrt(A^2 + B^2) of that fit.
- ``offset``: C of that fit: the mean of an oscillation, whether or not the window holds whole periods.
- ``mean``: 1/(t_m - t_1) times the integral of y, by the trapezoidal rule.
- ``minimum``, ``maximum``: the least and the greatest y(t_k).
- ``midrange``, ``half_range``: half of their sum, and of their difference.
- ``final``: y(t_m).
- ``restitution``: -y(t_m)/y(t_1), of a velocity component that reverses in an impact.
- ``contact_time``: t_b - t_a, the first and last samples where abs(y) exceeds 1e-9 of its maximum.
- ``value_at``: y at the time that is given, between two samples by a straight line.
- ``time_at``: the first time at which y passes the value that is given or has it, likewise.
- ``harmonic_amplitude``: sqrt(a^2 + b^2) of the least-squares fit y = a sin(omega t) + b cos(omega t) + C + (a second
  sinusoid), omega = 2 pi f given. The second sinusoid, of free frequency, takes up the natural oscillation that a
  start from rest leaves in an undamped body.
- ``harmonic_phase``: atan2(b, a) of that fit in degrees, in [-180, 180): the response's lead over sin(omega t).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.results import sinusoid_fit as sinusoid

if TYPE_CHECKING:
    from warp_mps.scene import Measurement

CONTACT_THRESHOLD = 1e-9
# relative rounding of the time at which a run ends
END_ROUNDING = 1e-6
# Relative residual of the fit with one frequency below which a second frequency would fit noise.
NOTHING_LEFT = 1e-9


def evaluate(measurement: Measurement, times: np.ndarray, values: np.ndarray) -> float:
    """Draw a number from a history.

    Args:
        measurement: The measurement; see the module for each measure.
        times: Times, increasing [s], shape [m].
        values: Values of the probe's component, shape [m].

    Raises:
        ValueError: The history within the measurement's window does not determine the number.
    """
    times, values = _window(measurement, np.asarray(times, dtype=float), np.asarray(values, dtype=float))
    if measurement.measure.startswith("harmonic"):
        sine, cosine = _harmonic(times, values, 2.0 * np.pi * measurement.frequency)
        return _phase(sine, cosine) if measurement.measure == "harmonic_phase" else float(np.hypot(sine, cosine))
    if measurement.measure in _AT:
        assert measurement.at is not None
        return _AT[measurement.measure](times, values, measurement.at)
    value = _MEASURES[measurement.measure](times, values)
    return value / (2.0 * np.pi) if measurement.measure == "frequency" and measurement.unit == "Hz" else value


def used_until(measurement: Measurement, duration: float) -> float:
    """Time up to which a measurement uses the history of a run [s].

    A `time_at` only needs the history to begin: it is found as soon as the value is reached.

    Args:
        measurement: The measurement.
        duration: Duration of the case [s], at which the window of a measurement without an end closes. A window that
            is to end later is one of a case that was shortened, and is not covered.
    """
    if measurement.measure == "time_at":
        return measurement.start
    if measurement.measure == "value_at" and measurement.at is not None:
        return measurement.at
    return duration if measurement.end is None or np.isinf(measurement.end) else measurement.end


def require_history(measurement: Measurement, duration: float, end: float) -> None:
    """Require that a history goes as far as a measurement uses it.

    Args:
        measurement: The measurement.
        duration: Duration of the case [s].
        end: Time of the last row [s].

    Raises:
        ValueError: It ends earlier, as that of a run that has failed or was interrupted.
    """
    needed = used_until(measurement, duration)
    if end < needed * (1.0 - END_ROUNDING):
        raise ValueError(f"not reached: it needs the run up to {needed:g} s, which ended at {end:g} s")


def _window(measurement: Measurement, times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples between start and end, bounds included but for rounding."""
    end = np.inf if measurement.end is None else measurement.end
    slack = 1e-9 * (abs(times[-1]) if len(times) else 0.0)
    inside = (times >= measurement.start - slack) & (times <= end + slack)
    if not inside.any():
        until = "" if measurement.end is None else f" and before {end:g} s"
        raise ValueError(f"there is no sample after {measurement.start:g} s{until}")
    if not np.isfinite(values[inside]).all():
        raise ValueError("the history holds numbers that are not finite")
    return times[inside], values[inside]


def _frequency(times: np.ndarray, values: np.ndarray) -> float:
    omega = sinusoid.dominant(times, values)
    _require_period(times, omega)
    return omega


def _require_period(times: np.ndarray, omega: float) -> None:
    periods = omega * (times[-1] - times[0]) / (2.0 * np.pi)
    if periods < 1.0:
        raise ValueError(f"the window holds {periods:.2f} of a period; at least one is needed")


def _amplitude(times: np.ndarray, values: np.ndarray) -> float:
    (a, b, _), _ = sinusoid.fit(times, values, [_frequency(times, values)])
    return float(np.hypot(a, b))


def _offset(times: np.ndarray, values: np.ndarray) -> float:
    coefficients, _ = sinusoid.fit(times, values, [_frequency(times, values)])
    return float(coefficients[-1])


def _mean(times: np.ndarray, values: np.ndarray) -> float:
    if len(times) == 1:
        return float(values[0])
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(times)) / (times[-1] - times[0]))


def _restitution(times: np.ndarray, values: np.ndarray) -> float:
    if len(values) < 2 or values[0] == 0.0:
        raise ValueError("restitution needs a first value that is not zero, and a later one")
    return float(-values[-1] / values[0])


def _contact_time(times: np.ndarray, values: np.ndarray) -> float:
    sizes = np.abs(values)
    if sizes.max() == 0.0:
        raise ValueError("there was no contact")
    touching = times[sizes > CONTACT_THRESHOLD * sizes.max()]
    return float(touching[-1] - touching[0])


def _value_at(times: np.ndarray, values: np.ndarray, time: float) -> float:
    slack = 1e-9 * abs(times[-1])
    if not times[0] - slack <= time <= times[-1] + slack:
        raise ValueError(f"the history is from {times[0]:g} to {times[-1]:g} s, without {time:g} s")
    return float(np.interp(time, times, values))


def _time_at(times: np.ndarray, values: np.ndarray, value: float) -> float:
    above = values - value
    passed = np.flatnonzero(above * above[0] <= 0.0)
    if not len(passed):
        span = f"it is between {values.min():g} and {values.max():g}"
        raise ValueError(f"it does not reach {value:g} up to {times[-1]:g} s: {span}")
    k = int(passed[0])
    if k == 0:
        return float(times[0])
    return float(times[k - 1] + (times[k] - times[k - 1]) * above[k - 1] / (above[k - 1] - above[k]))


def _harmonic(times: np.ndarray, values: np.ndarray, omega: float) -> tuple[float, float]:
    """Coefficients of sin(omega t) and cos(omega t)."""
    sinusoid.require_samples(times)
    _require_period(times, omega)
    coefficients, residual = sinusoid.fit(times, values, [omega])
    if residual > NOTHING_LEFT**2 * float(np.sum(values**2)):
        second = sinusoid.dominant(times, values, beside=[omega])
        coefficients, _ = sinusoid.fit(times, values, [omega, second])
    return float(coefficients[0]), float(coefficients[1])


def _phase(sine: float, cosine: float) -> float:
    degrees = float(np.degrees(np.arctan2(cosine, sine)))
    return (degrees + 180.0) % 360.0 - 180.0


_AT = {"value_at": _value_at, "time_at": _time_at}
_MEASURES: dict[str, Callable[[np.ndarray, np.ndarray], float]] = {
    "frequency": _frequency,
    "period": lambda times, values: 2.0 * np.pi / _frequency(times, values),
    "amplitude": _amplitude,
    "offset": _offset,
    "mean": _mean,
    "minimum": lambda times, values: float(values.min()),
    "maximum": lambda times, values: float(values.max()),
    "midrange": lambda times, values: 0.5 * float(values.max() + values.min()),
    "half_range": lambda times, values: 0.5 * float(values.max() - values.min()),
    "final": lambda times, values: float(values[-1]),
    "restitution": _restitution,
    "contact_time": _contact_time,
}

"""Measures against signals whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.results.measures import evaluate
from warp_mps.scene import MEASURES, Measurement

OMEGA = 37.0


def draw(measure: str, times: np.ndarray, values: np.ndarray, **options: float | None) -> float:
    return evaluate(Measurement(name="m", measure=measure, probe="p", **options), times, values)  # type: ignore[arg-type]


def record(periods: float, samples: int, start: float = 0.1) -> np.ndarray:
    return np.linspace(start, start + periods * 2.0 * np.pi / OMEGA, samples)


@pytest.mark.parametrize("periods", [1.5, 1.7, 2.0, 2.3, 5.0, 20.3])
@pytest.mark.parametrize("samples", [80, 400])
@pytest.mark.parametrize("phase", [0.0, 1.1, 2.3, 4.0])
def test_frequency_and_amplitude_of_one_mode(periods: float, samples: int, phase: float) -> None:
    times = record(periods, samples)
    values = 0.3 + 2e-5 * np.cos(OMEGA * times + phase)
    assert draw("frequency", times, values) == pytest.approx(OMEGA, rel=1e-6)
    assert draw("amplitude", times, values) == pytest.approx(2e-5, rel=1e-6)


@pytest.mark.parametrize("periods", [1.5, 3.0, 10.0])
@pytest.mark.parametrize("ratio", [2.4, 6.27])
@pytest.mark.parametrize("phase", [0.0, 1.5, 3.0, 4.5])
def test_frequency_of_the_mode_that_dominates(periods: float, ratio: float, phase: float) -> None:
    times = record(periods, 300)
    values = np.cos(OMEGA * times) + 0.1 * np.cos(ratio * OMEGA * times + phase)
    assert draw("frequency", times, values) == pytest.approx(OMEGA, rel=0.3 * 0.1 / periods**2)


def test_frequency_of_unevenly_spaced_samples() -> None:
    times = record(3.0, 200) + np.random.default_rng(0).uniform(0.0, 1e-3, 200)
    assert draw("frequency", times, np.sin(OMEGA * times)) == pytest.approx(OMEGA, rel=1e-6)


def test_less_than_a_period_is_refused() -> None:
    times = record(0.6, 100)
    with pytest.raises(ValueError, match="of a period"):
        draw("frequency", times, np.cos(OMEGA * times))


def test_simple_measures_by_hand() -> None:
    times, values = np.array([0.0, 1.0, 3.0]), np.array([2.0, 4.0, -1.0])
    assert draw("mean", times, values) == pytest.approx((3.0 + 3.0) / 3.0)
    assert draw("minimum", times, values) == -1.0
    assert draw("maximum", times, values) == 4.0
    assert draw("final", times, values) == -1.0
    assert draw("restitution", times, values) == 0.5


def test_the_window_includes_its_bounds() -> None:
    times, values = np.array([0.0, 0.1, 0.2, 0.1 * 3, 0.4]), np.array([9.0, 1.0, 2.0, 3.0, 9.0])
    assert draw("maximum", times, values, start=0.1, end=0.3) == 3.0
    assert draw("mean", times, values, start=0.1, end=0.3) == pytest.approx(2.0)
    assert draw("mean", times, values, start=0.4) == 9.0


def test_contact_time_ignores_rounding() -> None:
    times = np.linspace(0.0, 1.0, 11)
    values = np.array([0, 1e-12, 0, -3, 5, 0, 2, 1e-3, 1e-12, 0, 0])
    assert draw("contact_time", times, values) == pytest.approx(0.4)


@pytest.mark.parametrize("ratio", [0.45, 0.8, 1.3, 2.7])
@pytest.mark.parametrize("lead", [-178.0, -90.0, 0.0, 35.0, 179.0])
def test_harmonic_response_beside_a_transient(ratio: float, lead: float) -> None:
    times = np.linspace(0.0, 2.0, 1500)
    drive = 2.0 * np.pi * 5.0
    values = 0.7 + 0.02 * np.sin(drive * times + np.radians(lead)) + 0.015 * np.cos(ratio * drive * times + 0.4)
    assert draw("harmonic_amplitude", times, values, frequency=5.0) == pytest.approx(0.02, rel=1e-6)
    assert draw("harmonic_phase", times, values, frequency=5.0) == pytest.approx(lead, abs=1e-4)


def test_harmonic_response_without_a_transient() -> None:
    times = np.linspace(0.0, 1.0, 300)
    values = -0.02 * np.sin(10.0 * np.pi * times)
    assert draw("harmonic_amplitude", times, values, frequency=5.0) == pytest.approx(0.02, rel=1e-9)
    assert abs(draw("harmonic_phase", times, values, frequency=5.0)) == pytest.approx(180.0, abs=1e-6)


@pytest.mark.parametrize("measure", MEASURES)
def test_every_measure_refuses_an_empty_window(measure: str) -> None:
    with pytest.raises(ValueError, match="no sample"):
        draw(measure, np.linspace(0.0, 1.0, 50), np.ones(50), start=5.0, frequency=3.0)


@pytest.mark.parametrize("measure", ["frequency", "amplitude", "harmonic_amplitude", "harmonic_phase"])
def test_fits_refuse_a_handful_of_samples(measure: str) -> None:
    with pytest.raises(ValueError, match="too few"):
        draw(measure, np.linspace(0.0, 1.0, 5), np.array([0.0, 1, 0, -1, 0]), frequency=3.0)


@pytest.mark.parametrize(
    ("measure", "values", "message"),
    [
        ("frequency", np.ones(50), "does not vary"),
        ("restitution", np.zeros(50), "not zero"),
        ("contact_time", np.zeros(50), "no contact"),
        ("mean", np.full(50, np.nan), "not finite"),
    ],
)
def test_histories_that_determine_nothing_are_refused(measure: str, values: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        draw(measure, np.linspace(0.0, 1.0, 50), values)


def test_the_middle_and_the_half_of_the_range() -> None:
    times, values = np.array([0.0, 1.0, 2.0, 3.0]), np.array([9.0, -1.0, 4.0, 2.0])
    options = {"name": "range", "probe": "tip", "start": 0.5}
    assert evaluate(Measurement(measure="midrange", **options), times, values) == 1.5
    assert evaluate(Measurement(measure="half_range", **options), times, values) == 2.5


def test_a_value_at_a_time() -> None:
    times, values = np.array([0.0, 1.0, 3.0]), np.array([2.0, 4.0, -1.0])
    assert [draw("value_at", times, values, at=at) for at in (0.0, 0.5, 2.0, 3.0)] == [2.0, 3.0, 1.5, -1.0]
    with pytest.raises(ValueError, match="from 0 to 3 s, without 4 s"):
        draw("value_at", times, values, at=4.0)


def test_the_first_time_of_a_value() -> None:
    times, values = np.array([0.0, 1.0, 3.0, 4.0]), np.array([2.0, 4.0, -1.0, 9.0])
    assert draw("time_at", times, values, at=2.0) == 0.0
    assert draw("time_at", times, values, at=3.0) == 0.5
    assert draw("time_at", times, values, at=4.0) == 1.0
    assert draw("time_at", times, values, at=1.5) == 2.0
    assert draw("time_at", times, values, at=3.0, start=1.0) == pytest.approx(1.4)
    with pytest.raises(ValueError, match="does not reach 10 up to 4 s: it is between -1 and 9"):
        draw("time_at", times, values, at=10.0)

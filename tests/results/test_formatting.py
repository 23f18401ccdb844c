"""Times and errors as text."""

from __future__ import annotations

import pytest

from warp_mps.results.formatting import duration, finite, memory, percent


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0123, "0.012 s"),
        (9.97, "10 s"),
        (99.0, "99 s"),
        (99.6, "100 s"),
        (113.0, "113 s"),
        (180.0, "3 min"),
        (9000.0, "2.5 h"),
    ],
)
def test_a_time_is_in_the_unit_that_suits_it(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("error", "text"), [(None, ""), (1e-15, "0 %"), (-0.0123, "-1.23 %"), (2e-6, "+2.0e-04 %"), (0.5, "+50.00 %")]
)
def test_an_error_is_in_per_cent(error: float | None, text: str) -> None:
    assert percent(error) == text


@pytest.mark.parametrize(
    ("size", "text"), [(1.5 * 2**20, "1.5 MiB"), (1023.0 * 2**20, "0.999 GiB"), (64.0 * 2**30, "64 GiB")]
)
def test_a_size_has_no_exponent(size: float, text: str) -> None:
    assert memory(size) == text


def test_what_json_has_not_is_none() -> None:
    assert finite({"a": [1.0, float("nan")], "b": (float("inf"), "c")}) == {"a": [1.0, None], "b": [None, "c"]}

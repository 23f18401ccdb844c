"""A run of many frames needs no more memory than one of few."""

from __future__ import annotations

import sys

import pytest

if not sys.platform.startswith("linux"):
    pytest.skip("resident memory is read where Linux has it", allow_module_level=True)

from tests.faults import soak


@pytest.mark.slow
def test_memory_does_not_grow() -> None:
    assert soak.main(["--case", "beam_second_mode", "--steps", "100000", "--memory-only"]) == 0


def test_growth_and_slowing_are_between_the_first_and_the_last_tenth() -> None:
    marks = [soak.Mark(100 * k, 2.0 * k + (k == 10), 1.0 * k + 0.5 * (k == 10), 1000 + k) for k in range(11)]
    meter = soak.Meter.__new__(soak.Meter)
    meter.marks = marks
    assert meter.growth() == pytest.approx(1010 / 1001 - 1.0)
    # half as slow again by both clocks
    assert meter.slowing() == pytest.approx(0.5)
    meter.marks[10] = soak.Mark(1000, 21.0, 10.0, 1010)
    assert meter.slowing() == pytest.approx(0.0)

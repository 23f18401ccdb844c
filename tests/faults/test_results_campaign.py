"""Forged and damaged results, some of each file: refused in one line, or read; and never continued to other rows."""

from __future__ import annotations

import sys

import pytest

if not sys.platform.startswith("linux"):
    pytest.skip("the watchdog reads what Linux tells of a process", allow_module_level=True)

from tests.faults import results_campaign
from tests.faults.result_mutations import MUTATIONS


@pytest.mark.long
def test_mutated_results_are_refused_in_a_line_or_are_results() -> None:
    outcomes = list(results_campaign.campaign(7, seed=1))
    assert [outcome for outcome in outcomes if outcome.fault] == []
    assert {outcome.file for outcome in outcomes} == set(MUTATIONS)
    codes = [outcome.code for outcome in outcomes]
    assert min(codes.count(0), codes.count(2)) > 0.1 * len(codes)


@pytest.mark.slow
def test_the_long_campaign_finds_no_fault() -> None:
    assert results_campaign.main(500) == 0

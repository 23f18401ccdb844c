"""Signals at random moments, a few: programs end as they should, and what they leave continues to the same results."""

from __future__ import annotations

import sys

import pytest

if not sys.platform.startswith("linux"):
    pytest.skip("signals are sent as Linux does", allow_module_level=True)

from tests.faults import signals_campaign

pytestmark = pytest.mark.usefixtures("interruptible")


@pytest.mark.long
def test_runs_that_get_a_signal_at_any_moment_keep_their_results() -> None:
    outcomes = list(signals_campaign.campaign(1, seed=1))
    assert [outcome for outcome in outcomes if outcome.fault] == []
    assert any(outcome.kept == "failed" for outcome in outcomes)
    assert all(outcome.code == 0 for outcome in outcomes if outcome.signal == "SIGPIPE")


@pytest.mark.slow
def test_the_long_campaign_finds_no_fault() -> None:
    assert signals_campaign.main(25) == 0

"""Random scenes of water and bodies, some of them: nothing goes wrong silently."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults import random_scenes


@pytest.mark.long
def test_random_scenes_hide_nothing() -> None:
    outcomes = list(random_scenes.campaign(16, seed=5))
    assert [outcome for outcome in outcomes if outcome.silent] == []
    assert sum(outcome.code == 0 for outcome in outcomes) >= 12


@pytest.mark.slow
def test_the_long_campaign_hides_nothing() -> None:
    assert random_scenes.main(200) == 0


def test_the_reading_sees_what_is_wrong(tmp_path: Path) -> None:
    """A sound result, read as if the floor lay higher, and as if the water had to rest within a hundredth."""
    scene, _ = random_scenes.make(9, seed=0)
    outcome = random_scenes.run(9, tmp_path / "run", seed=0)
    assert (outcome.code, outcome.faults) == (0, ())
    raised = random_scenes.lifted(scene, 0.02)
    faults = list(random_scenes.find_faults(raised, tmp_path / "run", rests=False))
    assert any("water particles in floor" in fault for fault in faults)


def test_energy_that_a_body_gives_the_water_is_remarked(tmp_path: Path) -> None:
    """A free block rolls in water that rests: the water rises by a fifth of a spacing."""
    outcome = random_scenes.run(82, tmp_path / "run", seed=0)
    assert any("energy has grown" in fault for fault in outcome.faults)
    assert any(line.startswith("the energy balance has grown by 0.") for line in outcome.remarks)
    assert not outcome.silent

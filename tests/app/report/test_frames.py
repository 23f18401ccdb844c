"""Data for the player: positions, quantities, ranges, omissions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.app.report.runs import write_water
from tests.app.results import SPACE, write_result
from warp_mps.app.animation_reader import Animation
from warp_mps.app.cli import main
from warp_mps.app.report import bounds as room
from warp_mps.app.report import frames as module
from warp_mps.app.report.frames import make_frames
from warp_mps.app.report.quantities import range_of


def test_a_plane_is_shown_upright_and_in_si_units(tmp_path: Path) -> None:
    write_result(tmp_path)
    facts = make_frames(Animation(tmp_path)).facts
    assert facts["axes"] == "xz"
    # a block of 4 by 2 that rises by 0.04 m, and a floor of 6 by 2, both in cells of 0.1 m
    assert facts["low"] == pytest.approx([-0.25, -0.45])
    assert facts["high"] == pytest.approx([0.25, 0.09])
    assert facts["times"] == pytest.approx([0.0, 0.01, 0.02])
    block, floor = facts["clouds"]
    assert (block["name"], block["role"], block["count"], block["width"]) == ("block", "body", 8, pytest.approx(0.1))
    assert (block["places"]["frames"], floor["places"]["frames"]) == (3, 1)
    assert floor["values"] == {}


def test_tensors_are_shown_by_components_in_the_plane_and_principal_values(tmp_path: Path) -> None:
    write_result(tmp_path)
    found = {item["name"]: item for item in make_frames(Animation(tmp_path)).facts["quantities"]}
    stress = [name for name in found if name.startswith("stress")]
    assert stress == ["stress greatest principal", "stress least principal"] + [
        f"stress {n}" for n in ("xx", "yy", "zz", "xz")
    ]
    assert found["stress xx"]["least"] == found["stress xx"]["greatest"] == pytest.approx(1.0)
    assert found["stress xz"]["least"] == pytest.approx(4.0)
    # of [[1, 4], [4, 2]]
    assert found["stress greatest principal"]["greatest"] == pytest.approx(1.5 + np.sqrt(16.25))
    assert found["stress least principal"]["least"] == pytest.approx(1.5 - np.sqrt(16.25))
    assert (found["pressure"]["least"], found["pressure"]["greatest"]) == (0.0, 702.0)
    assert (found["speed"]["greatest"], found["speed"]["unit"]) == (pytest.approx(2.0), "m/s")
    assert (found["displacement"]["greatest"], found["displacement"]["unit"]) == (pytest.approx(0.04), "m")
    assert found["von_mises"]["title"] == "von Mises stress"
    assert found["von_mises"]["unit"] == "Pa"


def test_space_has_three_axes_and_all_shears(tmp_path: Path) -> None:
    write_result(tmp_path, frame=SPACE)
    facts = make_frames(Animation(tmp_path)).facts
    assert (facts["axes"], facts["dimension"], facts["up"]) == ("xyz", 3, "Z")
    assert {f"stress {name}" for name in ("xy", "xz", "yz")} < {item["name"] for item in facts["quantities"]}


def test_what_is_too_much_is_left_out_and_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_result(tmp_path, frames=9)
    monkeypatch.setattr(module, "MOST_POSITIONS", 40)
    monkeypatch.setattr(module, "MOST_VALUES", 100)
    frames = make_frames(Animation(tmp_path))
    # 8 particles in every other frame, and of those two quantities
    assert frames.facts["times"] == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.08])
    assert [item["name"] for item in frames.facts["quantities"]] == ["speed", "pressure"]
    assert frames.remarks[0] == "5 of the 9 frames of run.usdc are shown."
    assert "von Mises stress, displacement, stress greatest principal" in frames.remarks[1]


def test_particles_that_are_nowhere_are_left_out(tmp_path: Path) -> None:
    write_water(tmp_path)
    frames = make_frames(Animation(tmp_path))
    assert frames.remarks == ["Particles that fly far off are left out of the picture."]
    assert frames.facts["axes"] == "xy"
    assert frames.facts["high"] == pytest.approx([0.35, 0.25])
    assert frames.facts["first"] == "pressure"
    assert [item["name"] for item in frames.facts["quantities"]] == ["speed", "pressure"]


def test_a_run_of_which_nothing_is_anywhere_has_a_page(tmp_path: Path) -> None:
    write_water(tmp_path, nowhere=True)
    frames = make_frames(Animation(tmp_path))
    assert frames.facts["seen"] == [frames.facts["low"], frames.facts["high"]] == [[0.0] * 2, [1.0] * 2]
    assert main(["report", str(tmp_path)]) == 0


def test_a_drop_that_flies_far_does_not_make_the_rest_small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_water(tmp_path)
    # of 4 frames of 48 particles a percent is two
    monkeypatch.setattr(room, "DROPS", 1.0)
    facts = make_frames(Animation(tmp_path)).facts
    # the wall counts as a whole
    assert facts["seen"][0] == pytest.approx([-0.35, -0.55])
    assert facts["seen"][1] == pytest.approx([0.35, 0.25])
    monkeypatch.setattr(room, "DROPS", 20.0)
    facts = make_frames(Animation(tmp_path)).facts
    assert facts["seen"][1] == pytest.approx([0.35, 0.15])


def test_colours_stand_for_what_is_usual() -> None:
    values = np.concatenate([np.linspace(0.0, 1.0, 2000), [50.0]])
    usual = range_of(values)
    assert (usual.least, usual.greatest, usual.signed) == (0.0, 50.0, False)
    assert usual.shown == (0.0, 1.0)
    both = range_of(np.linspace(-2.0, 1.0, 100))
    assert (both.shown, both.signed) == ((-2.0, 2.0), True)
    assert range_of(np.zeros(3)).shown == (0.0, 1.0)
    assert range_of(np.array([np.nan])).shown == (0.0, 1.0)

"""The shipped stages: each is sound, can be read, and runs at reduced size."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warp_mps.results.history import read_history
from warp_mps.run.run import run_scene
from warp_mps.scene import Scene
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.shipped_cases import shipped_cases

CASES = shipped_cases()
PROMISED = (
    *("beam_first_mode", "beam_first_mode_as_published", "beam_second_mode", "beam_second_mode_as_published"),
    *("bar_struck_by_wall", "paddle_and_block"),
    *("free_free_bar_3d", "twisting_column_3d", "rubber_drop_3d", "sandwich_cantilever"),
    *("hydrostatic_tank", "standing_wave", "sloshing_tank", "dam_break", "dam_break_3d", "elliptical_drop"),
    *("taylor_green", "square_patch"),
    *("water_column_on_plate", "dam_break_elastic_gate", "dam_break_elastic_gate_3d", "floating_elastic_plate"),
    *("elastic_panel_slamming", "sloshing_elastic_baffle"),
    *(
        "block_on_elastic_base",
        "block_on_wall",
        "mass_spring_forced",
        "mass_spring_free",
        "ring_collision",
        "ring_collision_gray",
        "turek_csm1",
        "turek_csm3",
    ),
)
# what takes seconds even for a few frames
LARGE = ("free_free_bar_3d", "beam_first_mode", "beam_second_mode", "twisting_column_3d")


def test_what_is_shipped() -> None:
    assert set(PROMISED) <= set(CASES)


@pytest.mark.parametrize("name", CASES)
def test_references_say_where_they_come_from(name: str) -> None:
    scene = read_stage(CASES[name])
    assert scene.description
    assert scene.remarks == ()
    assert scene.measurements
    assert all(item.source for item in scene.measurements if item.reference is not None)


@pytest.mark.parametrize("name", CASES)
def test_stages_pass_usd_validation(name: str) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    from pxr import Usd

    context = validation.ValidationContext(validation.ValidationRegistry().GetOrLoadAllValidators())
    errors = context.Validate(Usd.Stage.Open(str(CASES[name])))
    assert [error.GetErrorAsString() for error in errors] == []


@pytest.mark.parametrize("name", CASES)
def test_stages_run_at_reduced_size(name: str, tmp_path: Path) -> None:
    """A few frames, without the reference values, which belong to the whole run."""
    scene = read_stage(CASES[name])
    rate = scene.load_steps if scene.analysis == "static" else scene.frame_rate
    scene = replace(scene, measurements=(), duration=3.0 / rate)
    scene = _coarse_fluids(scene) if scene.fluids else _coarse_bodies(scene, name)
    short = scene.duration
    summary = run_scene(scene, tmp_path, quiet=True)
    assert summary.status == "done"
    assert summary.time == pytest.approx(short)
    # what fluids lose to viscosity and in impacts is in no account
    assert scene.fluids or abs(summary.energy["drift"] or 0.0) < 0.01
    assert summary.fluid.get("unsolved", 0) == summary.fluid.get("lost", 0) == 0
    history = read_history(tmp_path / "probes.csv")
    assert np.isfinite(history.rows).all()
    assert history.last_time == pytest.approx(short)


def _coarse_bodies(scene: Scene, name: str) -> Scene:
    coarse = tuple(replace(body, spacing=_coarser(name) * body.spacing) for body in scene.bodies)
    return replace(scene, bodies=coarse, time_step=_time_step(name))


def _coarse_fluids(scene: Scene) -> Scene:
    """Twice the spacing of fluids and walls; in space, and about bodies, which stay as they are, a few steps."""
    if scene.dimension == 3 or scene.bodies:
        rate = 10.0 * scene.frame_rate
        scene = replace(scene, frame_rate=rate, sample_rate=None, duration=0.1 * scene.duration)
    if scene.bodies:
        return scene
    fluids = tuple(replace(fluid, spacing=2.0 * fluid.spacing) for fluid in scene.fluids)
    return replace(scene, fluids=fluids, walls=tuple(replace(wall, spacing=2.0 * wall.spacing) for wall in scene.walls))


def _coarser(name: str) -> float:
    return 2.0 if name in LARGE else 1.0


def _time_step(name: str) -> float | None:
    return 1e-5 if name == "ring_collision" else None

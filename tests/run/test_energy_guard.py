"""The guard on the energy of water, in runs: schemes that stir it, and runs in parts."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from warp_mps.errors import RunError
from warp_mps.results.history import read_history
from warp_mps.run.run import run_scene
from warp_mps.scene import Flow, Fluid, Scene, VelocityField, tank
from warp_mps.shapes import Box

DEPTH, ROWS = 0.25, 10
L0 = DEPTH / ROWS


def pond(scheme: str, *, columns: int = ROWS, **fields: object) -> Scene:
    """A tank of still water of 10 rows of particles."""
    width = columns * L0
    water = Fluid(name="water", shape=Box.from_corners((0.0, 0.0), (width, DEPTH)), spacing=L0)
    given = {"gravity": (0.0, -9.81), "duration": 1.0, "frame_rate": 10.0, "sample_rate": 50.0, **fields}
    return Scene(fluids=(water,), walls=tank((0.0, 0.0), (width, 0.35), L0), flow=Flow(scheme=scheme), **given)  # type: ignore[arg-type]


def wave(scheme: str, **fields: object) -> Scene:
    """A standing wave in a tank of 0.5 m, with an amplitude of 4 % of the depth."""
    scene = pond(scheme, columns=2 * ROWS, sample_rate=100.0, **fields)
    start = VelocityField(
        kind="standing_wave", amplitude=(0.0, 0.075187), axis=(1.0, 0.0), origin=(0.0, 0.0), length=1.0, depth=DEPTH
    )
    (water,) = scene.fluids
    return replace(scene, fluids=(replace(water, velocity_field=start),))


@pytest.mark.parametrize("scheme", ["corrected", "koshizuka_oka"])
def test_a_scheme_that_stirs_still_water_ends_the_run_and_the_remedy_works(scheme: str, tmp_path: Path) -> None:
    duration = 4.0 if scheme == "koshizuka_oka" else 1.0
    with pytest.raises(RunError) as caught:
        run_scene(pond(scheme, duration=duration), tmp_path / "out", quiet=True)
    assert str(caught.value).endswith(
        f"the scheme '{scheme}' does not conserve momentum, and stirs water beside walls and below a free surface: "
        "take 'conservative'"
    )
    assert run_scene(pond("conservative", duration=duration), tmp_path / "other", quiet=True).status == "done"


def test_an_effective_radius_that_lifts_still_water_is_named(tmp_path: Path) -> None:
    """With the default the same tank rests; see above."""
    scene = replace(pond("conservative", duration=4.0), flow=Flow(effective_radius=1.5))
    cause = r"the effective radius of 1\.5 spacings is below the default of 3\.1: leave it out$"
    with pytest.raises(RunError, match=cause):
        run_scene(scene, tmp_path, quiet=True)


def test_still_water_rests_at_the_largest_cfl_number(tmp_path: Path) -> None:
    """It was lifted when the pressure was evaluated at predicted positions."""
    scene = replace(pond("conservative", duration=4.0), flow=Flow(courant=1.0))
    summary = run_scene(scene, tmp_path, quiet=True)
    assert summary.status == "done"
    assert summary.energy["kinetic"] < 2e-4 * 1000.0 * 9.81 * DEPTH**3


def full(**flow: object) -> Scene:
    """A tank of still water that it fills up to its lid."""
    scene = pond("conservative", duration=4.0)
    walls = tank((0.0, 0.0), (ROWS * L0, DEPTH), L0, open=())
    return replace(scene, walls=walls, flow=Flow(**flow))  # type: ignore[arg-type]


def test_water_that_fills_its_walls_rests_in_the_other_scheme(tmp_path: Path) -> None:
    expected = (
        "the scheme 'conservative' with negative pressures 'clipped' stirs a fluid that fills its walls: take "
        "'corrected' and 'allowed'"
    )
    with pytest.raises(RunError) as caught:
        run_scene(full(), tmp_path / "out", quiet=True)
    assert str(caught.value).endswith(expected)
    remedy = full(scheme="corrected", negative_pressure="allowed")
    assert run_scene(remedy, tmp_path / "other", quiet=True).energy["kinetic"] < 1e-4


def test_a_wave_that_grows_ends_the_run(tmp_path: Path) -> None:
    """It had 23 times its energy after 3 s."""
    with pytest.raises(RunError, match=r"take 'conservative'$"):
        run_scene(wave("corrected", duration=3.0), tmp_path / "out", quiet=True)
    first, *_, last = read_history(tmp_path / "out" / "probes.csv").energies()
    assert last.balance < 15.0 * first.balance
    summary = run_scene(wave("conservative", duration=3.0), tmp_path / "other", quiet=True)
    assert summary.status == "done"


def test_a_run_in_parts_stops_at_the_moment_of_the_run_in_one(tmp_path: Path) -> None:
    def end(*durations: float) -> tuple[str, float]:
        folder = tmp_path / str(len(durations))
        for k, duration in enumerate(durations[:-1]):
            run_scene(pond("corrected", duration=duration), folder, quiet=True, resume=k > 0)
        last = pond("corrected", duration=durations[-1])
        with pytest.raises(RunError) as caught:
            run_scene(last, folder, quiet=True, resume=len(durations) > 1)
        return str(caught.value), json.loads((folder / "run.json").read_text())["time"]

    whole = end(1.0)
    assert "energy" in whole[0]
    parts = [round(0.02 * k, 2) for k in range(3, 20, 3)]
    assert end(*[part for part in parts if part < whole[1]], 1.0) == whole

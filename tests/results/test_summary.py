"""run.json: writing, reading back, measurements and energies."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from tests.observers.views import blocks
from warp_mps.errors import InputError
from warp_mps.results.history import TIME_LABEL, History, energy_labels
from warp_mps.results.summary import RunSummary, energy_record, measurement_rows, read_summary
from warp_mps.scene import Measurement, Probe, Scene


def scene(*measurements: Measurement, duration: float = 0.2) -> Scene:
    made = blocks(probes=(Probe(name="tip", point=(0.0, 0.0)),), measurements=measurements)
    return replace(made, duration=duration)


def history(*energies: tuple[float, ...]) -> History:
    """A tip that goes 1, 3, 2 along y, in a run with given energies."""
    rows = [
        (0.1 * k, 0.0, y, *energy)
        for k, (y, energy) in enumerate(zip((1.0, 3.0, 2.0), energies or [(0.0,) * 6] * 3, strict=True))
    ]
    return History([TIME_LABEL, "tip.x [m]", "tip.y [m]", *energy_labels(2)], rows)


def row(duration: float = 0.2, **options: object) -> dict:
    options = {"measure": "maximum", "component": 1, "unit": "m", "source": "by hand"} | options
    measurement = Measurement(name="rise", probe="tip", **options)  # type: ignore[arg-type]
    (result,) = measurement_rows(scene(measurement, duration=duration), history())
    return result


def test_a_measurement_is_compared_with_its_reference() -> None:
    expected = {"name": "rise", "value": 3.0, "unit": "m", "reference": 4.0, "error": -0.25, "source": "by hand"}
    drawn = {"measure": "maximum", "column": "tip.y [m]", "window": [0.0, None], "at": None}
    assert row(reference=4.0) == {**expected, **drawn}


def test_errors_are_signed_and_relative_to_the_size_of_the_reference() -> None:
    assert row(reference=-2.0)["error"] == 2.5
    assert row(reference=0.0)["error"] is None
    assert row(reference=None)["error"] is None


@pytest.mark.parametrize(
    ("options", "needed"),
    [
        *(({"measure": measure}, 2.0) for measure in ("maximum", "mean", "final", "offset", "half_range")),
        ({"measure": "minimum", "end": 1.5}, 1.5),
        ({"measure": "value_at", "at": 0.3}, 0.3),
        ({"measure": "time_at", "at": 2.0, "unit": "s", "start": 0.5}, 0.5),
    ],
)
def test_a_run_that_ended_early_is_not_compared_with_a_reference_for_later(options: dict, needed: float) -> None:
    """Of a case of 2 s there is a history of 0.2 s."""
    result = row(duration=2.0, reference=1.0, **options)
    assert (result["value"], result["error"]) == (None, None)
    assert result["reason"] == f"not reached: it needs the run up to {needed:g} s, which ended at 0.2 s"


@pytest.mark.parametrize("measure", ["maximum", "mean", "frequency", "contact_time"])
def test_a_window_beyond_the_duration_of_a_shortened_case_is_not_covered(measure: str) -> None:
    unit = {"frequency": "rad/s", "contact_time": "s"}.get(measure, "m")
    result = row(duration=0.2, reference=1.0, measure=measure, unit=unit, end=2.0)
    assert (result["value"], result["error"]) == (None, None)
    assert result["reason"] == "not reached: it needs the run up to 2 s, which ended at 0.2 s"


def test_a_window_without_an_end_closes_with_the_run() -> None:
    assert row(duration=0.2, end=math.inf)["value"] == row(duration=0.2)["value"] == 3.0


def test_what_a_run_that_ended_early_has_covered_counts() -> None:
    assert row(duration=2.0, end=0.1)["value"] == 3.0
    assert row(duration=2.0, measure="value_at", at=0.05)["value"] == pytest.approx(2.0)
    assert row(duration=2.0, measure="time_at", at=2.0, unit="s")["value"] == pytest.approx(0.05)


@pytest.mark.parametrize("options", [{"measure": "frequency", "unit": "rad/s"}, {"start": 0.17, "end": 0.19}])
def test_what_cannot_be_drawn_has_no_value_and_says_why(options: dict) -> None:
    result = row(reference=1.0, **options)
    assert result["value"] is None
    assert result["error"] is None
    assert result["reason"]


def test_energies_and_their_drift() -> None:
    # kinetic, elastic, contact, potential, work, dissipated; the balance is 1, 0.5, 2 and at most 5 is exchanged
    record = energy_record(history((0, 0, 0, 1, 0, 0), (2, 1, 1, 1, 5, 0.5), (3, 1, 1, 1, 4.5, 0.5)))
    assert record == {
        "kinetic": 3,
        "elastic": 1,
        "contact": 1,
        "potential": 1,
        "work": 4.5,
        "dissipated": 0.5,
        "unaccounted": -1.0,
        "drift": pytest.approx(1.0 / 5.0),
    }


def test_what_fluids_lose_is_unaccounted() -> None:
    """The balance falls from 1 to 0.5, beside what damping has taken; that is the last number of the history."""
    rows = (0, 0, 0, 1, 0, 0), (2, 0, 0, 1, 4, 0.25), (3, 0, 0, 1, 4, 0.5)
    record = energy_record(history(*rows), fluids=True)
    assert (record["dissipated"], record["unaccounted"], record["drift"]) == (0.5, 0.5, None)
    kept = energy_record(history(*rows))
    assert (kept["unaccounted"], kept["drift"]) == (0.5, pytest.approx(1.75 / 4.0))


def test_a_scene_at_rest_does_not_drift() -> None:
    assert energy_record(history())["drift"] == 0.0
    assert energy_record(History(history().labels)) == {}


def test_a_summary_in_words() -> None:
    summary = RunSummary(
        case="beam",
        status="done",
        steps=50,
        time=0.5,
        wall_seconds=2.0,
        particles={"beam": 1024},
        particle_steps_per_second={"solid": 1e7, "fluid": None},
        measurements=[row(reference=1.0), row(measure="time_at", unit="s", at=1e9)],
        energy={"kinetic": 1.0, "potential": 0.0, "drift": 1e-9},
    )
    lines = str(summary).splitlines()
    assert lines[0].startswith("beam: 50 steps, 0.5 s simulated in 2 s (10 million particle-steps a second), energy dr")
    assert lines[0].endswith("; done")
    assert lines[1:3] == ["particles: beam 1024", "energy [J/m]: kinetic 1"]
    assert "(reference 1, " in lines[3]
    assert "does not reach 1e+09 up to 0.2 s" in lines[4]


def test_a_summary_reads_back(tmp_path: Path) -> None:
    summary = RunSummary(
        case="beam",
        status="done",
        particles={"beam": 1024},
        particle_steps_per_second={"solid": 1e7, "fluid": None},
        measurements=[row()],
        energy={"kinetic": 1.0, "drift": 1e-9},
        momentum_error=1e-15,
    )
    summary.write(tmp_path / "run.json")
    assert read_summary(tmp_path / "run.json") == summary
    assert [path.name for path in tmp_path.iterdir()] == ["run.json"]


def test_a_folder_that_was_removed_is_not_made_anew(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        RunSummary(case="beam").write(tmp_path / "gone" / "run.json")
    assert not (tmp_path / "gone").exists()


def test_numbers_that_are_not_finite_become_null(tmp_path: Path) -> None:
    summary = RunSummary(case="beam", status="failed", energy={"kinetic": math.nan, "drift": math.inf})
    summary.measurements = [{"name": "a", "value": -math.inf}]
    summary.write(tmp_path / "run.json")

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    data = json.loads((tmp_path / "run.json").read_text(), parse_constant=refuse)
    assert data["energy"] == {"kinetic": None, "drift": None}
    assert data["measurements"] == [{"name": "a", "value": None}]


def test_keys_of_later_versions_are_passed_over(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text('{"case": "beam", "status": "running", "colour": "red"}')
    assert read_summary(tmp_path / "run.json") == RunSummary(case="beam")


@pytest.mark.parametrize("text", [None, "{", "[]", '{"case": "beam"}', '{"case": "beam", "status": "lost"}'])
def test_files_that_are_no_summary_are_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "run.json").write_text(text)
    with pytest.raises(InputError, match=r"^\S*run\.json: "):
        read_summary(tmp_path / "run.json")

"""A run in a folder: continued, interrupted, and ended by errors of every kind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.scenes import beam, block, ends, scene_of
from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, View
from warp_mps.observers.probes import ProbeRecorder
from warp_mps.results.history import read_history
from warp_mps.results.summary import read_summary
from warp_mps.run.run import run_scene
from warp_mps.scene import Elasticity, HarmonicMotion, HarmonicRotation, Probe, Scene, Support, Wall
from warp_mps.shapes import Box

PROBE = Probe(name="tip", point=(0.15, 0.0))


@pytest.fixture
def scene() -> Scene:
    """A cantilever that falls; frames every 1 ms, rows every 0.5 ms."""
    clamp = Support(name="clamp", region=ends(0.006)[0])
    return beam(
        4,
        supports=(clamp,),
        probes=(PROBE,),
        gravity=(0.0, -9.81),
        duration=0.005,
        frame_rate=1000.0,
        sample_rate=2000.0,
        elasticity=Elasticity(),
    )


def frames(folder: Path) -> dict[float, np.ndarray]:
    """Points of every frame, by time code."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(folder / "run.usdc"))
    points = stage.GetPrimAtPath("/Result/beam").GetAttribute("points")
    return {code: np.array(points.Get(code)) for code in points.GetTimeSamples()}


@pytest.mark.parametrize("first", [0.002, 0.0023, 0.00271])
def test_a_run_in_two_parts_is_the_run_in_one(scene: Scene, tmp_path: Path, first: float) -> None:
    """Also where the first part ends off the grid of frames and rows, and so has one of each too many."""
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    run_scene(scene, whole, quiet=True)
    run_scene(replace(scene, duration=first), parts, quiet=True)
    assert len(frames(parts)) < len(frames(whole))
    run_scene(scene, parts, quiet=True, resume=True)
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    assert frames(whole).keys() == frames(parts).keys()
    assert all(np.array_equal(points, frames(parts)[code]) for code, points in frames(whole).items())
    assert read_summary(parts / "run.json").steps == read_summary(whole / "run.json").steps


def test_a_run_is_not_resumed_to_before_its_checkpoint(scene: Scene, tmp_path: Path) -> None:
    run_scene(scene, tmp_path, quiet=True)
    with pytest.raises(InputError, match=r"cannot be resumed: its checkpoint is at 0\.005 s, past the end of 0\.002 s"):
        run_scene(replace(scene, duration=0.002), tmp_path, quiet=True, resume=True)
    assert read_summary(tmp_path / "run.json").status == "done"


@pytest.mark.parametrize("damage", [b"\xff\xfe", b"time [s]\n1,2\n"])
def test_damaged_rows_are_refused_on_resume(scene: Scene, tmp_path: Path, damage: bytes) -> None:
    run_scene(scene, tmp_path, quiet=True)
    (tmp_path / "probes.csv").write_bytes(damage)
    with pytest.raises(InputError, match=r"probes\.csv: "):
        run_scene(replace(scene, duration=0.01), tmp_path, quiet=True, resume=True)


@pytest.mark.parametrize(
    ("error", "raised", "reason"),
    [
        (RuntimeError("out of memory"), RuntimeError, "RuntimeError('out of memory')"),
        (OSError(28, "No space left on device", "probes.csv"), RunError, "cannot be written: No space left on device"),
        (RunError("stop"), RunError, "stop"),
        (KeyboardInterrupt(), KeyboardInterrupt, "interrupted; continue with --resume"),
    ],
)
def test_the_summary_says_how_a_run_ended(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, raised: type, reason: str
) -> None:
    observe = ProbeRecorder.observe

    def break_later(self: ProbeRecorder, view: object) -> None:
        observe(self, view)  # type: ignore[arg-type]
        if len(self.history.rows) == 5:
            raise error

    monkeypatch.setattr(ProbeRecorder, "observe", break_later)
    with pytest.raises(raised):
        run_scene(scene, tmp_path, quiet=True)
    summary = read_summary(tmp_path / "run.json")
    assert summary.status == "failed"
    assert reason in summary.reason
    assert summary.steps > 0
    assert read_history(tmp_path / "probes.csv").last_time > 0.0


@pytest.mark.parametrize("name", ["probes.csv", "run.usdc"])
def test_a_run_is_not_resumed_with_a_gap(scene: Scene, tmp_path: Path, name: str) -> None:
    """The rows or frames end before the checkpoint, as after a loss of power or a mix of two runs' files."""
    early, late = tmp_path / "early", tmp_path / "late"
    run_scene(replace(scene, duration=0.002), early, quiet=True)
    run_scene(replace(scene, duration=0.004), late, quiet=True)
    (late / name).write_bytes((early / name).read_bytes())
    with pytest.raises(InputError, match=rf"{name}: lacks the (row|frame) at .* to continue from"):
        run_scene(scene, late, quiet=True, resume=True)


def test_a_damaged_checkpoint_is_one_line_and_a_longer_way(
    scene: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    run_scene(scene, whole, quiet=True)
    run_scene(replace(scene, duration=0.003), parts, quiet=True, checkpoint_interval=0.0)
    (parts / "checkpoint.npz").write_bytes((parts / "checkpoint.npz").read_bytes()[:-100])
    run_scene(scene, parts, quiet=True, resume=True)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("checkpoint.npz is damaged; going on from checkpoint.prev.npz, at 0.002 s")
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    assert frames(whole).keys() == frames(parts).keys()


def test_an_interval_that_is_none_is_refused(scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="checkpoint_interval: is -1, must be 0 or more seconds"):
        run_scene(scene, tmp_path / "out", checkpoint_interval=-1.0)


def test_overwriting_leaves_nothing_of_the_run_before(scene: Scene, tmp_path: Path) -> None:
    run_scene(scene, tmp_path, quiet=True)
    run_scene(replace(scene, duration=0.001), tmp_path, quiet=True, overwrite=True)
    assert len(frames(tmp_path)) == 2
    assert read_history(tmp_path / "probes.csv").last_time == pytest.approx(0.001)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["checkpoint.npz", "probes.csv", "run.json", "run.usdc"]


def test_what_is_refused_leaves_no_folder_and_no_file(scene: Scene, tmp_path: Path) -> None:
    outside = replace(scene, probes=(Probe(name="far", point=(9.0, 9.0)),))
    with pytest.raises(InputError, match="lies outside every body"):
        run_scene(outside, tmp_path / "new", quiet=True)
    assert not (tmp_path / "new").exists()
    run_scene(scene, tmp_path / "old", quiet=True)
    before = {path.name: path.read_bytes() for path in (tmp_path / "old").iterdir()}
    with pytest.raises(InputError, match="lies outside every body"):
        run_scene(outside, tmp_path / "old", quiet=True, overwrite=True)
    assert {path.name: path.read_bytes() for path in (tmp_path / "old").iterdir()} == before


def test_a_resumed_run_must_be_of_the_same_case(scene: Scene, tmp_path: Path) -> None:
    run_scene(replace(scene, duration=0.002), tmp_path, quiet=True)
    with pytest.raises(InputError, match="checkpoint"):
        run_scene(replace(scene, gravity=(0.0, -1.0)), tmp_path, quiet=True, resume=True)


@pytest.fixture
def struck() -> Scene:
    """A block that a wall strikes, displaced and turned; frames every 1 ms, rows every 0.5 ms."""
    wall = Wall(
        name="racket", shape=Box((0.02, 0.06), (-0.031, 0.0)), spacing=0.01,
        motion=HarmonicMotion(amplitude=(0.01, 0.0), frequency=20.0),
        rotation=HarmonicRotation(amplitude=0.3, frequency=20.0, pivot=(-0.03, 0.0)),
    )  # fmt: skip
    quantities = ("position", "displacement", "velocity", "extent", "contact_force")
    probes = [Probe(name=f"wall_{quantity}", quantity=quantity, body="racket") for quantity in quantities]
    probes += [Probe(name="momentum", quantity="momentum", body="block")]
    return scene_of(block(2), walls=(wall,), probes=tuple(probes), duration=0.01, frame_rate=1000.0, sample_rate=2000.0)


def test_what_probes_record_of_a_wall(struck: Scene, tmp_path: Path) -> None:
    run_scene(struck, tmp_path, quiet=True)
    history = read_history(tmp_path / "probes.csv")
    phase = 2.0 * np.pi * 20.0 * history.times
    shift = 0.01 * np.sin(phase)
    # the centre of the wall is 1 mm from its pivot
    turn = 0.3 * np.sin(phase)
    arm = -0.001 * np.column_stack((np.cos(turn), np.sin(turn)))
    expected = np.array([-0.03, 0.0]) + arm + np.column_stack((shift, np.zeros(len(shift))))
    speed = np.gradient(expected, history.times, axis=0, edge_order=2)
    for axis in (0, 1):
        np.testing.assert_allclose(history.probe("wall_position", axis), expected[:, axis], atol=1e-9)
        np.testing.assert_allclose(
            history.probe("wall_displacement", axis), (expected - expected[0])[:, axis], atol=1e-9
        )
        np.testing.assert_allclose(history.probe("wall_velocity", axis), speed[:, axis], atol=0.01)
    np.testing.assert_allclose(history.probe("wall_extent", 1)[0], 0.06)
    force, momentum = history.probe("wall_contact_force", 0), history.probe("momentum", 0)
    assert momentum[-1] > 1.0
    assert force.min() < 0.0
    assert (force <= 0.0).all()


def test_a_run_with_a_moving_wall_in_two_parts_is_the_run_in_one(struck: Scene, tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    summary = run_scene(struck, whole, quiet=True)
    run_scene(replace(struck, duration=0.0043), parts, quiet=True)
    run_scene(struck, parts, quiet=True, resume=True)
    assert (whole / "probes.csv").read_text() == (parts / "probes.csv").read_text()
    assert summary.particles == {"block": 12, "racket": 12}
    assert summary.energy["work"] > 0.0
    assert summary.energy["drift"] < 0.01
    assert summary.momentum_error < 1e-12


class Visitor(Observer):
    """Notes the times of a run; raises an error at one, or when it is closed."""

    def __init__(self, interval: float, *, fails_after: float = np.inf, at_close: Exception | None = None) -> None:
        self.interval, self._fails_after, self._at_close = interval, fails_after, at_close
        self.times: list[float] = []

    def observe(self, view: View) -> None:
        """Note the time."""
        if view.time > self._fails_after:
            raise ZeroDivisionError("a mistake")
        self.times.append(view.time)

    def close(self) -> None:
        """Raise the given exception."""
        if self._at_close is not None:
            raise self._at_close


def test_an_observer_of_the_user_is_called_by_simulated_time(scene: Scene, tmp_path: Path) -> None:
    visitor = Visitor(0.001)
    alone = run_scene(scene, tmp_path / "alone", quiet=True)
    assert run_scene(scene, tmp_path / "seen", quiet=True, observers=[visitor]).status == "done"
    np.testing.assert_allclose(visitor.times, [0.0, 0.001, 0.002, 0.003, 0.004, 0.005], rtol=1e-12)
    assert (tmp_path / "alone/probes.csv").read_bytes() == (tmp_path / "seen/probes.csv").read_bytes()
    assert alone.status == "done"


def test_an_observer_that_fails_ends_the_run_which_can_be_resumed(scene: Scene, tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    run_scene(scene, whole, quiet=True)
    with pytest.raises(RunError, match=r"the observer Visitor failed at 0\.003 s .*: ZeroDivisionError: a mis") as info:
        run_scene(scene, parts, quiet=True, observers=[Visitor(0.001, fails_after=0.0025)])
    assert isinstance(info.value.__cause__, ZeroDivisionError)
    summary = read_summary(parts / "run.json")
    assert (summary.status, summary.reason) == ("failed", str(info.value))
    assert summary.time == pytest.approx(0.003)
    run_scene(scene, parts, quiet=True, resume=True)
    assert (whole / "probes.csv").read_bytes() == (parts / "probes.csv").read_bytes()


def test_an_observer_that_cannot_be_closed_ends_the_run_as_failed(scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"the observer Visitor\.close failed: ValueError: open"):
        run_scene(scene, tmp_path, quiet=True, observers=[Visitor(0.001, at_close=ValueError("open"))])
    assert read_summary(tmp_path / "run.json").status == "failed"


@pytest.mark.parametrize(
    ("observer", "match"),
    [(print, r"observers\[0\]: is <built-in function print>"), (Visitor(-1.0), "observer interval: is -1.0 s")],
)
def test_what_is_no_observer_is_refused_before_anything_is_removed(
    scene: Scene, tmp_path: Path, observer: object, match: str
) -> None:
    run_scene(scene, tmp_path, quiet=True)
    with pytest.raises(InputError, match=match):
        run_scene(scene, tmp_path, quiet=True, overwrite=True, observers=[observer])  # type: ignore[list-item]
    assert read_summary(tmp_path / "run.json").status == "done"

"""What a run is continued from: its own rows and frames, arrays that fit, the same settings and versions."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Vt

from tests.coupling.scenes import IMPLICIT, RUBBING, busy, lump, pool
from tests.elastic.implicit.test_static import cantilever
from tests.elastic.implicit.test_theta_rule import rod
from tests.fluid.scenes import tank
from tests.scenes import beam, ends
from warp_mps.errors import InputError
from warp_mps.observers import checkpoint as cp
from warp_mps.run import run as run_module
from warp_mps.run.provenance import fingerprint, identity, versions
from warp_mps.run.restart import misfit
from warp_mps.run.run import run_scene
from warp_mps.scene import Elasticity, HarmonicMotion, Probe, Scene, Support
from warp_mps.shapes import Points

CLAMP = Support(name="clamp", region=ends(0.006)[0])
SCENE = beam(
    4,
    supports=(CLAMP,),
    probes=(Probe(name="tip", point=(0.15, 0.0)),),
    gravity=(0.0, -9.81),
    duration=0.004,
    frame_rate=1000.0,
    sample_rate=2000.0,
    elasticity=Elasticity(),
)
# implicit steps of 10 microseconds, and water, in two frames
RATES = {"frame_rate": 1e4, "sample_rate": 1e5}
SLOW = {"frame_rate": 100.0}
LONGER = replace(SCENE, duration=0.005)


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of the scene."""
    folder = tmp_path_factory.mktemp("ended")
    run_scene(SCENE, folder, quiet=True)
    return folder


@pytest.fixture
def folder(ended: Path, tmp_path: Path) -> Path:
    """A copy of these results."""
    return Path(shutil.copytree(ended, tmp_path / "out"))


def contents(folder: Path) -> dict[str, bytes]:
    """The bytes of every file."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    "change",
    [
        lambda rows: rows[:2] + rows[3:],
        lambda rows: [*rows[:3], rows[2].replace(rows[2].split(",")[0], "0.00051", 1), *rows[3:]],
        lambda rows: [*rows[:3], rows[3].replace(rows[3].split(",")[1], "0.1", 1), *rows[4:]],
    ],
)
def test_rows_of_another_run_before_the_last_are_refused(folder: Path, change: Callable) -> None:
    rows = (folder / "probes.csv").read_text().splitlines(keepends=True)
    (folder / "probes.csv").write_text("".join(change(rows)))
    before = contents(folder)
    with pytest.raises(InputError, match=r"probes\.csv: has other rows than those that the run wrote before its check"):
        run_scene(LONGER, folder, quiet=True, resume=True)
    assert contents(folder) == before


@pytest.mark.parametrize("change", ["removed", "altered", "added", "extent"])
def test_frames_of_another_run_before_the_last_are_refused(folder: Path, change: str) -> None:
    layer = Sdf.Layer.OpenAsAnonymous(str(folder / "run.usdc"))
    path = "/Result/beam.points"
    codes = layer.ListTimeSamplesForPath(path)
    if change == "removed":
        for attribute in layer.GetPrimAtPath("/Result/beam").attributes:
            layer.EraseTimeSample(attribute.path, codes[1])
    elif change == "extent":
        layer.SetTimeSample("/Result/beam.extent", codes[1], Vt.Vec3fArray())
    else:
        code = codes[1] if change == "altered" else 0.5 * codes[1]
        layer.SetTimeSample(path, code, layer.QueryTimeSample(path, codes[2]))
    layer.Export(str(folder / "run.usdc"))
    before = contents(folder)
    with pytest.raises(InputError, match=r"run\.usdc: has other frames than those that the run wrote before its check"):
        run_scene(LONGER, folder, quiet=True, resume=True)
    assert contents(folder) == before


def forge(folder: Path, **changes: np.ndarray | None) -> None:
    """Save the checkpoint with other arrays, None for none, and with a digest that is right."""
    found = cp.load_checkpoint(folder, fingerprint(SCENE, "float64"))
    arrays = {name: array for name, array in {**found.arrays, **changes}.items() if array is not None}
    cp.save_checkpoint(folder, fingerprint(SCENE, "float64"), replace(found, arrays=arrays))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda u: u[:-1], r"u is float64 of shape \(127, 2\), must be float64 of shape \(128, 2\)"),
        (lambda u: u.astype(complex), r"u is complex128 of shape \(128, 2\), must be float64"),
        (lambda u: u.astype(np.float32), "u is float32"),
        (lambda u: u * np.nan, "u is not finite"),
        (lambda _: None, "u is missing"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(folder: Path, change: Callable, reason: str) -> None:
    arrays = cp.load_checkpoint(folder, fingerprint(SCENE, "float64")).arrays
    forge(folder, u=change(arrays["u"]))
    before = contents(folder)
    with pytest.raises(InputError, match=rf"checkpoint\.npz: does not fit this case: {reason}.*; start a new run"):
        run_scene(LONGER, folder, quiet=True, resume=True)
    assert contents(folder) == before


def test_what_fits() -> None:
    fresh = {"u": np.zeros((3, 2)), "learnt": np.zeros((0, 2)), "interval": np.array(np.inf), "n": np.zeros(2, int)}
    later = {"u": np.ones((3, 2)), "learnt": np.ones((5, 2)), "interval": np.array(0.1), "n": np.ones(2, int)}
    assert misfit(fresh, fresh) == ""
    assert misfit(fresh, {**later, "others": np.zeros(4)}) == ""
    assert misfit(fresh, {**later, "learnt": np.ones((5, 3))}).startswith("learnt is float64 of shape (5, 3)")
    assert misfit(fresh, {**later, "interval": np.array(np.nan)}) == "interval is not finite"
    assert misfit({"a_statistics": np.zeros(2)}, {"a_statistics": np.array([1.0, np.nan])}) == ""
    assert misfit(fresh, {**later, "u": np.full((3, 2), np.inf)}) == "u is not finite"


STATISTICS = ("steps", "time", "fluid", "implicit", "coupling", "energy", "momentum_error", "measurements")
COUNTED: dict[str, tuple[Callable[[], Scene], str, tuple[str, ...]]] = {
    "explicit steps": (lambda: SCENE, "", ()),
    "implicit steps": (
        lambda: rod(duration=2e-4, gravity=(0.0, -9.81), **RATES),
        "implicit",
        ("equilibria", "newton_iterations", "linear_iterations", "worst_residual"),
    ),
    "statics": (
        lambda: cantilever(load_steps=3),
        "implicit",
        ("equilibria", "newton_iterations", "linear_iterations", "coarse_renewals"),
    ),
    "water": (
        lambda: tank((8, 8), duration=0.02, **SLOW),
        "fluid",
        ("pressure_iterations", "most_pressure_iterations"),
    ),
    "water and a body": (
        lambda: pool(lump([3, 3], [4, 3]), **{**IMPLICIT, **SLOW, "duration": 0.02}),
        "coupling",
        ("passes", "most_passes", "worst_residual"),
    ),
}


@pytest.mark.parametrize("name", COUNTED)
def test_a_finished_run_that_is_resumed_has_the_same_statistics(name: str, tmp_path: Path) -> None:
    make, kind, counted = COUNTED[name]
    ended = run_scene(make(), tmp_path, quiet=True)
    again = run_scene(make(), tmp_path, quiet=True, resume=True)
    for field in STATISTICS:
        assert getattr(again, field) == getattr(ended, field), field
    assert all(getattr(again, kind)[field] > 0 for field in counted)
    assert again.wall_seconds >= 0.5 * ended.wall_seconds
    speeds = [summary.particle_steps_per_second for summary in (ended, again)]
    assert speeds[0].keys() == speeds[1].keys()


def test_the_wall_time_is_that_of_all_parts(folder: Path) -> None:
    """As far as the last checkpoint knows of it."""
    found = cp.load_checkpoint(folder, fingerprint(SCENE, "float64"))
    records = {**found.records, "wall_seconds": 1000.0}
    cp.save_checkpoint(folder, fingerprint(SCENE, "float64"), replace(found, records=records))
    summary = run_scene(LONGER, folder, quiet=True, resume=True)
    assert 1000.0 < summary.wall_seconds < 1100.0
    assert summary.particle_steps_per_second["solid"] == pytest.approx(summary.steps * 128 / summary.wall_seconds)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"guard": {"all": {"start": 0.0}}}, "dissipated is None, must be a finite number"),
        ({"guard": None}, "what the guard has seen is None, must be"),
        ({"momentum": {"resultant": "a", "magnitude": 1.0}}, "resultant is 'a', must be"),
        ({"wall_seconds": [1.0]}, r"wall_seconds is \[1\.0\], must be"),
    ],
)
def test_records_that_are_none_are_refused(folder: Path, changes: dict, reason: str) -> None:
    found = cp.load_checkpoint(folder, fingerprint(SCENE, "float64"))
    records = {**found.records, **changes}
    cp.save_checkpoint(folder, fingerprint(SCENE, "float64"), replace(found, records=records))
    before = contents(folder)
    with pytest.raises(InputError, match=rf"checkpoint\.npz: does not fit this case: {reason}.*; start a new run"):
        run_scene(LONGER, folder, quiet=True, resume=True)
    assert contents(folder) == before


@pytest.mark.parametrize("count", [-1.0, 0.5, np.nan, np.inf, 1e300])
def test_counters_that_are_none_are_refused(count: float, tmp_path: Path) -> None:
    scene = tank((8, 8), duration=0.02, **SLOW)
    run_scene(scene, tmp_path, quiet=True)
    found = cp.load_checkpoint(tmp_path, fingerprint(scene, "float64"))
    statistics = found.arrays["pressures_statistics"].copy()
    statistics[0] = count
    arrays = {**found.arrays, "pressures_statistics": statistics}
    cp.save_checkpoint(tmp_path, fingerprint(scene, "float64"), replace(found, arrays=arrays))
    with pytest.raises(InputError, match=r"does not fit this case: counters are .* must be whole numbers of 0 or more"):
        run_scene(scene, tmp_path, quiet=True, resume=True)


def filled(value: int) -> Callable[[np.ndarray], np.ndarray]:
    """An array of the same shape and type whose last item is another."""

    def change(array: np.ndarray) -> np.ndarray:
        changed = array.copy()
        changed.flat[-1] = value
        return changed

    return change


INDICES = (
    ("water_order", filled(10**9), r"order must hold each whole number from 0 to \d+ once"),
    ("water_order", filled(-1), "order must hold each"),
    ("water_order", filled(0), "order must hold each"),
    ("water_lost", filled(2), "lost holds 2, must be 0 to 1"),
    ("water_stale", filled(-1), "stale holds -1, must be 0 to 1"),
    ("water_steps", filled(-5), "counters are"),
    ("water_learnt_sizes", filled(-1), "counters are"),
    ("water_learnt_sizes", filled(10**9), r"learnt_sizes name \d+ columns, learnt holds \d+"),
    ("water_learnt", lambda learnt: learnt[:, :, 1:].copy(), "learnt is of shape"),
    ("bodies_steps", filled(-1), "counters are"),
    ("bodies_gripped", filled(10**6), r"gripped holds 1000000, must be 0 to \d+"),
    ("bodies_gripped", filled(-1), "gripped holds -1"),
)


@pytest.fixture(scope="module")
def rubbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, Path]:
    """Two bodies that rub in water, and their results."""
    scene, out = busy(**{**RUBBING, "duration": 0.02, "frame_rate": 200.0}), tmp_path_factory.mktemp("rubbed")
    run_scene(scene, out, quiet=True)
    return scene, out


@pytest.mark.parametrize(("name", "change", "reason"), INDICES)
def test_indices_and_flags_that_are_none_are_refused(
    rubbed: tuple[Scene, Path], tmp_path: Path, name: str, change: Callable, reason: str
) -> None:
    scene, out = rubbed
    folder = Path(shutil.copytree(out, tmp_path / "out"))
    found = cp.load_checkpoint(folder, fingerprint(scene, "float64"))
    arrays = {**found.arrays, name: change(found.arrays[name])}
    cp.save_checkpoint(folder, fingerprint(scene, "float64"), replace(found, arrays=arrays))
    before = contents(folder)
    with pytest.raises(InputError, match=rf"checkpoint\.npz: does not fit this case: {reason}.*; start a new run"):
        run_scene(replace(scene, duration=0.03), folder, quiet=True, resume=True)
    assert contents(folder) == before


@pytest.mark.parametrize("ahead", [-1, 7, 10**6])
def test_another_number_of_steps_is_refused(tmp_path: Path, ahead: int) -> None:
    """The motion of supports is that at the number of steps."""
    motion = HarmonicMotion(amplitude=(0.0, 0.001), frequency=50.0)
    scene = replace(SCENE, supports=(replace(CLAMP, motion=motion),))
    run_scene(scene, tmp_path, quiet=True)
    found = cp.load_checkpoint(tmp_path, fingerprint(scene, "float64"))
    arrays = {**found.arrays, "steps": found.arrays["steps"] + np.int32(ahead)}
    cp.save_checkpoint(tmp_path, fingerprint(scene, "float64"), replace(found, arrays=arrays))
    with pytest.raises(InputError, match=rf"steps is {found.step + ahead}, must be {found.step}; start a new run"):
        run_scene(replace(scene, duration=0.005), tmp_path, quiet=True, resume=True)


def test_a_refusal_says_what_has_changed(folder: Path) -> None:
    scene = replace(LONGER, gravity=(0.0, -1.0), supports=())
    gravity = r"supports was clamp, is \(\); supports\.clamp\.kind was Support, is absent"
    with pytest.raises(InputError, match=rf"or the case has changed: .*{gravity}.* and \d more; start a new run"):
        run_scene(scene, folder, quiet=True, resume=True)
    softer = replace(LONGER, gravity=(0.0, -1.0))
    with pytest.raises(InputError, match=r"changed: gravity was \(0\.0, -9\.81\), is \(0\.0, -1\.0\); start a new run"):
        run_scene(softer, folder, quiet=True, resume=True)
    with pytest.raises(InputError, match="changed: precision was float64, is float32; start"):
        run_scene(LONGER, folder, quiet=True, resume=True, precision="float32")


def test_the_identity_of_a_case_knows_every_number() -> None:
    cloud = np.stack(np.meshgrid(np.arange(40.0), np.arange(40.0), indexing="ij"), axis=2).reshape(-1, 2) * 0.01
    body = replace(SCENE.bodies[0], shape=Points(cloud), spacing=0.01)
    moved = cloud.copy()
    moved[777] += 1e-12

    def case(points: np.ndarray) -> Scene:
        return replace(SCENE, bodies=(replace(body, shape=Points(points)),), supports=(), probes=())

    assert fingerprint(case(cloud), "float64") == fingerprint(case(cloud.copy()), "float64")
    assert fingerprint(case(cloud), "float64") != fingerprint(case(moved), "float64")
    assert fingerprint(SCENE, "float64") == fingerprint(LONGER, "float64")
    assert max(map(len, identity(case(cloud), "float64").values())) < 100


def test_another_version_is_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run_scene(LONGER, folder, quiet=True, resume=True)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(run_module, "versions", lambda: {**versions(), "warp_mps": "9.9"})
    run_scene(replace(LONGER, duration=0.006), folder, quiet=True, resume=True)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "warp-mps: the checkpoint was computed otherwise, and the run goes on with other bits: warp_mps"
    )
    assert line.endswith("then, 9.9 now")

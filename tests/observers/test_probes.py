"""probes.csv: header, rows, resuming."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.observers.views import FakeView, blocks, view_of
from warp_mps.errors import InputError, RunError
from warp_mps.observers.probes import ProbeRecorder
from warp_mps.results.energy import Energy
from warp_mps.results.history import read_history
from warp_mps.scene import Probe

PROBES = (Probe(name="tip", point=(0.65, 0.0)), Probe(name="turn", point=(0.0, 0.0), quantity="rotation"))
HEADER = (
    "time [s],tip.x [m],tip.y [m],turn [rad],kinetic energy [J/m],elastic energy [J/m],contact energy [J/m],"
    "potential energy [J/m],work [J/m],dissipated [J/m]"
)


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks(probes=PROBES))


def record(path: Path, view: FakeView, times: list[float], resume_after: float | None = None) -> ProbeRecorder:
    recorder = ProbeRecorder(path, view.scene, view.particles, every=1, resume_after=resume_after)
    for time in times:
        view.time = time
        view.displacements[:] = [time / 3.0, -time]
        view.rotations[:] = 7.0
        view.energy = Energy(kinetic=time, elastic=2.0, contact=3.0, potential=4.0, work=5.0, dissipated=6.0)
        recorder.observe(view)
    return recorder


def test_every_row_is_on_disk_as_soon_as_it_is_made(tmp_path: Path, view: FakeView) -> None:
    record(tmp_path / "probes.csv", view, [0.0, 0.25])
    lines = (tmp_path / "probes.csv").read_text().splitlines()
    assert lines[0] == HEADER
    assert len(lines) == 3
    assert [float(cell) for cell in lines[2].split(",")] == pytest.approx(
        [0.25, 0.25 / 3, -0.25, 7, 0.25, 2, 3, 4, 5, 6]
    )


def test_the_file_reads_back_as_the_same_numbers(tmp_path: Path, view: FakeView) -> None:
    recorder = record(tmp_path / "probes.csv", view, [0.0, 0.1, 0.3])
    recorder.close()
    history = read_history(tmp_path / "probes.csv")
    assert history.labels == recorder.history.labels
    assert history.rows == recorder.history.rows
    assert history.probe("tip", 1) == pytest.approx([0.0, -0.1, -0.3])
    assert history.probe("turn") == pytest.approx([7.0] * 3)
    assert history.energies()[1].kinetic == 0.1


def test_unknown_probes_and_components_are_refused(tmp_path: Path, view: FakeView) -> None:
    history = record(tmp_path / "probes.csv", view, [0.0]).history
    for name, component in (("turn", 1), ("nobody", 0), ("work", 0)):
        with pytest.raises(KeyError):
            history.probe(name, component)


def test_resuming_drops_later_rows_and_writes_none_twice(tmp_path: Path, view: FakeView) -> None:
    record(tmp_path / "whole.csv", view, [0.0, 0.1, 0.2, 0.3, 0.4])
    record(tmp_path / "probes.csv", view, [0.0, 0.1, 0.2, 0.3])
    resumed = record(tmp_path / "probes.csv", view, [0.2, 0.3, 0.4], resume_after=0.2)
    assert (tmp_path / "probes.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert resumed.history.times.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_a_row_cut_short_by_a_crash_is_left_out(tmp_path: Path, view: FakeView) -> None:
    path = tmp_path / "probes.csv"
    record(path, view, [0.0, 0.1])
    with path.open("a") as file:
        file.write("0.2,1.0,2.")
    record(path, view, [0.2], resume_after=0.1)
    assert read_history(path).times.tolist() == [0.0, 0.1, 0.2]


def test_a_new_run_starts_anew(tmp_path: Path, view: FakeView) -> None:
    record(tmp_path / "probes.csv", view, [0.0, 0.1])
    record(tmp_path / "probes.csv", view, [0.0])
    assert read_history(tmp_path / "probes.csv").times.tolist() == [0.0]


def test_other_columns_are_refused(tmp_path: Path, view: FakeView) -> None:
    record(tmp_path / "probes.csv", view, [0.0])
    other = view_of(blocks(probes=PROBES[:1]))
    with pytest.raises(InputError, match="other columns"):
        ProbeRecorder(tmp_path / "probes.csv", other.scene, other.particles, every=1, resume_after=0.0)


@pytest.mark.parametrize("text", [None, "", "a,b\n1,2\n", "time [s],a\n0,x\n", "time [s],a\n0\n"])
def test_files_that_are_no_history_are_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "probes.csv").write_text(text)
    with pytest.raises(InputError, match=r"^\S*probes.csv: "):
        read_history(tmp_path / "probes.csv")


def test_a_file_that_cannot_be_written_stops_the_run(tmp_path: Path, view: FakeView) -> None:
    recorder = ProbeRecorder(tmp_path / "out" / "probes.csv", view.scene, view.particles, every=1)
    (tmp_path / "out" / "probes.csv").unlink()
    (tmp_path / "out").rmdir()
    with pytest.raises(RunError, match="cannot be written"):
        recorder.observe(view)


def test_components_of_a_tensor(tmp_path: Path) -> None:
    view = view_of(blocks(probes=(Probe(name="root", point=(0.0, 0.0), quantity="stress"), *PROBES)))
    view.stresses[:] = [[1.0, 4.0, 0.0], [4.0, 2.0, 0.0], [0.0, 0.0, 3.0]]
    record(tmp_path / "probes.csv", view, [0.0])
    history = read_history(tmp_path / "probes.csv")
    assert history.labels[1:5] == ("root.xx [Pa]", "root.yy [Pa]", "root.zz [Pa]", "root.xy [Pa]")
    assert [history.probe("root", k)[0] for k in range(4)] == pytest.approx([1.0, 2.0, 3.0, 4.0])


def test_a_value_that_is_not_finite_stops_the_run(tmp_path: Path, view: FakeView) -> None:
    """The row is not written: what probes.csv holds can be believed."""
    recorder = record(tmp_path / "probes.csv", view, [0.0, 0.1])
    before = (tmp_path / "probes.csv").read_text()
    view.time, view.step = 0.2, 7
    view.displacements[:] = np.nan
    with pytest.raises(RunError, match=r"the probe \S+ .* is nan at 0\.2 s \(step 7\)"):
        recorder.observe(view)
    assert (tmp_path / "probes.csv").read_text() == before

"""Results as VTKHDF: read back dataset by dataset, and by VTK itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.app.results import STRESS, write_result
from warp_mps.app.cli import main


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pytest.importorskip("h5py")
    write_result(tmp_path)
    assert main(["convert", str(tmp_path), "--to", "vtkhdf"]) == 0
    return tmp_path


def test_frames_follow_one_another(folder: Path) -> None:
    h5py = pytest.importorskip("h5py")
    assert sorted(path.name for path in (folder / "vtkhdf").iterdir()) == ["block.vtkhdf", "floor.vtkhdf"]
    with h5py.File(folder / "vtkhdf/block.vtkhdf") as file:
        assert (file.attrs["case"], file.attrs["metersPerUnit"]) == ("resting", 0.01)
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"PolyData"
        steps, data = root["Steps"], root["PointData"]
        assert (steps.attrs["NSteps"], list(steps["Values"])) == (3, pytest.approx([0.0, 0.01, 0.02]))
        assert list(steps["PointOffsets"]) == list(steps["PointDataOffsets/pressure"]) == [0, 8, 16]
        assert list(steps["PointDataOffsets/id"]) == [0, 0, 0]
        assert root["Points"].shape == data["velocity"].shape == (24, 3)
        assert data["pressure"][16:] == pytest.approx(100.0 * np.arange(8) + 2.0)
        assert data["stress"][20] == pytest.approx(STRESS[np.ix_([0, 2, 1], [0, 2, 1])].ravel())
        assert (data["stress"].attrs["units"], data["velocity"].attrs["units"]) == ("Pa", "cm/s")


def test_vtk_reads_the_same(folder: Path) -> None:
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(folder / "vtkhdf/block.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    for step, height in enumerate((0.0, 2.0, 4.0)):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == 8
        assert data.GetBounds() == pytest.approx((-15, 15, 0, 0, height - 5, height + 5), abs=1e-4)
        pressure = vtk_to_numpy(data.GetPointData().GetArray("pressure"))
        assert pressure == pytest.approx(100.0 * np.arange(8) + step)


def test_what_cannot_be_written_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refusal() -> str:
        capsys.readouterr()
        assert main(["convert", str(folder), "--to", "vtkhdf"]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "block.vtkhdf: exists; use --overwrite" in refusal()
    monkeypatch.setattr("warp_mps.app.convert.vtkhdf.find_spec", lambda _: None)
    assert "vtkhdf needs h5py: pip install warp_mps[vtkhdf], or choose pvd" in refusal()

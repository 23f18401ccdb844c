"""Results for ParaView: read back array by array, by hand and by VTK itself."""

from __future__ import annotations

import base64
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.app.results import SPACE, STRESS, write_result
from warp_mps.app.cli import main

TYPES = {"Float32": np.float32, "Float64": np.float64, "Int32": np.int32, "Int64": np.int64}


@pytest.fixture
def converted(tmp_path: Path) -> Path:
    write_result(tmp_path)
    assert main(["convert", str(tmp_path), "--to", "pvd"]) == 0
    return tmp_path / "pvd"


def arrays(path: Path) -> dict[str, np.ndarray]:
    """Every appended array of a .vtp file, by name."""
    root = ElementTree.parse(path).getroot()
    assert root.get("byte_order") == "LittleEndian"
    assert root.get("header_type") == "UInt64"
    text = "".join(root.find("AppendedData").itertext()).strip()  # type: ignore[union-attr]
    assert text[0] == "_"
    return {item.get("Name", ""): values(item, text[1:]) for item in root.findall("PolyData/Piece//DataArray")}


def values(item: ElementTree.Element, text: str) -> np.ndarray:
    offset = int(item.get("offset", ""))
    # 12 characters hold the 8 bytes of the length and one of the values
    length = int(np.frombuffer(base64.b64decode(text[offset : offset + 12])[:8], dtype=np.uint64)[0])
    data = base64.b64decode(text[offset : offset + 4 * ((8 + length + 2) // 3)])[8:]
    assert len(data) == length
    numbers = np.frombuffer(data, dtype=TYPES[item.get("type", "")])
    return numbers.reshape(-1, int(item.get("NumberOfComponents", "")))


def facts(path: Path) -> dict[str, str]:
    """The field data of a .vtp file as text."""
    root = ElementTree.parse(path).getroot()
    found = {item.get("Name", ""): (item.text or "").split() for item in root.findall("PolyData/FieldData/DataArray")}
    texts = {item.get("Name", ""): (item.text or "").split() for item in root.findall("PolyData/FieldData/Array")}
    decoded = {name: bytes(map(int, codes)).rstrip(b"\0").decode() for name, codes in texts.items()}
    return {**{name: words[0] for name, words in found.items()}, **decoded}


def test_the_collection_names_every_file_with_its_time(converted: Path) -> None:
    entries = ElementTree.parse(converted / "run.pvd").getroot().findall("Collection/DataSet")
    listed = [(float(item.get("timestep", "")), item.get("name"), item.get("file")) for item in entries]
    files = [{"block": f"block_000{k}.vtp", "floor": "floor_0000.vtp"} for k in range(3)]
    assert listed == [(k / 100, name, file) for k in range(3) for name, file in files[k].items()]
    assert [item.get("part") for item in entries] == ["0", "1"] * 3
    assert {path.name for path in converted.iterdir()} == {"run.pvd", *(str(file) for _, _, file in listed)}


def test_every_array_is_there_in_the_units_that_are_stated(converted: Path) -> None:
    """Lengths are in centimetres, along x and z; stresses in Pa, turned to the stage's axes."""
    found = arrays(converted / "block_0002.vtp")
    assert list(found["id"].ravel()) == list(range(8))
    assert found["Points"].shape == (8, 3)
    assert np.ptp(found["Points"], axis=0) == pytest.approx([30.0, 0.0, 10.0])
    assert found["Points"].mean(axis=0) == pytest.approx([0.0, 0.0, 4.0], abs=1e-5)
    assert found["velocity"] == pytest.approx(np.tile([0.0, 0.0, 200.0], (8, 1)))
    assert found["width"] == pytest.approx(np.full((8, 1), 10.0))
    assert found["pressure"].ravel() == pytest.approx(100.0 * np.arange(8) + 2.0)
    assert found["von_mises"].ravel() == pytest.approx(50.0 * np.arange(8))
    turned = STRESS[np.ix_([0, 2, 1], [0, 2, 1])]
    assert found["stress"] == pytest.approx(np.tile(turned.ravel(), (8, 1)))
    assert list(found["connectivity"].ravel()) == list(range(8))
    assert list(found["offsets"].ravel()) == list(range(1, 9))
    said = facts(converted / "block_0002.vtp")
    assert float(said["TimeValue"]) == pytest.approx(0.02)
    assert float(said["metersPerUnit"]) == 0.01
    assert float(said["time step [s]"]) == 1e-4
    assert (said["case"], said["role"], said["upAxis"]) == ("resting", "body", "Z")
    assert facts(converted / "floor_0000.vtp")["role"] == "wall"


def test_vtk_reads_the_same(tmp_path: Path) -> None:
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    write_result(tmp_path, frame=SPACE)
    assert main(["convert", str(tmp_path)]) == 0
    path = tmp_path / "pvd" / "block_0001.vtp"
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == 16
    assert data.GetBounds() == pytest.approx((-0.15, 0.15, -0.03, 0.07, -0.05, 0.05), abs=1e-6)
    points, by_hand = data.GetPointData(), arrays(path)
    names = [points.GetArrayName(number) for number in range(points.GetNumberOfArrays())]
    assert set(names) == set(by_hand) - {"Points", "connectivity", "offsets"}
    for name in names:
        read = vtk_to_numpy(points.GetArray(name))
        assert np.array_equal(read.reshape(len(by_hand[name]), -1), by_hand[name])
    assert points.GetArray("stress").GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL()) == "Pa"
    assert data.GetFieldData().GetAbstractArray("case").GetValue(0) == "resting"


def test_files_are_replaced_only_when_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_result(tmp_path, frames=3)
    assert main(["convert", str(tmp_path)]) == 0
    write_result(tmp_path, frames=2)
    capsys.readouterr()
    assert main(["convert", str(tmp_path)]) == 2
    assert "run.pvd: exists; use --overwrite to replace it (in Python overwrite=True)" in capsys.readouterr().err
    assert (tmp_path / "pvd" / "block_0002.vtp").exists()
    (tmp_path / "pvd" / "view.pvsm").write_text("what a user keeps")
    assert main(["convert", str(tmp_path), "--overwrite"]) == 0
    names = {path.name for path in (tmp_path / "pvd").iterdir()}
    assert names == {"run.pvd", "view.pvsm", "block_0000.vtp", "block_0001.vtp", "floor_0000.vtp"}


def test_folders_without_a_run_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refusal(folder: Path) -> str:
        assert main(["convert", str(folder)]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "is not a folder; give the output folder of `warp-mps run`" in refusal(tmp_path / "none")
    assert "does not contain a run: run.usdc is missing" in refusal(tmp_path)
    (tmp_path / "run.usdc").write_text("not a stage")
    assert "is not a USD stage" in refusal(tmp_path)
    assert not (tmp_path / "pvd").exists()

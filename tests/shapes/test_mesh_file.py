"""Meshes from STL, OBJ and PLY files."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.shapes.surfaces import cube, icosphere
from warp_mps.errors import InputError
from warp_mps.shapes import Mesh, fill

trimesh = pytest.importorskip("trimesh")


def written(folder: Path, name: str, points: np.ndarray, triangles: np.ndarray) -> Path:
    """A file of a mesh, its kind by its name."""
    path = folder / name
    trimesh.Trimesh(points, triangles, process=False).export(path)
    return path


@pytest.mark.parametrize("name", ["ball.stl", "ball.obj", "ball.ply", "BALL.STL"])
def test_every_kind_holds_the_same_ball(tmp_path: Path, name: str) -> None:
    """In millimetres; STL repeats a corner for each of its triangles."""
    points, triangles = icosphere(2, 500.0)
    mesh = Mesh.from_file(written(tmp_path, name, points, triangles), scale=0.001)
    assert mesh.points.shape == points.shape
    assert mesh.triangles.shape == triangles.shape
    own = fill(Mesh(0.001 * points, triangles), 0.1, 3)
    np.testing.assert_allclose(fill(mesh, 0.1, 3), own, atol=1e-6)


def test_an_ascii_stl_by_hand(tmp_path: Path) -> None:
    """A tetrahedron of edge lengths 1, 1, 1 at its right corner: volume 1/6."""
    corners = {"o": "0 0 0", "x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    facets = "".join(
        f"facet normal 0 0 0\nouter loop\n{''.join(f'vertex {corners[c]}' + chr(10) for c in face)}endloop\nendfacet\n"
        for face in ("oyx", "oxz", "ozy", "xyz")
    )
    path = tmp_path / "corner.stl"
    path.write_text(f"solid corner\n{facets}endsolid corner\n")
    mesh = Mesh.from_file(path)
    assert len(mesh.points) == 4
    assert len(fill(mesh, 0.02, 3)) * 0.02**3 == pytest.approx(1 / 6, rel=0.03)
    moved = Mesh.from_file(path, placement=np.diag((2.0, 2.0, 2.0, 1.0)))
    assert moved.interval(np.array([1.0, 0.0, 0.0])) == (0.0, 2.0)


def test_a_hole_is_refused_with_its_place(tmp_path: Path) -> None:
    points, triangles = cube()
    path = written(tmp_path, "open.stl", points, triangles[1:])
    with pytest.raises(InputError) as caught:
        Mesh.from_file(path, scale=2.0)
    said = str(caught.value)
    assert said.startswith(
        f"{path}: the mesh is not closed: every edge must belong to exactly two triangles, that from"
    )
    assert "to (-1, -1, 1) m belongs to 1, as one of 3 such edges" in said
    assert "\n" not in said


@pytest.mark.parametrize(
    ("name", "content", "match"),
    [
        ("a.step", b"x", "is not a mesh file that can be read: its name must end in .stl, .obj, .ply"),
        ("a.stl", None, "there is no such file"),
        ("a.stl", b"", "(cannot be read as STL|holds no triangles)"),
        ("a.stl", b"\x00" * 200, "(cannot be read as STL|holds no triangles)"),
        ("a.ply", b"ply\nnonsense\n", "cannot be read as PLY"),
        ("a.obj", b"v 0 0 0\n", "(cannot be read as OBJ|holds no triangles)"),
        ("a.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "holds no triangles"),
    ],
)
def test_files_that_hold_no_mesh_are_refused_in_a_line(
    tmp_path: Path, name: str, content: bytes | None, match: str
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=match) as caught:
        Mesh.from_file(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.inf, "mm"])
def test_a_scale_must_be_a_length(tmp_path: Path, scale: object) -> None:
    path = written(tmp_path, "cube.stl", *cube())
    with pytest.raises(InputError, match="scale: must be finite and above 0"):
        Mesh.from_file(path, scale=scale)  # type: ignore[arg-type]


def test_what_to_install_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, "cube.stl", *cube())
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(InputError, match=r"needs trimesh to be read: pip install 'warp_mps\[mesh\]'"):
        Mesh.from_file(path)

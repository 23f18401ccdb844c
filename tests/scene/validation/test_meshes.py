"""Meshes in a scene: regions must be closed, and doubtful meshes are remarked on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.refusals import assert_refused
from tests.scenes import RUBBER
from tests.shapes.surfaces import cube
from warp_mps.particles.filling import fill_scene
from warp_mps.run.remarks import remarks_on_case
from warp_mps.scene import Body, Load, Part, Probe, Scene, Support
from warp_mps.shapes import Box, Mesh

CLOSED = Mesh(*cube())
OPEN = Mesh(cube()[0], cube()[1][1:])


def scene(shape: Mesh | Box = CLOSED, **fields: object) -> Scene:
    body = Body(name="block", shape=shape, material=RUBBER, spacing=0.25, parts=fields.pop("parts", ()))  # type: ignore[arg-type]
    return Scene(**{"bodies": (body,), "duration": 1.0, "dimension": 3, **fields})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        (lambda: {"supports": (Support(name="held", region=OPEN),)}, "support 'held'"),
        (lambda: {"supports": (Support(name="held", region=Box((1, 1, 1)) - OPEN),)}, "support 'held'"),
        (lambda: {"loads": (Load(name="push", region=OPEN, force=(0, 0, 1)),)}, "load 'push'"),
        (lambda: {"probes": (Probe(name="mean", region=OPEN),)}, "probe 'mean'"),
        (lambda: {"parts": (Part(name="core", region=OPEN, material=RUBBER),)}, "part 'core'"),
    ],
)
def test_regions_must_be_closed(fields, where: str) -> None:
    assert_refused(lambda: scene(**fields()), where, "region", "the mesh is not closed")


def test_a_shell_that_adds_nothing_is_remarked_on() -> None:
    points, triangles = cube()

    def remarks(inner: np.ndarray) -> list[str]:
        both = Mesh(np.concatenate([points, 0.5 * points]), np.concatenate([triangles, inner + len(points)]))
        case = scene(both)
        return [line for line in remarks_on_case(case, fill_scene(case)) if "shells" in line]

    (said,) = remarks(triangles)
    assert said.startswith("body 'block': 1 of the shells of its mesh, such as that at (-0.25, -0.25, -0.25) m")
    assert remarks(triangles[:, ::-1]) == []


def test_a_file_without_a_unit_is_told_its_size(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    points, triangles = cube()
    path = tmp_path / "hull.stl"
    trimesh.Trimesh(1000 * points, triangles, process=False).export(path)

    def remarks(shape: Mesh, spacing: float) -> list[str]:
        case = scene()
        case = replace(case, bodies=(replace(case.bodies[0], shape=shape, spacing=spacing),))
        return [line for line in remarks_on_case(case, fill_scene(case)) if "hull.stl" in line]

    (said,) = remarks(Mesh.from_file(path), 250.0)
    assert said.startswith("body 'block': hull.stl has no unit and is read in metres, 1000 x 1000 x 1000 m; give")
    assert remarks(Mesh.from_file(path, scale=0.001), 0.25) == []
    assert remarks(Mesh.from_file(path, scale=1), 250.0) == []

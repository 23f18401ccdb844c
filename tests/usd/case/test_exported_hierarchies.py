"""Objects as modelling programs export them: an Xform with the role above the geometry."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.usd.case.stages import write
from tests.usd.case.test_refusals import refusal
from warp_mps.particles.filling import fill_scene
from warp_mps.usd.case.read import read_stage

CUBE = """
        point3f[] points = [(0,0,0), (1,0,0), (0,1,0), (1,1,0), (0,0,1), (1,0,1), (0,1,1), (1,1,1)]
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0,2,3,1, 4,5,7,6, 0,1,5,4, 2,6,7,3, 0,4,6,2, 1,3,7,5]
"""
OBJECT = """
def Xform "Block"
{
    token mps:role = "body"
    double mps:spacing = 0.1
    double3 xformOp:translate = (0, 2, -0.5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Block_001"
    {
        rel material:binding:physics = </Steel>
MORE    }
BESIDE}
"""


def stage(folder: Path, *, more: str = CUBE, beside: str = "", **parts: tuple[str, ...]) -> Path:
    text = OBJECT.replace("MORE", more).replace("BESIDE", beside)
    return write(folder, text=text, Beam=("token mps:role = None",), **parts)


def test_an_xform_stands_for_the_geometry_below_it(tmp_path: Path) -> None:
    scene = read_stage(stage(tmp_path))
    (block,) = scene.bodies
    assert (block.name, block.path, block.material.density) == ("Block", "/Block", 7800.0)
    assert block.shape.interval(np.array([0.0, 1.0, 0.0])) == (2.0, 3.0)
    assert fill_scene(scene).count == 100


def test_a_density_and_a_mass_may_stand_on_the_geometry(tmp_path: Path) -> None:
    density, mass = "        float physics:density = 100\n", "        float physics:mass = 1\n"
    assert read_stage(stage(tmp_path, more=CUBE + density)).bodies[0].material.density == 100.0
    path = stage(tmp_path, more=CUBE + density, beside="    float physics:density = 50\n")
    assert read_stage(path).bodies[0].material.density == 50.0
    assert refusal(stage(tmp_path, more=CUBE + mass)).attribute == "physics:mass"


def test_it_may_be_joined_with_others_and_be_joined(tmp_path: Path) -> None:
    half = ("Cube", "double size = 1", "double3 xformOp:translate = (0, 2.5, 0)")
    half = (*half, 'uniform token[] xformOpOrder = ["xformOp:translate"]')
    path = stage(tmp_path, beside="    rel mps:minus = </Half>\n", Half=half)
    assert fill_scene(read_stage(path)).count == 50
    path = stage(tmp_path, more=f"{CUBE}        rel mps:minus = </Half>\n", Half=half)
    assert fill_scene(read_stage(path)).count == 50
    wall = ("Cube", 'token mps:role = "wall"', "double size = 1", "double mps:spacing = 0.1", *half[2:])
    scene = read_stage(stage(tmp_path, Wall=(*wall, "rel mps:minus = </Block>")))
    assert scene.walls[0].shape.inside(np.array([[-0.25, 2.5, 0], [0.25, 2.5, 0]]), 0.0).tolist() == [True, False]


def test_a_geometry_with_a_role_of_its_own_is_another_item(tmp_path: Path) -> None:
    wall = '    def Cube "Wall"\n    {\n        token mps:role = "wall"\n        double mps:spacing = 0.1\n    }\n'
    scene = read_stage(stage(tmp_path, beside=wall))
    assert [item.path for item in scene.filled] == ["/Block", "/Block/Wall"]


def test_several_geometries_and_none_are_refused_with_a_hint(tmp_path: Path) -> None:
    error = refusal(stage(tmp_path, beside='    def Sphere "Ball" {}\n'))
    assert error.where == "/Block"
    both = "/Block/Block_001 and /Block/Ball"
    assert error.reason == f"has 2 geometries below it, such as {both}: give each a role, or join them by mps:plus"
    error = refusal(stage(tmp_path, more="", beside='    def PointInstancer "Many" {}\n'))
    assert "stands above the PointInstancer /Block/Many, whose copies are not read" in error.reason
    path = stage(tmp_path)
    path.write_text(path.read_text().replace('def Mesh "Block_001"', 'def Scope "Block_001"'))
    assert "must be one of: Cube, Sphere, Cylinder, Mesh, Points, or an Xform above one" in refusal(path).reason

"""Prims by their roles: what has no effect for want of a role is refused, and names tell prims apart."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.usd.case.stages import write
from tests.usd.case.test_refusals import refusal
from warp_mps.usd.case.read import read_stage

WALL = ("Cube", 'token mps:role = "wall"', "double mps:spacing = 0.1")


@pytest.mark.parametrize(
    ("parts", "attribute"),
    [
        ({"Wall": ("Cube", 'token mps:rol = "wall"', WALL[2])}, "mps:rol"),
        ({"Wall": ("Cube", WALL[2])}, "mps:spacing"),
        ({"Wall": ("Xform", "double3 mps:velocity = (1, 0, 0)")}, "mps:velocity"),
        ({"Wall": ("Material", "double mps:spacing = 1")}, "mps:spacing"),
        ({"Wall": ("Cube", "rel mps:role = </Steel>")}, "mps:role"),
    ],
)
def test_attributes_without_a_role_are_refused(tmp_path: Path, parts: dict, attribute: str) -> None:
    error = refusal(write(tmp_path, **parts))
    assert (error.where, error.attribute) == ("/Wall", attribute)


def test_a_schema_without_a_role_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, text='def Cube "Wall" ( apiSchemas = ["MpsWallAPI"] ) {}\n')
    assert (refusal(path).where, refusal(path).attribute) == ("/Wall", "apiSchemas")


def test_a_role_that_is_blocked_is_off(tmp_path: Path) -> None:
    off = ("Cube", "token mps:role = None", WALL[2])
    assert read_stage(write(tmp_path, Wall=off)).walls == ()
    assert len(read_stage(write(tmp_path, Wall=WALL)).walls) == 1


def test_an_asset_referenced_twice_gives_two_of_each_name(tmp_path: Path) -> None:
    asset = """#usda 1.0
( defaultPrim = "Gauge" )
def Xform "Gauge"
{
    def Xform "Tip"
    {
        token mps:role = "probe"
    }
    def Scope "M" ( displayName = "height" )
    {
        token mps:role = "measurement"
        token mps:measure = "final"
        rel mps:probe = </Gauge/Tip>
    }
}
"""
    (tmp_path / "gauge.usda").write_text(asset)
    twice = "".join(f'def "{name}" ( references = @gauge.usda@ ) {{}}\n' for name in "AB")
    scene = read_stage(write(tmp_path, text=twice))
    assert [probe.name for probe in scene.probes] == ["A_Tip", "B_Tip"]
    assert [(item.name, item.probe) for item in scene.measurements] == [
        ("height (/A/M)", "A_Tip"),
        ("height (/B/M)", "B_Tip"),
    ]


def test_materials_and_joined_shapes_need_no_role(tmp_path: Path) -> None:
    spare = ("Material", "double mps:viscosity = 1", "double mps:youngsModulus = 1")
    joined = ("Cylinder", "double mps:innerRadius = 0.5")
    assert len(read_stage(write(tmp_path, Spare=spare, Joined=joined)).bodies) == 1

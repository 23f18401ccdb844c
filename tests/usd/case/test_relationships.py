"""Targets of relationships that USD drops, and prims that take no part in a case."""

from __future__ import annotations

from pathlib import Path

import pytest

from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.usd.case.read import read_stage

HEAD = '#usda 1.0\n(\n    defaultPrim = "W"\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'
SCENE = """
    def PhysicsScene "Scene"
    {
        int mps:dimension = 2
        token mps:plane = "xy"
        double mps:duration = 0.1
    }
"""
PLATE = """
    def Cube "A" %s
    {
        token mps:role = "fluid"
        double size = 1
        double mps:spacing = 0.05
        rel mps:minus = %s
    }
"""

HOLE = """
    def Cube "%s" %s
    {
        double size = 0.4
        %s
    }
"""


def stage(folder: Path, *prims: str) -> Path:
    path = folder / "case.usda"
    path.write_text(HEAD + 'def Xform "W"\n{\n' + SCENE + "".join(prims) + "}\n", encoding="utf-8")
    return path


def test_a_target_outside_of_what_is_referenced_is_refused(tmp_path: Path) -> None:
    """USD drops it, and the hole would be gone without a word."""
    plate = 'def Cube "A"\n{\n token mps:role = "fluid"\n double size = 1\n double mps:spacing = 0.05\n'
    plate += " rel mps:minus = </Other>\n}\n" + HOLE % ("Other", "", "")
    (tmp_path / "plate.usda").write_text('#usda 1.0\n(defaultPrim = "A")\n' + plate, encoding="utf-8")
    with pytest.raises(InputError, match=r"/W/A mps:minus: refers to /.*, not all of which lie inside"):
        read_stage(stage(tmp_path, '    def "A" (references = @./plate.usda@) {}\n'))


@pytest.mark.parametrize(("activity", "count"), [("", 336), ("(active = false)", 400)])
def test_an_inactive_hole_is_none(activity: str, count: int, tmp_path: Path) -> None:
    scene = read_stage(stage(tmp_path, PLATE % ("", "</W/B>"), HOLE % ("B", activity, "")))
    assert fill_scene(scene).count == count


def test_a_class_and_a_level_of_an_operand_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="/W/A mps:minus: refers to /W/B, which is a class"):
        read_stage(stage(tmp_path, PLATE % ("", "</W/B>"), (HOLE % ("B", "", "")).replace("def", "class")))
    fluid = 'token mps:role = "fluid"\n double mps:spacing = 0.05\n double mps:fillLevel = 0'
    level = HOLE % ("B", "", fluid)
    with pytest.raises(InputError, match="/W/A mps:minus: refers to /W/B, whose mps:fillLevel does not cut it"):
        read_stage(stage(tmp_path, PLATE % ("", "</W/B>"), level))

"""Remarks on a stage: what it says in another unit than it is read in, and what has no effect."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from tests.usd.case.stages import write
from warp_mps.particles.filling import fill_scene
from warp_mps.run.remarks import remarks_on_case
from warp_mps.usd.case.read import read_stage

# a cube of 200 mm, 300 mm from the origin, in a layer of its own
BLOCK = """#usda 1.0
(
    defaultPrim = "Block"
    {0}
)
def Xform "Block"
{{
    def Cube "Wall"
    {{
        token mps:role = "wall"
        {1}
        double size = 200
        double3 xformOp:translate = (300, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
}}
"""
MILLIMETRES = "metersPerUnit = 0.001"


def block(folder: Path, metadata: str, *, above: str = "", spacing: float = 50.0, inside: str = "") -> Path:
    """A stage in metres that refers to the block."""
    (folder / "block.usda").write_text(BLOCK.format(metadata, inside))
    own = "" if not spacing else f'    over "Wall"\n    {{\n        double mps:spacing = {spacing}\n    }}\n'
    return write(folder, text=f'def "It" ( references = @block.usda@ )\n{{\n    {above}\n{own}}}\n')


def scale(factor: float) -> str:
    return (
        f'double3 xformOp:scale = ({factor}, {factor}, {factor})\n    uniform token[] xformOpOrder = ["xformOp:scale"]'
    )


def right(path: Path) -> float:
    return read_stage(path).walls[0].shape.interval(np.array([1.0, 0.0, 0.0]))[1]


def test_an_asset_in_millimetres_is_remarked_on_until_it_is_scaled(tmp_path: Path) -> None:
    path = block(tmp_path, MILLIMETRES)
    said = "/It: refers to block.usda, whose unit is 0.001 m, but 1 in it is read as 1 m"
    remedy = "give the prim xformOp:scale = 0.001 along every axis"
    assert read_stage(path).remarks == (f"{said}: {remedy}",)
    assert right(path) == pytest.approx(400.0)
    path = block(tmp_path, MILLIMETRES, above=scale(0.001), spacing=0.05)
    assert read_stage(path).remarks == ()
    assert right(path) == pytest.approx(0.4)


def test_lengths_that_an_asset_gives_itself_are_not_scaled(tmp_path: Path) -> None:
    inside = "double mps:spacing = 0.05"
    (said,) = read_stage(block(tmp_path, MILLIMETRES, above=scale(0.001), spacing=0, inside=inside)).remarks
    assert said.startswith(
        "/It/Wall mps:spacing: comes from block.usda, whose unit is 0.001 m, but is read in units of 1 m"
    )
    assert read_stage(block(tmp_path, MILLIMETRES, above=scale(0.001), spacing=0.05, inside=inside)).remarks == ()


@pytest.mark.parametrize("metadata", ["", "metersPerUnit = 1", 'upAxis = "Y"'])
def test_an_asset_in_the_units_of_the_stage_needs_no_remark(tmp_path: Path, metadata: str) -> None:
    assert read_stage(block(tmp_path, metadata)).remarks == ()


def test_another_up_axis_is_remarked_on_until_the_asset_is_turned(tmp_path: Path) -> None:
    assert (
        "/It: refers to block.usda, whose up axis is Z, but that of the stage is Y"
        in read_stage(block(tmp_path, 'upAxis = "Z"')).remarks[0]
    )
    turn = 'double xformOp:rotateX = -90\n    uniform token[] xformOpOrder = ["xformOp:rotateX"]'
    assert read_stage(block(tmp_path, 'upAxis = "Z"', above=turn)).remarks == ()


def test_another_unit_of_mass_is_remarked_on(tmp_path: Path) -> None:
    (said,) = read_stage(block(tmp_path, "kilogramsPerUnit = 0.001")).remarks
    assert "whose unit of mass is 0.001 kg, but 1 in it is read as 1 kg" in said


def test_the_unit_of_a_sublayer_does_not_count(tmp_path: Path) -> None:
    (tmp_path / "more.usda").write_text("#usda 1.0\n( metersPerUnit = 0.001 )\n")
    path = write(tmp_path)
    path.write_text(path.read_text().replace("(\n", "(\n    subLayers = [@more.usda@]\n", 1))
    (said,) = read_stage(path).remarks
    assert said.startswith("more.usda: says metersPerUnit = 0.001, which USD ignores in a sublayer")


def test_a_stage_without_a_unit_is_told_its_size(tmp_path: Path) -> None:
    path = write(tmp_path, Beam=("double size = 3", "double mps:spacing = 0.5"))
    path.write_text(path.read_text().replace("    metersPerUnit = 1.0\n", ""))
    scene = read_stage(path)
    assert scene.remarks == (
        "metersPerUnit: is not given, so that it is USD's 0.01 m: the case is 0.03 x 0.03 m; "
        "give metersPerUnit = 1 if its numbers are metres",
    )
    # the same from a check and from a run
    assert scene.remarks[0] in remarks_on_case(scene, fill_scene(scene))


def test_an_operation_that_the_order_does_not_name_has_no_effect(tmp_path: Path) -> None:
    path = write(tmp_path, Beam=("double3 xformOp:translate = (0, 5, 0)",))
    said = "/Beam xformOp:translate: has no effect, for xformOpOrder does not name it; add it there"
    assert read_stage(path).remarks == (said,)
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    path = write(tmp_path, Beam=("double3 xformOp:translate = (0, 5, 0)", order))
    assert read_stage(path).remarks == ()


def test_changes_that_are_not_saved_are_read_and_kept(tmp_path: Path) -> None:
    path = write(tmp_path)
    stage = Usd.Stage.Open(str(path))
    stage.GetPrimAtPath("/Beam").GetAttribute("size").Set(2.0)
    scene = read_stage(path)
    assert scene.bodies[0].shape.size == (2.0, 2.0, 2.0)  # type: ignore[attr-defined]
    assert scene.remarks == ("case.usda: has changes in this process that are not saved; they are read, too",)
    assert stage.GetPrimAtPath("/Beam").GetAttribute("size").Get() == 2.0


def test_a_file_that_has_changed_is_read_anew_where_it_is_open(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(write(tmp_path)))
    path = write(tmp_path, Beam=("double size = 20",))
    assert read_stage(path).bodies[0].shape.size == (20.0, 20.0, 20.0)  # type: ignore[attr-defined]
    assert stage.GetPrimAtPath("/Beam").GetAttribute("size").Get() == 20.0

"""Places of prims: transforms that are given at a time only, that vary, or that copies would need."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.usd.case.stages import write
from tests.usd.case.test_refusals import refusal
from warp_mps.usd.case.read import read_stage

SAMPLED = "double3 xformOp:translate.timeSamples = { 1: (0, 5, 0) }"
ORDER = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
ABOVE = 'def Xform "Up"\n{{\n{0}\n{1}\n    def {2} "It"\n    {{\n        token mps:role = "{3}"\n{4}\n    }}\n}}\n'
WIDE = "        double mps:spacing = 0.1\n        double size = 1"


def centre(shape: object) -> list[float]:
    """Centre of a shape, by its bounds."""
    return [float(np.mean(shape.interval(axis))) for axis in np.eye(3)]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("statements", "expected"),
    [
        ((SAMPLED, ORDER), (0, 5, 0)),
        (("double3 xformOp:translate = (0, 5, 0)", SAMPLED, ORDER), (0, 5, 0)),
        (("double xformOp:translateY.timeSamples = { 7: 5 }", ORDER.replace("translate", "translateY")), (0, 5, 0)),
        (
            (
                "matrix4d xformOp:transform.timeSamples = { 1: ((1,0,0,0), (0,1,0,0), (0,0,1,0), (2,5,0,1)) }",
                ORDER.replace("translate", "transform"),
            ),
            (2, 5, 0),
        ),
    ],
)
def test_a_body_is_where_its_one_sample_puts_it(tmp_path: Path, statements: tuple, expected: tuple) -> None:
    assert centre(read_stage(write(tmp_path, Beam=statements)).bodies[0].shape) == list(expected)


def test_a_scale_counts_as_well(tmp_path: Path) -> None:
    scale = "double3 xformOp:scale.timeSamples = { 1: (1, 5, 1) }"
    body = read_stage(write(tmp_path, Beam=(scale, ORDER.replace("translate", "scale")))).bodies[0]
    assert body.shape.size == (1.0, 5.0, 1.0)  # type: ignore[attr-defined]


@pytest.mark.parametrize("role", ["wall", "support", "probe"])
def test_walls_supports_and_probes_follow_a_prim_above_them(tmp_path: Path, role: str) -> None:
    kind, more = ("Xform", "") if role == "probe" else ("Cube", WIDE if role == "wall" else "")
    scene = read_stage(write(tmp_path, text=ABOVE.format(SAMPLED, ORDER, kind, role, more)))
    if role == "probe":
        assert scene.probes[0].point == (0.0, 5.0)
    else:
        assert centre(scene.walls[0].shape if role == "wall" else scene.supports[0].region) == [0, 5, 0]


@pytest.mark.parametrize(
    ("statements", "attribute", "reason"),
    [
        ((SAMPLED, "double3 xformOp:translate = (0, 0, 0)", ORDER), "xformOp:translate", "time sample that differ"),
        (("double xformOp:translateY.spline = { 1: 5 }", ORDER.replace("translate", "translateY")), None, "varies"),
        ((ORDER,), "xformOp:translate", "has no value, but xformOpOrder names it"),
        (("double3 xformOp:translate", ORDER), "xformOp:translate", "has no value"),
        (("rel xformOp:translate = </Steel>", ORDER), "xformOp:translate", "must be an attribute"),
        (('string xformOpOrder = "xformOp:translate"', "double3 xformOp:translate = (0, 1, 0)"), None, "token[]"),
        (('token[] xformOpOrder.timeSamples = { 1: ["xformOp:translate"] }', SAMPLED), None, "without time samples"),
    ],
)
def test_transforms_that_would_be_left_out_are_refused(
    tmp_path: Path, statements: tuple, attribute: str | None, reason: str
) -> None:
    error = refusal(write(tmp_path, Beam=statements))
    assert error.where == "/Beam"
    assert attribute in (None, error.attribute)
    assert reason in error.reason


def test_copies_of_an_instancer_are_refused(tmp_path: Path) -> None:
    """Three copies are drawn: one body, where the prototype lies, is not what they show."""
    wall = 'def Cube "Wall"\n    {\n        token mps:role = "wall"\n        double mps:spacing = 0.1\n    }\n'
    numbers = "int[] protoIndices = [0, 0, 0]\n    point3f[] positions = [(0, 0, 0), (3, 0, 0), (6, 0, 0)]\n"
    below = f'def PointInstancer "Many"\n{{\n    rel prototypes = </Many/Wall>\n    {numbers}    {wall}}}\n'
    error = refusal(write(tmp_path, text=below))
    assert (error.where, error.attribute) == ("/Many/Wall", "mps:role")
    assert "drawn by the PointInstancer /Many, whose copies are not read" in error.reason
    beside = f'def PointInstancer "Many"\n{{\n    rel prototypes = </Wall>\n    {numbers}}}\n{wall}'
    assert "/Many, whose copies are not read" in refusal(write(tmp_path, text=beside)).reason

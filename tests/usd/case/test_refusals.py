"""Stages that cannot be run: one error each, with the prim and the attribute."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.usd.case.stages import write
from warp_mps.errors import InputError
from warp_mps.usd.case.read import read_stage

SUPPORT = ("Cube", 'token mps:role = "support"')
PART = ("Cube", 'token mps:role = "part"', "double size = 0.5")
STEEL = "rel material:binding:physics = </Steel>"
PROBE = ("Xform", 'token mps:role = "probe"')
VON_MISES = 'token mps:quantity = "von_mises"'
CUT = ("Cube", 'token mps:role = "probe"')
MEASUREMENT = ("Scope", 'token mps:role = "measurement"', 'token mps:measure = "final"')
NORMAL = ("rel mps:probe = </P>", 'token mps:component = "z"')
VARYING = "double mps:spacing.timeSamples = { 0: 1, 1: 0.5 }"
TWO = 'def PhysicsScene "A" {}\ndef Cube "B"\n{\n    token mps:role = "body"\n}\n'
MOVE = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
SCALE = 'uniform token[] xformOpOrder = ["xformOp:scale"]'


def refusal(path: Path, **options: Any) -> InputError:
    with pytest.raises(InputError) as caught:
        read_stage(path, **options)
    assert "\n" not in str(caught.value)
    return caught.value


@pytest.mark.parametrize(
    ("parts", "where", "attribute", "reason"),
    [
        ({"Beam": ('token mps:role = "boddy"',)}, "/Beam", "mps:role", "'boddy', must be one of: body, part, wall"),
        ({"Beam": ("-mps:spacing",)}, "/Beam", "mps:spacing", "is missing"),
        ({"Beam": ('string mps:spacing = "0.1"',)}, "/Beam", "mps:spacing", "must be double, not string"),
        ({"Beam": ("double mps:spacing = nan",)}, "/Beam", "mps:spacing", "must be finite"),
        ({"Beam": ("double mps:spacing = -1",)}, "/Beam", "mps:spacing", "above 0"),
        ({"Beam": ("double mps:spacing = 3",)}, "/Beam", "mps:spacing", "thinner than one particle"),
        ({"Beam": ("-mps:spacing", VARYING)}, "/Beam", "mps:spacing", "vary in time"),
        (
            {"Beam": ("double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 1: (1, 0, 0) }", MOVE)},
            *("/Beam", "xformOp:translate", "varies in time"),
        ),
        ({"Beam": ("double mps:spacing.timeSamples = { 0: 1, 1: 2 }",)}, "/Beam", "mps:spacing", "not vary in time"),
        ({"Beam": ("double mps:spaceing = 1",)}, "/Beam", "mps:spaceing", "did you mean mps:spacing"),
        ({"Beam": ("double mps:friction = 1",)}, "/Beam", "mps:friction", "is not known here; it is for: scene, wall"),
        ({"Beam": ("-material:binding:physics",)}, "/Beam", "material:binding:physics", "bind a material"),
        ({"Beam": ("float physics:mass = 2",)}, "/Beam", "physics:mass", "density"),
        ({"Beam": ("double3 mps:velocity = (0, 0, 1)",)}, "/Beam", "mps:velocity", "must lie in the plane xy"),
        ({"Beam": ("double3 mps:angularVelocity = (1, 0, 0)",)}, "/Beam", "mps:angularVelocity", "the normal of"),
        ({"Beam": ('token mps:nodeAxes = "w"',)}, "/Beam", "mps:nodeAxes", "axes among xyz"),
        ({"Beam": ('token mps:velocityField = "sine"',)}, "/Beam", "mps:velocityField:amplitude", "is missing"),
        ({"Core": (*PART, "rel mps:body = </Beam>")}, "/Core", "material:binding:physics", "bind a material"),
        ({"Core": (*PART, STEEL)}, "/Core", "mps:body", "is missing"),
        ({"Core": (*PART, STEEL, "rel mps:body = </Steel>")}, "/Core", "mps:body", "must refer to a body"),
        ({"Core": ("Scope", *PART[1:], STEEL, "rel mps:body = </Beam>")}, "/Core", "", "must be one of: Cube"),
        ({"Beam": ('token mps:velocityField = "twist"',)}, "/Beam", "mps:velocityField:rate", "is missing"),
        ({"Beam": ("rel mps:bondedTo = </Nobody>",)}, "/Beam", "mps:bondedTo", "there is no prim"),
        ({"Beam": ("rel mps:bondedTo = </Steel>",)}, "/Beam", "mps:bondedTo", "must refer to a body"),
        ({"Beam": ("double size = 0",)}, "/Beam", "size", "must be positive"),
        ({"Beam": ("double3 xformOp:scale = (1, 0, 1)", SCALE)}, "/Beam", "xformOpOrder", "flattens"),
        ({"Beam": ("double3 xformOp:translate = (0, 0, 9)", MOVE)}, "/Beam", "", "no section at z = 0"),
        ({"Steel": ("-physics:density",)}, "/Steel", "physics:density", "is missing"),
        ({"Steel": ("double mps:youngsModulus = 0",)}, "/Steel", "mps:youngsModulus", "above 0"),
        ({"Steel": ("double mps:poissonsRatio = 0.5",)}, "/Steel", "mps:poissonsRatio", "between -1 and 0.5"),
        ({"Scene": ("-mps:duration",)}, "/Scene", "mps:duration", "is missing"),
        ({"Scene": ("int mps:dimension = 4",)}, "/Scene", "mps:dimension", "must be one of: 2, 3"),
        ({"Scene": ("double mps:dimension = 2",)}, "/Scene", "mps:dimension", "must be int, not double"),
        ({"Scene": ('token mps:contact = "some"',)}, "/Scene", "mps:contact", "must be one of: none, bodies, all"),
        ({"Scene": ('token mps:analysis = "modal"',)}, "/Scene", "mps:analysis", "must be one of: dynamic, static"),
        ({"Scene": ("int mps:loadSteps = 0",)}, "/Scene", "mps:loadSteps", "at least 1"),
        ({"Scene": ("double mps:theta = 0.4",)}, "/Scene", "mps:theta", "between 0.5 and 1"),
        ({"Scene": ("double mps:courant = 0",)}, "/Scene", "mps:courant", "above 0"),
        ({"Scene": ("double mps:effectiveRadius = 9",)}, "/Scene", "mps:effectiveRadius", "between 1.1 and 5"),
        (
            {"Scene": ("float physics:gravityMagnitude = 1", "vector3f physics:gravityDirection = (0, 0, 1)")},
            "/Scene",
            "physics:gravityMagnitude",
            "must lie in the plane",
        ),
        ({"Cone": ("Cone", 'token mps:role = "support"')}, "/Cone", "", "must be one of: Cube"),
        ({"Ball": ("Sphere", SUPPORT[1], "double mps:innerRadius = 1")}, "/Ball", "mps:innerRadius", "Cylinder"),
        ({"Held": (*SUPPORT, 'token mps:axes = "z"')}, "/Held", "mps:axes", "axes among xy"),
        ({"Held": (*SUPPORT, "double mps:motion:frequency = 1")}, "/Held", "mps:motion:amplitude", "is missing"),
        (
            {"Held": (*SUPPORT, "double3 mps:motion:amplitude = (1, 0, 0)", "double mps:motion:frequency = 0")},
            "/Held",
            "mps:motion:frequency",
            "above 0",
        ),
        ({"Load": ("Cube", 'token mps:role = "load"')}, "/Load", "mps:force", "neither a force nor an acceleration"),
        ({"P": (*PROBE, 'token mps:quantity = "reaction"')}, "/P", "mps:quantity", "must be one of: position"),
        ({"P": (*PROBE, 'token mps:quantity = "section_force"')}, "/P", "mps:quantity", "must be one of: position"),
        ({"P": (*CUT, 'token mps:quantity = "section_moment"')}, "/P", "mps:about", "is missing"),
        ({"P": (*CUT, "double3 mps:about = (0, 0, 0)")}, "/P", "mps:about", "needs section_moment"),
        ({"Scene": ('token[] mps:outputs = ["stress", "heat"]',)}, "/Scene", "mps:outputs", "'heat', must be one of"),
        ({"Scene": ('string[] mps:outputs = ["stress"]',)}, "/Scene", "mps:outputs", "must be token[], not string[]"),
        ({"Scene": ('token[] mps:outputs = ["strain", "strain"]',)}, "/Scene", "mps:outputs", "names a quantity twice"),
        ({"P": (*PROBE, "rel mps:target = </Steel>")}, "/P", "mps:target", "one body, wall, fluid or support"),
        ({"P": (*PROBE, "double3 xformOp:translate = (0, 0, 1)", MOVE)}, "/P", "xformOpOrder", "out of the plane"),
        ({"M": MEASUREMENT}, "/M", "mps:probe", "is missing"),
        ({"M": (*MEASUREMENT, *NORMAL), "P": PROBE}, "/M", "mps:component", "must be one of: x, y"),
        ({"M": (*MEASUREMENT, *NORMAL), "P": (*PROBE, VON_MISES)}, "/M", "mps:component", "one component only"),
        ({"Mesh": ("Mesh", 'token mps:role = "support"')}, "/Mesh", "points", "is empty"),
    ],
)  # fmt: skip
def test_refusals_name_the_prim_and_the_attribute(
    tmp_path: Path, parts: dict, where: str, attribute: str, reason: str
) -> None:
    error = refusal(write(tmp_path, **parts))
    assert (error.where, error.attribute) == (where, attribute)
    assert reason in error.reason


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({"Beam": ("double mps:spacing = -1",)}, "/Beam mps:spacing: is -0.01, must be finite and above 0 (numbers in"),
        ({"Beam": ("double size = -5",)}, "/Beam size: must be positive, not -0.05 (numbers in metres"),
        ({"Scene": ("double mps:duration = -1",)}, "/Scene mps:duration: is -1, must be finite and above 0"),
    ],
)
def test_numbers_of_a_stage_in_centimetres_are_told_in_metres_and_said_to_be(
    tmp_path: Path, parts: dict, expected: str
) -> None:
    text = str(refusal(write(tmp_path, length=0.01, **parts)))
    assert text.startswith(expected)
    assert text.endswith(" (numbers in metres; the stage's unit is 0.01 m)") == ("numbers" in expected)
    assert "numbers in" not in str(refusal(write(tmp_path, **parts)))


def test_a_wrong_type_is_named_also_where_a_schema_gives_the_right_one(tmp_path: Path) -> None:
    path = write(tmp_path, Beam=('string mps:spacing = "0.1"',))
    path.write_text(path.read_text().replace('def Cube "Beam"', 'def Cube "Beam" ( apiSchemas = ["MpsBodyAPI"] )'))
    assert refusal(path).reason == "must be double, not string"


def test_open_meshes(tmp_path: Path) -> None:
    sheet = (
        "Mesh",
        'token mps:role = "body"',
        "double mps:spacing = 0.1",
        "rel material:binding:physics = </Steel>",
        "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]",
        "int[] faceVertexCounts = [3]",
        "int[] faceVertexIndices = [0, 1, 2]",
    )
    assert "not closed" in refusal(write(tmp_path, Sheet=sheet)).reason
    error = refusal(write(tmp_path, Sheet=(*sheet[:-1], "int[] faceVertexIndices = [0, 1, 7]")))
    assert (error.where, error.attribute) == ("/Sheet", "faceVertexIndices")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("#usda 1.0\n", "no PhysicsScene prim"),
        ('#usda 1.0\ndef PhysicsScene "A" {}\ndef PhysicsScene "B" {}\n', "more than one PhysicsScene prim: /A, /B"),
        ('#usda 1.0\ndef PhysicsScene "A"\n{\n    double mps:duration = 1\n}\n', "needs a body or a fluid"),
        ('#usda 1.0\ndef "A" { double x = "hi"', "is not a USD stage"),
        ("nothing of the kind", "is not a USD stage"),
        ('#usda 1.0\ndef "A" ( references = @nowhere.usda@ ) {}\n', "nowhere.usda"),
        ("#usda 1.0\n( metersPerUnit = 0 )\n" + TWO, "above 0"),
    ],
)  # fmt: skip
def test_files_that_are_no_cases(tmp_path: Path, capfd: pytest.CaptureFixture[str], text: str, reason: str) -> None:
    path = tmp_path / "case.usda"
    path.write_text(text, encoding="utf-8")
    assert reason in refusal(path).reason
    assert capfd.readouterr() == ("", "")


def test_files_that_are_not_there_or_of_another_kind(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert "no such file" in refusal(tmp_path / "none.usda").reason
    (tmp_path / "case.png").write_bytes(b"\x89PNG")
    assert "is not a USD stage" in refusal(tmp_path / "case.png").reason
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("target", "text", "where", "reason"),
    [
        ("/Nobody.mps:spacing", "1", "/Nobody", "no such prim"),
        ("/Beam.", "3", "/Beam", "'/Beam.' is not /Prim.attribute"),
        ("/Beam", "3", "/Beam", "'/Beam' is not /Prim.attribute"),
        ("/Scene.mps:dimension", "9" * 400, "/Scene", "not of type int"),
        ("Beam", "1", "Beam", "no such prim"),
        ("/Beam.mps:spaceing", "1", "/Beam", "no such attribute"),
        ("/Beam.mps:spacing", "wide", "/Beam", "'wide' is not of type double"),
        ("/Beam.mps:spacing", "1\n    double mps:x = 1", "/Beam", "not of type double"),
        ("/Beam.mps:velocity", "1", "/Beam", "not of type double3"),
        ("/Scene.mps:dimension", "2.5", "/Scene", "not of type int"),
        ("/Beam.mps:bondedTo", "a b c!", "/Beam", "not a list of prim paths"),
    ],
)
def test_overrides_that_mean_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], target: str, text: str, where: str, reason: str
) -> None:
    path = write(tmp_path)
    with pytest.raises(InputError) as caught:
        read_stage(path, overrides={target: text})
    assert caught.value.where == where
    assert reason in caught.value.reason
    assert capfd.readouterr() == ("", "")

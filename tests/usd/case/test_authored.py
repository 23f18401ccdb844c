"""Values that a stage holds elsewhere than at the default time, or on a property of another kind than is meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.usd.case.stages import write
from tests.usd.case.test_refusals import refusal
from warp_mps.usd.case.read import read_stage


def test_one_sample_is_the_value_at_every_time(tmp_path: Path) -> None:
    gravity = ("float physics:gravityMagnitude.timeSamples = { 1: 0 }", "-physics:gravityMagnitude")
    down = "vector3f physics:gravityDirection.timeSamples = { 1: (0, -1, 0) }"
    size = ("-size", "double size.timeSamples = { 1: 3 }")
    density = "float physics:density.timeSamples = { 1: 100 }"
    scene = read_stage(write(tmp_path, Scene=(*gravity, down), Beam=(*size, density)))
    body = scene.bodies[0]
    assert scene.gravity == (0.0, 0.0)
    assert body.shape.size == (3.0, 3.0, 3.0)  # type: ignore[attr-defined]
    assert body.material.density == 100.0


def test_an_override_replaces_samples(tmp_path: Path) -> None:
    path = write(tmp_path, Beam=("-size", "double size.timeSamples = { 1: 3, 2: 4 }"))
    assert "vary in time" in refusal(path).reason
    scene = read_stage(path, overrides={"/Beam.size": "2"})
    assert scene.bodies[0].shape.size == (2.0, 2.0, 2.0)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("parts", "where", "attribute", "reason"),
    [
        ({"Beam": ("-size", "double size.spline = { 1: 3 }")}, "/Beam", "size", "must have a value that does not vary"),
        ({"Beam": ("-size", "double size.timeSamples = { 1: 3, 2: 4 }")}, "/Beam", "size", "does not vary in time"),
        ({"Beam": ("double size.timeSamples = { 1: 3 }", "double size = 1")}, "/Beam", "size", "sample that differ"),
        ({"Steel": ("double mps:youngsModulus.spline = { 1: 3 }",)}, "/Steel", "mps:youngsModulus", "vary in time"),
        ({"Beam": ("float physics:density.spline = { 1: 3 }",)}, "/Beam", "physics:density", "vary in time"),
        (
            {"Scene": ("vector3f physics:gravityDirection.timeSamples = { 1: (1, 0, 0), 2: (0, 1, 0) }",)},
            *("/Scene", "physics:gravityDirection", "vary in time"),
        ),
        (
            {"Beam": ("double mps:spacing.connect = </Steel.mps:youngsModulus>",)},
            *("/Beam", "mps:spacing", "is connected to /Steel.mps:youngsModulus, which is not followed"),
        ),
        ({"Beam": ("rel mps:velocity = </Steel>",)}, "/Beam", "mps:velocity", "must be an attribute"),
        ({"Beam": ("rel size = </Steel>", "-size")}, "/Beam", "size", "must be an attribute"),
        ({"Beam": ("rel physics:density = </Steel>",)}, "/Beam", "physics:density", "must be an attribute"),
        ({"Scene": ("rel physics:gravityDirection = </A>",)}, "/Scene", "physics:gravityDirection", "an attribute"),
        ({"Beam": ('token mps:plus = "a"',)}, "/Beam", "mps:plus", "must be a relationship"),
        ({"Beam": ("double3 mps:velocityField:axis = (1, 0, 0)",)}, "/Beam", "mps:velocityField:axis", "no effect"),
        ({"Beam": ("double mps:innerRadius = -1",)}, "/Beam", "mps:innerRadius", "is of a Cylinder, not of a Cube"),
        ({"Beam": ("double mps:innerRadius = 0",)}, "/Beam", "mps:innerRadius", "is of a Cylinder, not of a Cube"),
    ],
)
def test_what_would_be_left_out_is_refused(
    tmp_path: Path, parts: dict, where: str, attribute: str, reason: str
) -> None:
    error = refusal(write(tmp_path, **parts))
    assert (error.where, error.attribute) == (where, attribute)
    assert reason in error.reason


def test_a_property_of_the_wrong_kind_is_refused_beside_a_schema(tmp_path: Path) -> None:
    for wrong in ("rel mps:velocity = </Steel>", 'token mps:plus = "a"'):
        path = write(tmp_path, Beam=(wrong,))
        schema = 'def Cube "Beam" ( apiSchemas = ["MpsBodyAPI"] )'
        path.write_text(path.read_text().replace('def Cube "Beam"', schema))
        assert refusal(path).attribute == wrong.split()[1]

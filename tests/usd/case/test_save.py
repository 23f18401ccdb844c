"""Saving scenes: the scene that is read back equals the saved one."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdPhysics

from tests.scenes import block
from tests.shapes.surfaces import cube
from warp_mps.errors import InputError
from warp_mps.scene import (
    Body,
    Contact,
    Elasticity,
    HarmonicMotion,
    HarmonicRotation,
    Load,
    Material,
    Measurement,
    Part,
    Probe,
    Scene,
    StageFrame,
    Support,
    TableMotion,
    TableRotation,
    VelocityField,
    Wall,
)
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, contains, fill
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.case.save import save_stage

STEEL = Material(7850.0, 2.1e11, 0.3)
RUBBER = Material(1161.5444, 1.2345678901e6, 0.42, "neo_hookean", retardation_time=1.25e-4)
LEAD = Material(11340.0, 1.6e10, 0.44)


def pad(values: tuple[float, ...], dimension: int) -> tuple[float, ...]:
    return (*values, 0.3)[:dimension]


def rich_scene(dimension: int, frame: StageFrame | None) -> Scene:
    """A scene that uses every field."""
    turned = np.eye(4)
    turned[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    turned[:2, 3] = 3.0, 1.0
    points, triangles = cube()
    cloud = np.array([(5.0, 0.5, 0.0), (5.25, 0.75, 0.0)])
    field = VelocityField(
        kind="sine", amplitude=pad((0.1, 0.2), dimension), axis=pad((0.6, 0.8), dimension),
        origin=pad((0.5, 0.25), dimension), length=1.7, mode=2,
    )  # fmt: skip
    twist = VelocityField(kind="twist", rate=3.5, axis=(0.6, 0.0, 0.8), origin=(0.5, 0.25, 0.125), length=1.3, mode=2)
    size = (1.2, 0.3, 0.5)[:dimension]
    bodies = (
        Body(
            name="plain", shape=Box(size, (0.1, 0.2)), material=STEEL, spacing=0.1, node_axes=(1,),
            bonded_to=("turned",), velocity=pad((1.5, -2.5), dimension),
            angular_velocity=0.7 if dimension == 2 else (0.1, 0.2, 0.3),
        ),
        Body(
            name="turned", shape=Box(size, placement=turned), material=RUBBER, spacing=0.1, node_axes=(0,),
            velocity_field=twist if dimension == 3 else None,
        ),
        Body(
            name="ring", shape=Cylinder(0.5, 1.0, inner_radius=0.21), material=STEEL, spacing=0.1,
            parts=(
                Part(name="coat", region=Cylinder(0.5, 2.0, inner_radius=0.4), material=RUBBER),
                Part(name="plain", region=Box((0.3, 0.3), (0.4, 0.0)), material=LEAD),
            ),
        ),
        Body(name="ball", shape=Sphere(0.4, (1, 2)), material=RUBBER, spacing=0.1, velocity_field=field),
        Body(name="mesh", shape=Mesh(points, triangles, placement=turned), material=STEEL, spacing=0.125),
        Body(name="cloud", shape=Points(cloud, cloud * (0.5, 1, 0)), material=STEEL, spacing=0.25),
    )  # fmt: skip
    rows = np.array([(0.0, 0.0, 0.0), (0.1, -0.2, 0.3)])[:, :dimension]
    sine = HarmonicMotion(amplitude=pad((0.0, 0.01), dimension), frequency=3.3, phase=0.4)
    axis = () if dimension == 2 else (0.6, 0.0, 0.8)
    table = TableMotion(times=np.array([0.0, 0.25]), displacements=rows, interpolation="cubic")
    turn = HarmonicRotation(amplitude=-0.2, frequency=1.5, phase=0.1, pivot=pad((1.0, 2.0), dimension), axis=axis)
    angles = TableRotation(
        times=np.array([0.0, 0.5]), angles=np.array([0.0, -1.25]), pivot=pad((0.5, 0.25), dimension), axis=axis,
        interpolation="cubic",
    )  # fmt: skip
    walls = (
        Wall(name="floor", shape=Box((9.0, 0.2, 1.0)[:dimension], (0.0, -3.0)), spacing=0.1, node_axes=(0,)),
        Wall(
            name="paddle", shape=Box(size, (9.0, 9.0)), spacing=0.1, motion=sine, rotation=turn, slip="no", friction=0.3
        ),
        Wall(name="drum", shape=Cylinder(0.5, 1.0, "z", (-9.0, 3.0), 0.2), spacing=0.1, motion=table, rotation=angles),
    )
    supports = (
        Support(name="roller", region=Box((0.3, 0.3)), axes=(1,), bodies=("plain", "ring"), motion=sine),
        Support(name="clamp", region=Box((9, 9)), motion=TableMotion(times=np.array([0.0, 0.25]), displacements=rows)),
        Support(name="pin", region=Sphere(0.2, placement=turned), hold_rotation=False),
    )
    loads = (
        Load(name="pull", region=Cylinder(0.3), force=pad((7.0, 8.0), dimension), frequency=2.0, phase=0.1),
        Load(name="tide", region=Box((2, 2)), acceleration=pad((0.3, -0.4), dimension), bodies=("ball",)),
    )
    probes = (
        Probe(name="tip", point=pad((0.65, 0.15), dimension), quantity="velocity"),
        Probe(name="middle", region=Box((0.2, 0.2))),
        Probe(name="cut", region=Box((2.0, 0.9)), quantity="section_moment", about=pad((0.6, 0.2), dimension)),
        Probe(name="strain", point=pad((0.65, 0.15), dimension), quantity="strain"),
        Probe(name="push", support="clamp", quantity="reaction"),
        Probe(name="spin", body="ball", quantity="angular_momentum"),
        Probe(name="load", body="floor", quantity="contact_force"),
    )
    measurements = (
        Measurement(
            name="first mode", measure="frequency", probe="tip", component=1, unit="Hz", reference=12.3456789012345
        ),
        Measurement(name="shear", measure="maximum", probe="strain", component=3),
        Measurement(
            name="first-mode", measure="harmonic_phase", probe="push", frequency=2.0, source="Rao", start=0.1, end=0.4
        ),
    )
    return Scene(
        name="rich", bodies=bodies, walls=walls, supports=supports, loads=loads, probes=probes,
        measurements=measurements, duration=0.5, dimension=dimension,
        plane="stress" if dimension == 2 else "strain", stage=frame,
        gravity=pad((1.0, -9.75), dimension), elasticity=Elasticity(effective_radius=2.6, normalization="particle"),
        contact=Contact(between="all", stiffness=0.5, friction=0.2), damping=0.25,
        outputs=("von_mises", "stress"), frame_rate=50.0, sample_rate=400.0,
        time_step=1.2345678901e-6, courant=0.2, load_steps=7, theta=0.75,
    )  # fmt: skip


def same(a: Any, b: Any, dimension: int) -> None:
    """Assert that two parts of scenes are numerically the same, shapes by what they contain."""
    assert type(a) is type(b) or isinstance(a, tuple | np.ndarray | int | float)
    if isinstance(a, Shape):
        random = np.random.default_rng(3).uniform(-1.0, 6.0, (4000, dimension))
        np.testing.assert_array_equal(contains(a, random, 0.0), contains(b, random, 0.0))
    elif dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            if field.name not in ("path", "node_axes", "stage"):
                same(getattr(a, field.name), getattr(b, field.name), dimension)
    elif isinstance(a, tuple | list | np.ndarray | float) and np.asarray(a).dtype.kind in "fi":
        np.testing.assert_allclose(b, a, rtol=2e-7, atol=1e-12)
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for first, second in zip(a, b, strict=True):
            same(first, second, dimension)
    else:
        assert a == b


@pytest.mark.parametrize(
    ("dimension", "frame"),
    [
        (2, None),
        (2, StageFrame(axes="xz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=0.5)),
        (2, StageFrame(axes="yz", up_axis="Z")),
        (3, None),
        (3, StageFrame(axes="xyz", up_axis="Z", meters_per_unit=1e-3)),
    ],
)
@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_what_is_saved_is_read_back(tmp_path: Path, dimension: int, frame: StageFrame | None, suffix: str) -> None:
    scene = rich_scene(dimension, frame)
    path = tmp_path / "deep" / f"rich.{suffix}"
    save_stage(scene, path)
    back = read_stage(path)
    same(scene, back, dimension)
    assert back.frame == scene.frame
    assert back.time_step == scene.time_step
    for a, b in zip(scene.bodies, back.bodies, strict=True):
        first, second = (fill(body.shape, body.spacing, dimension, node_axes=body.node_axes) for body in (a, b))
        assert len(first) == len(second)
        key = [np.lexsort(rows.round(5).T) for rows in (first, second)]
        np.testing.assert_allclose(second[key[1]], first[key[0]], atol=2e-6)


def test_a_saved_stage_says_what_it_is(tmp_path: Path) -> None:
    save_stage(rich_scene(2, None), tmp_path / "rich.usda")
    stage = Usd.Stage.Open(str(tmp_path / "rich.usda"))
    assert stage.GetDefaultPrim().GetName() == "World"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    body = stage.GetPrimAtPath("/World/Bodies/plain")
    # As it is written, known to USD or not: the plugin may have come after USD's first look for schemas.
    assert "MpsBodyAPI" in body.GetMetadata("apiSchemas").GetAppliedItems()
    assert body.GetAttribute("mps:spacing").GetTypeName() == "double"
    # Two materials for six bodies, a third for a part that has the name of a body.
    materials = stage.GetPrimAtPath("/World/Materials").GetChildren()
    assert [prim.GetName() for prim in materials] == ["plain", "turned", "plain_"]


def test_a_saved_stage_passes_the_validators(tmp_path: Path) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    save_stage(rich_scene(3, None), tmp_path / "rich.usda")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    assert validators
    errors = validation.ValidationContext(validators).Validate(Usd.Stage.Open(str(tmp_path / "rich.usda")))
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_refusals(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    scene = rich_scene(2, None)
    with pytest.raises(InputError, match="must end in one of"):
        save_stage(scene, tmp_path / "rich.txt")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        save_stage(scene, tmp_path / "file" / "rich.usda")
    probe = Probe(name="first mode", point=(0.0, 0.0))
    with pytest.raises(InputError, match="'first mode' is not a valid prim name"):
        save_stage(dataclasses.replace(scene, probes=(*scene.probes, probe)), tmp_path / "rich.usda")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("fields", [{"analysis": "static"}, {"integrator": "implicit", "time_step": 1e-3}])
def test_how_bodies_are_advanced_is_read_back(tmp_path: Path, fields: dict[str, Any]) -> None:
    scene = Scene(bodies=(block(2),), duration=1.0, **fields)
    save_stage(scene, tmp_path / "case.usda")
    back = read_stage(tmp_path / "case.usda")
    assert {name: getattr(back, name) for name in fields} == fields
    assert back.implicit

"""Shapes that prims are made of by relationships, and fluids below a level: read, saved, refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.scenes import RUBBER
from tests.shapes.surfaces import cube
from tests.usd.case.stages import HEAD, write
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Body, Fluid, Scene, StageFrame, Support, Wall
from warp_mps.shapes import Box, Cylinder, Difference, Intersection, Mesh, Points, Shape, Sphere, Union, contains, fill
from warp_mps.usd.case.composites import operations
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.case.save import save_stage

A, B, C = Box((0.6, 0.5, 0.4)), Sphere(0.3, (0.2, 0.1, 0.0)), Cylinder(0.2, 0.8, "y", inner_radius=0.1)
D = Mesh(*cube()).turned(0.4, "x").moved((0.0, 0.3, 0.1))
SHAPES = [
    A - B,
    A | B,
    A & B,
    (A | B) - C,
    (A - B) | C,
    ((A - B) | C) & D,
    (A & B) | (C - D),
    A - (B - (C | D)),
    C - B,
    ((A & B) | C) - D,
]
# a beam with a hole, to whose upper edge half a disc is added that a slab cuts
PARTS = {
    "Beam": ("rel mps:plus = [</Disc>]", "rel mps:minus = [</Hole>]"),
    "Disc": (
        *("Sphere", "double radius = 0.5", "rel mps:intersect = </Slab>"),
        *("double3 xformOp:translate = (0, 0.5, 0)", 'uniform token[] xformOpOrder = ["xformOp:translate"]'),
    ),
    "Slab": (
        *("Cube", "double size = 1", "double3 xformOp:scale = (4, 0.5, 1)"),
        "double3 xformOp:translate = (0, 0.65, 0)",
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]',
    ),
    "Hole": ("Cylinder", "double radius = 0.2", "double mps:innerRadius = 0.1", 'uniform token axis = "Z"'),
}


def members(shape: Shape, dimension: int = 3) -> np.ndarray:
    """Which points of a cloud lie in a shape."""
    return contains(shape, np.random.default_rng(4).uniform(-0.9, 0.9, (5000, dimension)), 0.0)


def test_a_prim_is_joined_with_those_it_refers_to(tmp_path: Path) -> None:
    """((beam | (disc & slab)) - ring), counted by hand from a lattice of 20 x 20 and 4 rows above it."""
    (body,) = read_stage(write(tmp_path, **PARTS)).bodies
    expected = (Box((1.0, 1.0)) | (Sphere(0.5, (0.0, 0.5)) & Box((4.0, 0.5), (0.0, 0.65)))) - Cylinder(
        0.2, inner_radius=0.1
    )
    np.testing.assert_array_equal(members(body.shape, 2), members(expected, 2))
    x = 0.05 * (np.mgrid[-10:10, -10:30].reshape(2, -1).T + 0.5)
    radius = np.linalg.norm(x, axis=1)
    beam = np.abs(x).max(axis=1) < 0.5
    disc = (np.linalg.norm(x - (0.0, 0.5), axis=1) < 0.5) & (x[:, 1] > 0.4) & (x[:, 1] < 0.9)
    count = np.sum((beam | disc) & ~((radius > 0.1) & (radius < 0.2)))
    assert len(fill(body.shape, 0.05, 2)) == count


@pytest.mark.parametrize("shape", SHAPES)
def test_every_order_of_operations_becomes_that_of_a_prim(shape: Shape) -> None:
    """Exactly, and also within a tolerance of faces."""
    base, found = operations(shape)
    assert base is shape.leaves()[0]
    joined = base
    for name, join in (("mps:plus", Union), ("mps:intersect", Intersection), ("mps:minus", Difference)):
        for other in found[name]:
            joined = join(joined, other)
    points = np.random.default_rng(5).uniform(-0.9, 0.9, (5000, 3))
    for tolerance in (-0.02, 0.0, 0.02):
        np.testing.assert_array_equal(contains(joined, points, tolerance), contains(shape, points, tolerance))


@pytest.mark.parametrize(
    "frame", [StageFrame(axes="xyz"), StageFrame(axes="xyz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=2.0)]
)
def test_composites_are_saved_and_read_back(tmp_path: Path, frame: StageFrame) -> None:
    bodies = tuple(
        Body(name=f"b{n}", shape=shape.moved((3.0 * n, 0, 0)), material=RUBBER, spacing=0.1, node_axes=(1,))
        for n, shape in enumerate(SHAPES)
    )
    support = Support(name="b0", region=(Box((0.3, 1.0, 1.0)) - B), bodies=("b0",))
    scene = Scene(bodies=bodies, supports=(support,), dimension=3, duration=1.0, stage=frame)
    save_stage(scene, tmp_path / "case.usda")
    back = read_stage(tmp_path / "case.usda")
    for body, again in zip(bodies, back.bodies, strict=True):
        shift = np.array((-3.0 * float(body.name[1:]), 0, 0))
        np.testing.assert_array_equal(members(again.shape.moved(shift)), members(body.shape.moved(shift)))
        first, second = (fill(item.shape, 0.1, 3, node_axes=item.node_axes) for item in (body, again))
        np.testing.assert_allclose(second, first, atol=1e-6)
    np.testing.assert_array_equal(members(back.supports[0].region), members(support.region))
    stage = Usd.Stage.Open(str(tmp_path / "case.usda"))
    shapes = stage.GetPrimAtPath("/World/Shapes").GetChildren()
    assert {UsdGeom.Imageable(prim).GetPurposeAttr().Get() for prim in shapes} == {"guide"}
    validation = pytest.importorskip("pxr.UsdValidation")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    errors = validation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


@pytest.mark.parametrize("axes", ["xy", "xz", "yz"])
def test_composites_of_a_plane_are_saved_and_read_back(tmp_path: Path, axes: str) -> None:
    frame = StageFrame(axes=axes, up_axis="Y" if axes == "xy" else "Z")
    shape = (Box((0.6, 0.5)) | Sphere(0.3, (0.2, 0.1))) - Box((0.2, 0.2), (0.1, 0.0)).turned(0.3)
    wall = Wall(name="wall", shape=shape.moved((3.0, 0.0)), spacing=0.05)
    scene = Scene(
        bodies=(Body(name="body", shape=shape, material=RUBBER, spacing=0.05),), walls=(wall,), duration=1, stage=frame
    )
    save_stage(scene, tmp_path / "case.usda")
    back = read_stage(tmp_path / "case.usda")
    np.testing.assert_allclose(fill_scene(back).positions, fill_scene(scene).positions, atol=1e-9)


LEVEL = """
def PhysicsScene "Scene"
{
    int mps:dimension = %d
    double mps:duration = 1
}
def %s "Water"
{
    token mps:role = "fluid"
    double mps:spacing = 5
    double mps:fillLevel = %g
    double %s
}
"""


@pytest.mark.parametrize(("up", "dimension"), [("Y", 2), ("Z", 2), ("Y", 3), ("Z", 3)])
def test_a_fluid_below_its_level(tmp_path: Path, up: str, dimension: int) -> None:
    """A cube of 1 m in a stage in centimetres, filled to 20 cm above its middle."""
    path = tmp_path / "case.usda"
    head = HEAD.format(length=0.01, mass=1.0, up=up)
    path.write_text(head + LEVEL % (dimension, "Cube", 20.0, "size = 100"))
    (fluid,) = read_stage(path).fluids
    positions = fill(fluid.shape, fluid.spacing, dimension)
    assert len(positions) == 14 * 20 ** (dimension - 1)
    vertical = 1 if dimension == 2 or up == "Y" else 2
    assert positions[:, vertical].max() == pytest.approx(0.2 - 0.025)
    save_stage(read_stage(path), tmp_path / "again.usda")
    np.testing.assert_allclose(fill(read_stage(tmp_path / "again.usda").fluids[0].shape, 0.05, dimension), positions)


def test_a_round_fluid_below_its_level(tmp_path: Path) -> None:
    path = tmp_path / "case.usda"
    path.write_text(HEAD.format(length=0.01, mass=1.0, up="Y") + LEVEL % (2, "Sphere", 0.0, "radius = 100"))
    (fluid,) = read_stage(path).fluids
    positions = fill(fluid.shape, 0.02, 2)
    assert len(positions) * 0.02**2 == pytest.approx(0.5 * np.pi, rel=0.01)
    assert positions[:, 1].max() == pytest.approx(-0.01)


def test_a_body_can_be_taken_out_of_a_fluid_by_its_own_prim(tmp_path: Path) -> None:
    water = (
        *("Cube", 'token mps:role = "fluid"', "double mps:spacing = 0.1", "double size = 3"),
        "rel mps:minus = </Beam>",
    )
    scene = read_stage(write(tmp_path, Water=water))
    assert fill_scene(scene).displaced == ()
    assert fill_scene(scene).liquid == 30**2 - 10**2


@pytest.mark.parametrize(
    ("parts", "where", "attribute", "reason"),
    [
        ({"Beam": ("rel mps:minus = </Nowhere>",)}, "/Beam", "mps:minus", "there is no prim at that path"),
        ({"Beam": ("rel mps:minus = </Beam>",)}, "/Beam", "mps:minus", "refers to /Beam, which is made of /Beam"),
        (
            {**PARTS, "Slab": ("Cube", "double size = 1", "rel mps:plus = </Beam>")},
            *("/Slab", "mps:plus", "refers to /Beam, which is made of /Slab itself"),
        ),
        ({"Beam": ("rel mps:plus = </Steel>",)}, "/Steel", "", "is Material, must be one of: Cube"),
        ({"Beam": ('string mps:plus = "Disc"',)}, "/Beam", "mps:plus", "must be a relationship"),
        (
            {**PARTS, "Disc": ("Sphere", "double mps:inerRadius = 1")},
            "/Disc",
            "mps:inerRadius",
            "has no effect: the prim has no mps:role",
        ),
        ({**PARTS, "Disc": ("Sphere", "double mps:innerRadius = 1")}, "/Disc", "mps:innerRadius", "is of a Cylinder"),
        (
            {**PARTS, "Disc": ("Points", "point3f[] points = [(0, 0, 0)]")},
            *("/Beam", "mps:plus", "needs shapes with an inside: /Disc is of ready-made particles"),
        ),
        ({"Beam": ("double mps:fillLevel = 0",)}, "/Beam", "mps:fillLevel", "is for: fluid"),
        (
            {
                "Beam": ("rel mps:plus = [</L0>, </R0>]",),
                **{
                    f"{side}{n}": ("Cube", "double size = 1", f"rel mps:plus = [</L{n + 1}>, </R{n + 1}>]")
                    for n in range(40)
                    for side in "LR"
                },
                **{f"{side}40": ("Cube", "double size = 1") for side in "LR"},
            },
            *("/Beam", "mps:plus", "makes a shape of more than 200 others"),
        ),
        (
            {"Beam": ("rel mps:intersect = </Hole>",), "Hole": ("Sphere", "double radius = 0.01")},
            *("/Beam", "", "is empty, or thinner than one particle"),
        ),
    ],
)
def test_refusals(tmp_path: Path, parts: dict[str, tuple[str, ...]], where: str, attribute: str, reason: str) -> None:
    with pytest.raises(InputError) as caught:
        fill_scene(read_stage(write(tmp_path, **parts)))
    assert (caught.value.where, caught.value.attribute) == (where, attribute)
    assert reason in caught.value.reason


@pytest.mark.parametrize(
    ("up", "dimension", "kind", "level", "reason"),
    [
        ("Y", 2, "Cube", 60.0, "is 0.6 m, must lie in the region, which reaches from -0.5 to 0.5 m"),
        ("Y", 3, "Cube", -50.0, "must lie in the region"),
    ],
)
def test_levels_that_are_not_in_the_shape(
    tmp_path: Path, up: str, dimension: int, kind: str, level: float, reason: str
) -> None:
    path = tmp_path / "case.usda"
    path.write_text(HEAD.format(length=0.01, mass=1.0, up=up) + LEVEL % (dimension, kind, level, "size = 100"))
    with pytest.raises(InputError) as caught:
        read_stage(path)
    assert (caught.value.where, caught.value.attribute) == ("/Water", "mps:fillLevel")
    assert reason in caught.value.reason
    assert "the stage's unit is 0.01 m" in caught.value.reason


def test_a_level_needs_the_up_axis_in_the_plane(tmp_path: Path) -> None:
    path = tmp_path / "case.usda"
    text = HEAD.format(length=0.01, mass=1.0, up="Z") + LEVEL % (2, "Cube", 0.0, "size = 100")
    path.write_text(
        text.replace(
            "int mps:dimension", 'token mps:plane = "xy"\n    float physics:gravityMagnitude = 0\n    int mps:dimension'
        )
    )
    with pytest.raises(InputError, match="/Water mps:fillLevel: is along the up axis, z, which is not in the plane xy"):
        read_stage(path)


def test_ready_made_particles_have_no_level(tmp_path: Path) -> None:
    path = tmp_path / "case.usda"
    text = HEAD.format(length=0.01, mass=1.0, up="Y") + LEVEL % (2, "Points", 0.0, "size = 1")
    path.write_text(text.replace("double size = 1", "point3f[] points = [(0, 0, 0)]"))
    with pytest.raises(InputError, match="/Water mps:fillLevel: is for a shape with an inside"):
        read_stage(path)


def test_fluids_and_points_in_python_are_not_joined() -> None:
    with pytest.raises(InputError, match="Union first: is Points"):
        Points([(0.0, 0.0)]) | A
    assert Fluid(name="water", shape=A - B, spacing=0.1).shape.leaves() == (A, B)

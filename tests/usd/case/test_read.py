"""Reading stages: units, axes, transforms, names and overrides."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tests.usd.case.stages import write
from warp_mps.scene import HarmonicMotion, TableMotion
from warp_mps.shapes import Box, Mesh, Points, contains, fill
from warp_mps.usd.case.attributes import TABLE
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.case.stage_errors import stage_name


def test_smallest_stage(tmp_path: Path) -> None:
    scene = read_stage(write(tmp_path))
    assert (scene.name, scene.path, scene.dimension, scene.duration) == ("case", "/Scene", 2, 2.0)
    assert scene.gravity == (0.0, 0.0)
    (body,) = scene.bodies
    assert (body.name, body.path, body.spacing) == ("Beam", "/Beam", 0.1)
    assert dataclasses.astuple(body.material) == (7800.0, 2e11, 0.3, "st_venant_kirchhoff", 0.0, "/Steel")
    assert len(fill(body.shape, body.spacing, 2)) == 100


def test_defaults_are_those_of_the_scene(tmp_path: Path) -> None:
    scene = read_stage(write(tmp_path))
    for field in ("plane", "frame_rate", "sample_rate", "time_step", "courant", "damping", "elasticity", "contact"):
        default = next(entry.default for entry in dataclasses.fields(scene) if entry.name == field)
        assert getattr(scene, field) == default


def test_units_are_settled(tmp_path: Path) -> None:
    load = ("Cube", 'token mps:role = "load"', "double3 mps:force = (6, 0, 0)", "double3 mps:acceleration = (0, 7, 0)")
    motion = ("Cube", 'token mps:role = "support"', "double3[] mps:motion:displacements = [(0, 0, 0), (1, 2, 0)]")
    body = ("double mps:spacing = 100", "double3 mps:velocity = (3, 0, 0)", "double size = 1000")
    body += ("double3 mps:angularVelocity = (0, 0, 5)",)
    scene = read_stage(
        write(
            tmp_path, length=1e-3, mass=1e3, Beam=body, Load=load, Held=(*motion, "double[] mps:motion:times = [0, 1]"),
            Scene=("float physics:gravityMagnitude = -1",),
        )
    )  # fmt: skip
    (beam,) = scene.bodies
    assert beam.material.density == pytest.approx(7800e3 / 1e-9)
    assert beam.material.youngs_modulus == pytest.approx(2e11 * 1e3 / 1e-3)
    assert beam.spacing == pytest.approx(0.1)
    assert beam.velocity == pytest.approx((3e-3, 0))
    assert beam.angular_velocity == pytest.approx(5)
    assert len(fill(beam.shape, beam.spacing, 2)) == 100
    assert scene.loads[0].force == pytest.approx((6.0, 0))
    assert scene.loads[0].acceleration == pytest.approx((0, 7e-3))
    motion = scene.supports[0].motion
    assert isinstance(motion, TableMotion)
    np.testing.assert_allclose(motion.displacements, [(0, 0), (1e-3, 2e-3)])
    assert scene.gravity == pytest.approx((0, -9.81))


@pytest.mark.parametrize(
    ("up", "plane", "vector", "turn", "normal"),
    [
        ("Y", "", (1, 2, 0), (1, 2), (0, 0, 1)),
        ("Z", "", (1, 0, 2), (1, 2), (0, -1, 0)),
        ("Z", "yz", (0, 1, 2), (1, 2), (1, 0, 0)),
    ],
)
def test_planes(tmp_path: Path, up: str, plane: str, vector: tuple, turn: tuple, normal: tuple) -> None:
    scene_lines = (f'token mps:plane = "{plane}"',) if plane else ()
    spin = tuple(3 * part for part in normal)
    gravity = ("float physics:gravityMagnitude = 9.81", f"vector3f physics:gravityDirection = {vector}")
    body = (f"double3 mps:velocity = {vector}", f"double3 mps:angularVelocity = {spin}")
    move = (f"double3 xformOp:translate = {vector}", 'uniform token[] xformOpOrder = ["xformOp:translate"]')
    axis = "xyz"[vector.index(2)]
    probe = ("Xform", 'token mps:role = "probe"', *move)
    mark = ("Scope", 'token mps:role = "measurement"', 'token mps:measure = "final"', "rel mps:probe = </Tip>")
    held = ("Cube", 'token mps:role = "support"', f'token mps:axes = "{axis}"')
    scene = read_stage(
        write(
            tmp_path, up=up, Scene=(*scene_lines, *gravity),
            Beam=(*body, *move, f"double3 xformOp:scale = {tuple(max(part, 0.3) for part in vector)}",
                  'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]'),
            Tip=probe, Mark=(*mark, f'token mps:component = "{axis}"'), Held=held,
        )
    )  # fmt: skip
    assert scene.bodies[0].velocity == turn
    assert scene.bodies[0].angular_velocity == pytest.approx(3)
    assert scene.probes[0].point == turn
    assert scene.measurements[0].component == 1
    assert scene.supports[0].axes == (1,)
    assert scene.gravity == pytest.approx(9.81 * np.array(turn) / np.sqrt(5))
    positions = fill(scene.bodies[0].shape, 0.1, 2)
    np.testing.assert_allclose(positions.mean(0), turn, atol=1e-12)
    np.testing.assert_allclose(np.ptp(positions, axis=0), (0.9, 1.9))


def test_three_dimensions_keep_the_axes(tmp_path: Path) -> None:
    scene = read_stage(write(tmp_path, up="Z", Scene=("-mps:dimension", "-physics:gravityMagnitude")))
    assert scene.dimension == 3
    assert scene.gravity == pytest.approx((0, 0, -9.81))
    assert scene.frame.axes == "xyz"


def test_nested_transforms(tmp_path: Path) -> None:
    text = """
def Xform "Rig"
{
    double3 xformOp:translate = (10, 0, 0)
    double xformOp:rotateZ = 90
    double3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ", "xformOp:scale"]
    def Cube "Beam"
    {
        token mps:role = "body"
        double mps:spacing = 0.1
        rel material:binding:physics = </Steel>
        double size = 1
        double3 xformOp:translate = (1, 0, 0)
        double3 xformOp:scale = (0.5, 0.1, 0.1)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
        token mps:nodeAxes = "x"
    }
}
"""
    scene = read_stage(write(tmp_path, text=text))
    assert [body.name for body in scene.bodies] == ["Beam", "Rig_Beam"]
    body = scene.bodies[1]
    positions = fill(body.shape, body.spacing, 2, node_axes=body.node_axes)
    # 1 m x 0.2 m, upright about (10, 2): nodes along its own x, which is the stage's y.
    assert len(positions) == 11 * 2
    np.testing.assert_allclose(positions.mean(0), (10, 2), atol=1e-12)
    np.testing.assert_allclose(np.ptp(positions, axis=0), (0.1, 1.0))


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 2, 2), (2, 1, 1), (1, 2, 1)])
def test_round_shapes(tmp_path: Path, scale: tuple[float, ...]) -> None:
    stretch = (f"double3 xformOp:scale = {scale}", 'uniform token[] xformOpOrder = ["xformOp:scale"]')
    ball = ("Sphere", 'token mps:role = "support"', "double radius = 0.5", *stretch)
    ring = (
        "Cylinder",
        'token mps:role = "support"',
        "double radius = 0.5",
        "double height = 1",
        'uniform token axis = "X"',
    )
    scene = read_stage(
        write(
            tmp_path,
            Scene=("int mps:dimension = 3",),
            Ball=ball,
            Ring=(*ring, "double mps:innerRadius = 0.25", *stretch),
        )
    )
    sphere, tube = (support.region for support in scene.supports)
    a, b, c = np.asarray(scale) * 0.5
    points = np.random.default_rng(0).uniform(-1.1, 1.1, (2000, 3))
    x, y, z = points.T
    np.testing.assert_array_equal(contains(sphere, points, 0), (x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 <= 1)
    across = (y / b) ** 2 + (z / c) ** 2
    np.testing.assert_array_equal(contains(tube, points, 0), (abs(x) <= a) & (across <= 1) & (across >= 0.25))


def test_polygons_are_cut_into_triangles(tmp_path: Path) -> None:
    # A hexagonal prism: two hexagons and six quads.
    angles = np.arange(6) * np.pi / 3
    points = [(np.cos(a), np.sin(a), z) for z in (-0.5, 0.5) for a in angles]
    sides = [index for k in range(6) for index in (k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6)]
    mesh = (
        "Mesh",
        'token mps:role = "body"',
        "double mps:spacing = 0.02",
        "rel material:binding:physics = </Steel>",
        f"point3f[] points = [{', '.join(str(tuple(map(float, p))) for p in points)}]",
        "int[] faceVertexCounts = [6, 6, 4, 4, 4, 4, 4, 4]",
        f"int[] faceVertexIndices = {[*range(6), *range(6, 12), *sides]}",
    )
    shape = read_stage(write(tmp_path, Hexagon=mesh)).bodies[1].shape
    assert isinstance(shape, Mesh)
    assert len(shape.triangles) == 20
    assert len(fill(shape, 0.02, 2)) * 0.02**2 == pytest.approx(1.5 * np.sqrt(3), rel=0.01)


def test_ready_made_particles_turn_with_their_prim(tmp_path: Path) -> None:
    cloud = (
        "Points",
        'token mps:role = "body"',
        "double mps:spacing = 1",
        "rel material:binding:physics = </Steel>",
        "point3f[] points = [(1, 0, 0), (2, 0, 0)]",
        "vector3f[] velocities = [(1, 0, 0), (0, 0, 0)]",
        "double xformOp:rotateZ = 90",
        'uniform token[] xformOpOrder = ["xformOp:rotateZ"]',
    )
    shape = read_stage(write(tmp_path, length=0.5, Cloud=cloud)).bodies[1].shape
    assert isinstance(shape, Points)
    np.testing.assert_allclose(fill(shape, 0.5, 2), [(0, 0.5), (0, 1)], atol=1e-7)
    assert shape.velocities is not None
    np.testing.assert_allclose(shape.velocities, [(0, 0.5, 0), (0, 0, 0)], atol=1e-7)


def test_relationships_motions_and_fields(tmp_path: Path) -> None:
    field = (
        'token mps:velocityField = "sine"',
        "double3 mps:velocityField:amplitude = (0, 1, 0)",
        "double3 mps:velocityField:axis = (1, 0, 0)",
        "double3 mps:velocityField:origin = (-0.5, 0, 0)",
        "double mps:velocityField:length = 1",
        "int mps:velocityField:mode = 3",
    )
    held = ("Cube", 'token mps:role = "support"', "rel mps:bodies = </Beam>", "bool mps:holdRotation = true")
    held += ("double3 mps:motion:amplitude = (0, 2, 0)", "double mps:motion:frequency = 4")
    reaction = ("Xform", 'token mps:role = "probe"', 'token mps:quantity = "reaction"', "rel mps:target = </Held>")
    mean = ("Cube", 'token mps:role = "probe"')
    whole = ("Scope", 'token mps:role = "probe"', "rel mps:target = </Beam>")
    scene = read_stage(write(tmp_path, Beam=field, Held=held, Reaction=reaction, Mean=mean, Whole=whole))
    given = scene.bodies[0].velocity_field
    assert given is not None
    assert (given.kind, given.amplitude, given.axis, given.origin) == ("sine", (0, 1), (1, 0), (-0.5, 0))
    assert (given.length, given.mode) == (1, 3)
    (support,) = scene.supports
    assert (support.bodies, support.hold_rotation) == (("Beam",), True)
    assert support.motion == HarmonicMotion(amplitude=(0, 2), frequency=4)
    assert [(p.support, p.body, p.region is not None) for p in scene.probes] == [
        ("Held", None, False),
        (None, None, True),
        (None, "Beam", False),
    ]


def test_parts_of_a_body_have_materials_of_their_own(tmp_path: Path) -> None:
    lead = ("Material", "float physics:density = 11340", "double mps:youngsModulus = 1.6e10")
    lead += ("double mps:poissonsRatio = 0.44",)
    core = ("Cube", 'token mps:role = "part"', "double size = 0.5", "rel mps:body = </Beam>")
    coat = (*core, "rel material:binding:physics = </Steel>", "float physics:density = 7000")
    scene = read_stage(write(tmp_path, Lead=lead, Core=(*core, "rel material:binding:physics = </Lead>"), Coat=coat))
    (body,) = scene.bodies
    assert [(part.name, part.path) for part in body.parts] == [("Core", "/Core"), ("Coat", "/Coat")]
    assert [material.density for material in scene.materials] == [7800.0, 11340.0, 7000.0]
    region = body.parts[0].region
    assert isinstance(region, Box)
    assert region.size == (0.5, 0.5, 0.5)


def test_measurement_takes_its_display_name_and_no_units(tmp_path: Path) -> None:
    tip = ("Xform", 'token mps:role = "probe"')
    text = """
def Scope "F" ( displayName = "first mode" )
{
    token mps:role = "measurement"
    token mps:measure = "frequency"
    rel mps:probe = </Tip>
    double mps:reference = 12.5
    string mps:unit = "Hz"
    string mps:source = "Rao"
    double mps:end = 1.5
}
"""
    (measurement,) = read_stage(
        write(tmp_path, length=0.25, Beam=("double mps:spacing = 0.2",), Tip=tip, text=text)
    ).measurements
    assert (measurement.name, measurement.reference, measurement.unit) == ("first mode", 12.5, "Hz")
    assert (measurement.probe, measurement.source, measurement.start, measurement.end) == ("Tip", "Rao", 0, 1.5)


def test_density_of_the_body_wins_and_inactive_prims_do_not_count(tmp_path: Path) -> None:
    text = 'def Xform "Off" ( active = false )\n{\n    def Cube "B"\n    {\n        token mps:role = "body"\n    }\n}\n'
    scene = read_stage(write(tmp_path, Beam=("float physics:density = 1.25",), text=text))
    assert [body.name for body in scene.bodies] == ["Beam"]
    assert scene.bodies[0].material.density == 1.25


def test_materials_are_inherited_and_may_be_bound_for_all_purposes(tmp_path: Path) -> None:
    text = """
def Xform "Group" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{
    rel material:binding = </Steel>
    def Sphere "Ball"
    {
        token mps:role = "body"
        double mps:spacing = 0.1
    }
}
"""
    assert read_stage(write(tmp_path, text=text)).bodies[1].material.path == "/Steel"


def test_overrides_replace_values_for_one_reading(tmp_path: Path) -> None:
    tip = ("Xform", 'token mps:role = "probe"')
    path = write(tmp_path, Tip=tip)
    changes = {
        "/Beam.mps:spacing": "0.05",
        "/Beam.mps:velocity": "(1, -2.5e0, 0)",
        "/Beam.size": "2",
        "/Scene.mps:planeModel": "stress",
        "/Scene.physics:gravityDirection": "(0, -1, 0)",
        "/Scene.physics:gravityMagnitude": "1.5",
        "/Steel.physics:density": "1.1",
        "/Tip.mps:target": "/Beam",
    }
    scene = read_stage(path, overrides=changes)
    (body,) = scene.bodies
    assert (body.spacing, body.velocity, scene.plane, scene.gravity) == (0.05, (1, -2.5), "stress", (0, -1.5))
    assert body.material.density == 1.1
    assert scene.probes[0].body == "Beam"
    assert len(fill(body.shape, body.spacing, 2)) == 1600
    assert read_stage(path).bodies[0].spacing == 0.1


def test_every_field_of_an_error_has_one_name_in_the_stage() -> None:
    names: dict[str, str] = {}
    for row in (row for rows in TABLE.values() for row in rows.values()):
        assert names.setdefault(row.field, row.name) == row.name
        assert stage_name(row.field) == row.name

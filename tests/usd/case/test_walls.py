"""Walls in stages and in results: reading, refusals, writing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.scenes import block, scene_of
from tests.usd.case.stages import write
from warp_mps.errors import InputError
from warp_mps.observers.frames import FrameRecorder
from warp_mps.run.simulation import Simulation
from warp_mps.scene import HarmonicMotion, HarmonicRotation, Scene, TableMotion, TableRotation, Wall
from warp_mps.shapes import Box
from warp_mps.usd.case.read import read_stage

WALL = ("Cube", 'token mps:role = "wall"', "double mps:spacing = 0.2", "double size = 1")
FAR = (
    "double3 xformOp:translate = (3, 0, 0)",
    'uniform token[] xformOpOrder = ["xformOp:translate"]',
)
TURN = (
    "double mps:rotation:amplitude = 0.5",
    "double mps:rotation:frequency = 2",
    "double3 mps:rotation:pivot = (1, 2, 3)",
)


def wall_of(folder: Path, *statements: str, **stage: object) -> Wall:
    """The wall of a stage of one body and one wall."""
    (wall,) = read_stage(write(folder, Floor=(*WALL, *FAR, *statements), **stage)).walls  # type: ignore[arg-type]
    return wall


def test_a_wall_at_rest(tmp_path: Path) -> None:
    wall = wall_of(tmp_path)
    assert (wall.name, wall.path, wall.spacing, wall.slip) == ("Floor", "/Floor", 0.2, "free")
    assert (wall.motion, wall.rotation, wall.moves) == (None, None, False)
    assert isinstance(wall.shape, Box)
    assert tuple(wall.shape.center[:2]) == (3.0, 0.0)


def test_a_motion_and_a_turn_in_the_units_of_the_stage(tmp_path: Path) -> None:
    swing = ("double3 mps:motion:amplitude = (2, 0, 0)", "double mps:motion:frequency = 3", 'token mps:slip = "no"')
    wall = wall_of(tmp_path, *TURN, *swing, length=0.01)
    assert wall.slip == "no"
    assert wall.motion == HarmonicMotion(amplitude=(0.02, 0.0), frequency=3.0)
    assert isinstance(wall.rotation, HarmonicRotation)
    assert wall.rotation.pivot == pytest.approx((0.01, 0.02))
    assert (wall.rotation.amplitude, wall.rotation.frequency, wall.rotation.phase) == (0.5, 2.0, 0.0)


@pytest.mark.parametrize(("axis", "angle"), [("(0, 1, 0)", -0.5), ("(0, -3, 0)", 0.5)])
def test_an_axis_along_the_normal_is_the_sign_of_the_angle(tmp_path: Path, axis: str, angle: float) -> None:
    """The scene's plane is x-z, and its normal -y."""
    wall = wall_of(tmp_path, *TURN, f"double3 mps:rotation:axis = {axis}", up="Z")
    assert isinstance(wall.rotation, HarmonicRotation)
    assert wall.rotation.amplitude == angle
    assert wall.rotation.pivot == pytest.approx((1.0, 3.0))


def test_tables(tmp_path: Path) -> None:
    wall = wall_of(
        tmp_path,
        *("double[] mps:motion:times = [0, 1]", "double3[] mps:motion:displacements = [(0, 0, 0), (1, 2, 0)]"),
        *("double[] mps:rotation:times = [0, 2]", "double[] mps:rotation:angles = [0, 1.5]"),
        *("double3 mps:rotation:pivot = (1, 0, 0)", 'token mps:rotation:interpolation = "cubic"'),
    )
    assert isinstance(wall.motion, TableMotion)
    assert isinstance(wall.rotation, TableRotation)
    assert (wall.motion.interpolation, wall.rotation.interpolation) == ("linear", "cubic")
    np.testing.assert_array_equal(wall.motion.displacements, [[0.0, 0.0], [1.0, 2.0]])
    np.testing.assert_array_equal(wall.rotation.angles, [0.0, 1.5])


def test_a_probe_of_a_wall(tmp_path: Path) -> None:
    probe = ("Xform", 'token mps:role = "probe"', 'token mps:quantity = "contact_force"', "rel mps:target = </Floor>")
    (found,) = read_stage(write(tmp_path, Floor=(*WALL, *FAR), P=probe)).probes
    assert (found.body, found.quantity) == ("Floor", "contact_force")


def test_a_wall_and_a_body_of_one_name_go_by_their_paths(tmp_path: Path) -> None:
    lines = "".join(f"    {line}\n" for line in (*WALL[1:], *FAR))
    scene = read_stage(write(tmp_path, text=f'def Scope "Walls"\n{{\ndef Cube "Beam"\n{{\n{lines}}}\n}}\n'))
    assert [item.name for item in scene.filled] == ["Beam", "Walls_Beam"]


@pytest.mark.parametrize(
    ("statements", "attribute", "reason"),
    [
        (('token mps:slip = "some"',), "mps:slip", "must be one of: free, no"),
        (("double mps:spacing = 9",), "mps:spacing", "thinner than one particle"),
        (("rel mps:bodies = </Beam>",), "mps:bodies", "is not known here"),
        (TURN[:2], "mps:rotation:pivot", "is missing: the rotation needs it"),
        (TURN[2:], "mps:rotation:amplitude", "a rotation needs one of them"),
        (TURN[1:], "mps:rotation:amplitude", "is missing: the rotation needs it"),
        ((*TURN, "double[] mps:rotation:times = [0, 1]"), "mps:rotation:amplitude", "beside a table of angles"),
        ((*TURN, "double3 mps:rotation:axis = (1, 0, 0)"), "mps:rotation:axis", "along the normal of the plane xy"),
        ((*TURN, "double3 mps:rotation:axis = (0, 0, 0)"), "mps:rotation:axis", "has no length"),
        ((*TURN[:1], "double mps:rotation:frequency = 0", *TURN[2:]), "mps:rotation:frequency", "above 0"),
        (
            ("double[] mps:rotation:times = [0, 1]", "double[] mps:rotation:angles = [0]", TURN[2]),
            *("mps:rotation:angles", "one number for each of the 2 times"),
        ),
    ],
)  # fmt: skip
def test_refusals(tmp_path: Path, statements: tuple[str, ...], attribute: str, reason: str) -> None:
    kept = [line for line in WALL if not any("mps:spacing" in new and "mps:spacing" in line for new in statements)]
    with pytest.raises(InputError) as caught:
        read_stage(write(tmp_path, Floor=(*kept, *FAR, *statements)))
    assert (caught.value.where, caught.value.attribute) == ("/Floor", attribute)
    assert reason in caught.value.reason


def test_a_turn_in_space_needs_an_axis(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="/Floor mps:rotation:axis: is missing"):
        wall_of(tmp_path, *TURN, Scene=("int mps:dimension = 3",))
    wall = wall_of(tmp_path, *TURN, "double3 mps:rotation:axis = (0, 0, 2)", Scene=("int mps:dimension = 3",))
    assert isinstance(wall.rotation, HarmonicRotation)
    assert wall.rotation.axis == (0.0, 0.0, 2.0)


def moving() -> Scene:
    """A block, a wall at rest and one that turns."""
    turn = HarmonicRotation(amplitude=0.5, frequency=5.0, pivot=(0.0, 0.1))
    rest = Wall(name="rest", shape=Box((0.04, 0.02), (0.0, -0.025)), spacing=0.01)
    paddle = Wall(name="paddle", shape=Box((0.02, 0.06), (0.0, 0.1)), spacing=0.02, rotation=turn)
    return scene_of(block(2), walls=(rest, paddle))


def test_walls_are_points_of_the_result(tmp_path: Path) -> None:
    simulation = Simulation(moving())
    recorder = FrameRecorder(tmp_path / "run.usdc", simulation.scene, simulation.particles, every=1, provenance={})
    frames = []
    for _ in range(3):
        recorder.observe(simulation)
        frames.append(simulation.positions)
        simulation.advance(simulation.clock.frame_every)
    recorder.close()
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    assert [prim.GetName() for prim in stage.GetPrimAtPath("/Result").GetChildren()] == ["block", "rest", "paddle"]
    for name, (first, last) in zip(simulation.particles.names, simulation.particles.ranges, strict=True):
        points = UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}"))
        for code, positions in enumerate(frames):
            np.testing.assert_allclose(
                np.array(points.GetPointsAttr().Get(code))[:, :2], positions[first:last], atol=1e-8
            )
    first, last = simulation.particles.ranges[2]
    assert np.abs(frames[2][first:last] - frames[0][first:last]).max() > 0.005
    colors = {
        name: stage.GetAttributeAtPath(f"/Result/{name}.primvars:displayColor").Get()[0] for name in ("rest", "paddle")
    }
    assert (
        colors["rest"] == colors["paddle"] != stage.GetAttributeAtPath("/Result/block.primvars:displayColor").Get()[0]
    )

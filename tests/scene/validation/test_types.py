"""What a field of a scene may hold: anything else is refused in one line, which names it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.refusals import Fields, assert_refused
from tests.scenes import RUBBER
from warp_mps.scene import Body, Flow, Liquid, Load, Material, Probe, Scene, Support
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Sphere

BOX = Box((0.1, 0.1))


def body(**fields: Any) -> Body:
    return Body(**{"name": "block", "shape": BOX, "material": RUBBER, "spacing": 0.01, **fields})


def scene(**fields: Any) -> Scene:
    return Scene(**{"bodies": (body(),), "duration": 1.0, **fields})


@pytest.mark.parametrize(
    ("fields", "where", "attribute", "reason"),
    [
        (lambda: {"bodies": body()}, "scene", "bodies", "is a Body, must be a tuple of Bodies"),
        (lambda: {"bodies": (1,)}, "scene", "bodies", "is (1,), must be a tuple of Bodies"),
        (lambda: {"duration": "1"}, "scene", "duration", "is '1', must be a number"),
        (lambda: {"duration": 10**400}, "scene", "duration", "is a whole number too large for a float"),
        (lambda: {"load_steps": 10**400}, "scene", "load_steps", "is a whole number too large for a float"),
        (lambda: {"gravity": (0, -(10**400))}, "scene", "gravity", "must be a sequence of numbers"),
        (lambda: {"path": np.zeros(2)}, "scene 'case'", "path", "must be a text"),
        (lambda: {"bodies": (body(path=np.zeros(2)),)}, "body 'block'", "path", "must be a text"),
        (lambda: {"gravity": 9.81}, "scene", "gravity", "is 9.81, must be a sequence of numbers"),
        (lambda: {"gravity": ("down", 0)}, "scene", "gravity", "must be a sequence of numbers"),
        (lambda: {"dimension": 2.0}, "scene", "dimension", "is 2.0, must be a whole number"),
        (lambda: {"elasticity": "springs"}, "scene", "elasticity", "is 'springs', must be an Elasticity"),
        (lambda: {"sample_rate": "1"}, "scene", "sample_rate", "is '1', must be a number or None"),
        (lambda: {"flow": Flow(domain=((0, 0),))}, "flow", "domain", "must be a tuple of vectors or None"),
        (lambda: {"bodies": (body(shape=(1, 1)),)}, "body 'block'", "shape", "is (1, 1), must be a Shape"),
        (
            lambda: {"bodies": (body(path="/World/b", material="x"),)},
            "/World/b",
            "material",
            "is 'x', must be a Material",
        ),
        (
            lambda: {"bodies": (body(material=Material("a", 1, 0.3)),)},
            "material",
            "density",
            "is 'a', must be a",
        ),
        (
            lambda: {"bodies": (body(bonded_to="block"),)},
            "body 'block'",
            "bonded_to",
            "is 'block', must be a tuple of texts",
        ),
        (
            lambda: {"bodies": (body(velocity=3),)},
            "body 'block'",
            "velocity",
            "is 3, must be a sequence of numbers or None",
        ),
        (lambda: {"supports": (Support(name="s", region=1),)}, "support 's'", "region", "is 1, must be a Shape"),  # type: ignore[arg-type]
        (
            lambda: {"supports": (Support(name="s", region=BOX, motion=1),)},
            "support 's'",
            "motion",
            "a HarmonicMotion or a",
        ),  # type: ignore[arg-type]
        (
            lambda: {"loads": (Load(name="l", region=BOX, force=1),)},
            "load 'l'",
            "force",
            "must be a sequence of numbers",
        ),  # type: ignore[arg-type]
        (lambda: {"probes": (Probe(name=3),)}, "probe 3", "name", "is 3, must be a text"),  # type: ignore[arg-type]
    ],
)
def test_fields_of_another_kind(fields: Fields, where: str, attribute: str, reason: str) -> None:
    assert_refused(lambda: scene(**fields()), where, attribute, reason)


def test_what_is_as_good_as_a_number_a_tuple_or_an_array() -> None:
    found = scene(
        bodies=[body(spacing=np.float32(0.01), velocity=np.zeros(2), angular_velocity=np.array([1.0]))],
        duration=np.int64(1),
        gravity=[0, -9],
        dimension=np.int32(2),
    )
    assert found.bodies[0].name == "block"
    assert Liquid().density == 1000.0


@pytest.mark.parametrize(
    ("make", "where", "attribute", "reason"),
    [
        (lambda: Box(1), "Box", "size", "must be 2 or 3 numbers, not 1"),  # type: ignore[arg-type]
        (lambda: Box("ab"), "Box", "size", "must be 2 or 3 numbers, not 'ab'"),  # type: ignore[arg-type]
        (lambda: Box((1, "a")), "Box", "size", "must be 2 or 3 numbers, not (1, 'a')"),  # type: ignore[arg-type]
        (lambda: Box((1, 1), center=None), "Box", "center", "must be 2 or 3 numbers, not None"),  # type: ignore[arg-type]
        (lambda: Box((1, 1), placement="x"), "Box", "placement", "must be a finite, invertible 4 x 4"),  # type: ignore[arg-type]
        (lambda: Sphere("a"), "Sphere", "radius", "must be positive, not 'a'"),  # type: ignore[arg-type]
        (lambda: Sphere((1, 2)), "Sphere", "radius", "must be positive, not (1, 2)"),  # type: ignore[arg-type]
        (lambda: Cylinder(1, inner_radius="a"), "Cylinder", "inner_radius", "must be at least 0"),  # type: ignore[arg-type]
        (lambda: Mesh("a", "b"), "Mesh", "points", "must be finite"),  # type: ignore[arg-type]
        (lambda: Mesh(np.eye(3), np.array([[0, 1, 1.5]])), "Mesh", "triangles", "must be indices of points"),
        (lambda: Points([[1, 2], [3]]), "Points", "positions", "must be finite, shape"),  # type: ignore[arg-type, list-item]
    ],
)
def test_shapes_of_what_are_no_numbers(make: Callable[[], object], where: str, attribute: str, reason: str) -> None:
    assert_refused(make, where, attribute, reason)

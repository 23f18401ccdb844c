"""Regions: which points a shape contains, with a tolerance in metres."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shapes.surfaces import cube, torus
from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, contains

STRETCH = np.diag([10.0, 1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    "shape",
    [
        Box((1, 1, 1), (0.5, 0, 0)),
        Box((0.1, 1, 1), (0.05, 0, 0), placement=STRETCH),
        Sphere(0.5, (0.5, 0, 0)),
        Sphere(0.5, (0.05, 0, 0), placement=np.diag([1.0, 9.0, 9.0, 1.0]) + np.eye(4, k=3) * 0.45),
        Cylinder(0.5, 2.0, "y", (0.5, 0, 0)),
        Cylinder(3.0, 1.0, "x", (0.5, 0, 0)),
        Mesh(cube()[0] + (0.5, 0, 0), cube()[1]),
        Points([[1.0, 0.0, 0.0]]),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_tolerance_is_a_length_of_the_scene(shape: Shape) -> None:
    # Every shape ends at x = 1 on the x axis, whatever its scale.
    points = np.array([[1.0009, 0, 0], [1.0011, 0, 0]])
    assert contains(shape, points, 1e-3).tolist() == [True, False]


def test_faces_count_as_inside_within_rounding() -> None:
    box = Box((0.1, 1.0), (0.05, 0.5))
    points = np.array([[0.0, 0.3], [0.1, 0.3], [0.05, 1.0], [0.2, 0.3]])
    assert contains(box, points, 1e-9).tolist() == [True, True, True, False]


def test_bore_of_a_tube_is_outside() -> None:
    tube = Cylinder(1.0, inner_radius=0.5)
    assert contains(tube, np.array([[0.4, 0], [0.5, 0], [0.7, 0], [1.1, 0]]), 1e-9).tolist() == [
        False,
        True,
        True,
        False,
    ]


def test_torus_against_its_formula() -> None:
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (20_000, 3))
    signed = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.5, points[:, 2]) - 0.2
    clear = abs(signed) > 1e-3
    surface = Mesh(*torus(0.5, 0.2))
    np.testing.assert_array_equal(contains(surface, points, 0.0)[clear], signed[clear] < 0)
    clear = abs(signed - 0.05) > 1e-3
    np.testing.assert_array_equal(contains(surface, points, 0.05)[clear], signed[clear] < 0.05)


def test_rays_through_edges_and_corners_count_once() -> None:
    line = np.linspace(-0.75, 0.75, 7)
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    inside = (abs(points) < 0.5).all(1)
    clear = ~np.isclose(abs(points), 0.5).any(1)
    np.testing.assert_array_equal(contains(Mesh(*cube()), points, 0.0)[clear], inside[clear])


def test_particles_near_ready_made_ones() -> None:
    random = np.random.default_rng(1)
    points, queries = random.uniform(0, 1, (300, 3)), random.uniform(0, 1, (400, 3))
    expected = (np.linalg.norm(queries[:, None] - points, axis=2) <= 0.07).any(1)
    assert 0 < expected.sum() < 400
    np.testing.assert_array_equal(contains(Points(points), queries, 0.07), expected)
    assert contains(Points(points), points, 0.0).all()


@pytest.mark.parametrize(
    ("make", "attribute"),
    [
        (lambda: Box((1, -1)), "size"),
        (lambda: Box((1,)), "size"),
        (lambda: Sphere(0.0), "radius"),
        (lambda: Cylinder(1.0, inner_radius=1.0), "inner_radius"),
        (lambda: Cylinder(1.0, axis="w"), "axis"),
        (lambda: Mesh(np.zeros((3, 3)), [[0, 1, 3]]), "triangles"),
        (lambda: Points([[0.0, np.nan]]), "positions"),
        (lambda: Points(np.zeros((2, 2)), np.zeros((3, 2))), "velocities"),
        (lambda: Sphere(1.0, placement=np.zeros((4, 4))), "placement"),
    ],
)
def test_impossible_shapes_are_refused(make, attribute: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.attribute == attribute


@pytest.mark.parametrize("huge", [10**400, -(10**6000)], ids=["400", "6000"])
def test_whole_numbers_too_large_for_a_float_are_refused(huge: int) -> None:
    for make in (
        lambda: Box((huge, 1)),
        lambda: Sphere(huge),
        lambda: Cylinder(1.0, huge),
        lambda: Mesh([[huge, 0, 0]], [[0, 0, 0]]),
        lambda: Box((1, 1)).moved((huge, 0)),
        lambda: Box((1, 1)).turned(huge),
    ):
        with pytest.raises(InputError) as caught:
            make()
        assert len(str(caught.value)) < 1000

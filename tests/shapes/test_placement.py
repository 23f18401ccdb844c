"""Shapes moved and turned, and boxes between corners."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shapes.surfaces import cube
from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, contains, fill

SHAPES = [
    Box((0.4, 0.3, 0.2), (0.1, 0.0, 0.0)),
    Sphere(0.3, placement=np.diag((1.0, 2.0, 0.5, 1.0))),
    Cylinder(0.3, 0.5, "y", (0.0, 0.2, 0.0)),
    Mesh(*cube()),
    Box((0.4, 0.3, 0.2)) - Sphere(0.1),
]


def test_box_between_corners() -> None:
    box = Box.from_corners((1.0, -2.0), (1.5, 0.0))
    assert (box.size, box.center) == ((0.5, 2.0, np.inf), (1.25, -1.0, 0.0))
    box = Box.from_corners((0, 0, 0), (1, 2, 4))
    assert (box.size, box.center) == ((1.0, 2.0, 4.0), (0.5, 1.0, 2.0))


@pytest.mark.parametrize(
    ("low", "high", "match"),
    [
        ((0, 0), (1, 0), r"Box high: is \(1, 0\), must have as many numbers as low, \(0, 0\), and lie above it"),
        ((0, 0), (1, 1, 1), "must have as many numbers"),
        ((0, np.inf), (1, 1), r"Box low: must be 2 or 3 finite numbers"),
        ((0, 0), "ab", "Box high: must be 2 or 3 finite numbers, not 'ab'"),
    ],
)
def test_corners_that_are_none_are_refused(low: object, high: object, match: str) -> None:
    with pytest.raises(InputError, match=match):
        Box.from_corners(low, high)  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", SHAPES)
def test_moved_and_turned_membership_is_that_of_the_points_mapped_back(shape: Shape) -> None:
    """Quarter turn about x through a point, by hand: (x, y, z) goes to (x, -z, y) about it."""
    points = np.random.default_rng(2).uniform(-0.7, 0.7, (2000, 3))
    shift, pivot = np.array((0.2, -0.1, 0.3)), np.array((0.05, 0.1, -0.02))
    np.testing.assert_array_equal(contains(shape.moved(shift), points + shift, 0.0), contains(shape, points, 0.0))
    arms = points - pivot
    turned = pivot + np.column_stack((arms[:, 0], -arms[:, 2], arms[:, 1]))
    expected = contains(shape, points, 0.0)
    assert 0 < expected.sum() < len(points)
    for axis in ("x", (2.0, 0.0, 0.0)):
        moved = shape.turned(0.5 * np.pi, axis, about=pivot)
        np.testing.assert_array_equal(contains(moved, turned, 0.0), expected)


def test_a_turn_in_a_plane_is_counterclockwise_about_the_origin() -> None:
    positions = fill(Box((0.2, 0.1), (1.0, 0.0)).turned(0.5 * np.pi), 0.1, 2)
    np.testing.assert_allclose(positions, [(0.0, 0.95), (0.0, 1.05)], atol=1e-12)


def test_moves_and_turns_follow_each_other() -> None:
    """Turned about the origin and then moved is not moved and then turned."""
    box = Box((0.2, 0.1))
    one = fill(box.turned(0.5 * np.pi).moved((1.0, 0.0)), 0.1, 2)
    other = fill(box.moved((1.0, 0.0)).turned(0.5 * np.pi), 0.1, 2)
    np.testing.assert_allclose(one, [(1.0, -0.05), (1.0, 0.05)], atol=1e-12)
    np.testing.assert_allclose(other, [(0.0, 0.95), (0.0, 1.05)], atol=1e-12)


def test_a_box_that_is_only_moved_has_no_placement() -> None:
    box = Box((0.2, 0.1)).moved((1.0, 2.0))
    assert box.placement is None
    assert box.center == (1.0, 2.0, 0.0)


def test_particles_move_and_turn_and_keep_their_velocities() -> None:
    shape = Points([(1.0, 0.0)], [(3.0, 0.0)]).turned(0.5 * np.pi).moved((0.0, 1.0))
    np.testing.assert_allclose(fill(shape, 0.1, 2), [(0.0, 2.0)], atol=1e-12)
    assert shape.velocities is not None
    np.testing.assert_array_equal(shape.velocities, [(3.0, 0.0, 0.0)])


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: Box((1, 1)).moved((1, np.inf)), "Box displacement: must be 2 or 3 finite numbers"),
        (lambda: Mesh(*cube()).moved(3), "Mesh displacement: must be 2 or 3 finite numbers, not 3"),
        (lambda: Box((1, 1)).turned(np.nan), "Box angle: must be a finite number, not nan"),
        (lambda: Box((1, 1)).turned(1.0, "w"), "Box axis: must be x, y, z or 3 numbers that are not all 0, not 'w'"),
        (lambda: Box((1, 1)).turned(1.0, (0, 0, 0)), "Box axis: must be"),
        (lambda: Box((1, 1)).turned(1.0, about=(1,)), "Box about: must be 2 or 3 finite numbers"),
    ],
)
def test_displacements_and_axes_that_are_none_are_refused(call, match: str) -> None:
    with pytest.raises(InputError, match=match):
        call()

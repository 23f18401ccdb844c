"""Particles on a lattice: counts and positions by hand, volumes against the formulas."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from tests.shapes.surfaces import cube, icosphere, torus
from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, fill, particle_count


def turn(angle: float, *, axis: int = 2, scale: tuple[float, ...] = (1, 1, 1), shift: tuple[float, ...] = (0, 0, 0)):
    """A placement: scale, then a turn about an axis [rad], then a shift [m]."""
    c, s = np.cos(angle), np.sin(angle)
    placement = np.eye(4)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    placement[[a, a, b, b], [a, b, a, b]] = c, -s, s, c
    placement[:3, :3] = placement[:3, :3] * np.asarray(scale)
    placement[:3, 3] = shift
    return placement


def test_box_2d_by_hand() -> None:
    positions = fill(Box((0.3, 0.2), (1.0, 2.0)), 0.1, 2)
    expected = [(x, y) for x in (0.9, 1.0, 1.1) for y in (1.95, 2.05)]
    np.testing.assert_allclose(positions, expected, atol=1e-14)


def test_box_3d_by_hand() -> None:
    positions = fill(Box((0.2, 0.1, 0.1)), 0.1, 3)
    np.testing.assert_allclose(positions, [[-0.05, 0, 0], [0.05, 0, 0]], atol=1e-14)


def test_node_axes_put_particles_on_the_faces() -> None:
    positions = fill(Box((0.4, 0.2)), 0.1, 2, node_axes=(0,))
    assert len(positions) == 5 * 2
    assert positions[:, 0].min() == pytest.approx(-0.2)
    assert positions[:, 1].min() == pytest.approx(-0.05)


def test_spacing_is_exact_when_the_extent_is_no_multiple() -> None:
    positions = fill(Box((1.04, 0.96)), 0.1, 2)
    assert np.diff(np.unique(positions[:, 0].round(9))) == pytest.approx(0.1)
    np.testing.assert_allclose(positions.max(0), (0.45, 0.45))
    np.testing.assert_allclose(positions.mean(0), 0.0, atol=1e-14)


def test_lattice_turns_with_the_box() -> None:
    straight = fill(Box((0.3, 0.2)), 0.1, 2)
    placement = turn(0.3, shift=(1, 2, 0))
    turned = fill(Box((0.3, 0.2), placement=placement), 0.1, 2)
    np.testing.assert_allclose(turned, straight @ placement[:2, :2].T + (1, 2), atol=1e-14)


def test_scale_stretches_the_box_and_not_the_spacing() -> None:
    scaled = fill(Box((1, 1, 1), placement=turn(0.0, scale=(0.3, 0.2, 0.1))), 0.1, 3)
    np.testing.assert_allclose(scaled, fill(Box((0.3, 0.2, 0.1)), 0.1, 3), atol=1e-14)


def test_axes_that_trade_places_keep_the_lattice_along_them() -> None:
    # A stage drawn in its x-z plane: its z is the scene's y, its y points out of the scene's plane.
    placement = turn(-0.5 * np.pi, axis=0)
    positions = fill(Box((0.4, 9.0, 0.2), placement=placement), 0.1, 2, node_axes=(2,))
    assert len(positions) == 4 * 3
    assert np.ptp(positions[:, 1]) == pytest.approx(0.2)


def test_shear_falls_back_to_the_axes_of_the_scene() -> None:
    placement = np.eye(4)
    placement[0, 1] = 0.5
    positions = fill(Box((1.0, 1.0), placement=placement), 0.02, 2)
    assert len(positions) * 0.02**2 == pytest.approx(1.0, rel=0.02)
    assert len(np.unique(positions[:, 1].round(9))) == 50


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Sphere(0.5), np.pi / 6),
        (Sphere(0.5, placement=turn(0.4, axis=0, scale=(1, 1, 2))), np.pi / 3),
        (Cylinder(0.5, 1.0, "x"), np.pi / 4),
        (Cylinder(0.5, 1.0, "y", inner_radius=0.25), np.pi * 3 / 16),
        (Cylinder(0.5, 1.0, placement=turn(1.0, axis=1, scale=(2, 1, 1))), np.pi / 2),
        (Mesh(*cube()), 1.0),
        (Mesh(*cube(), placement=turn(0.5, scale=(1, 2, 0.5), shift=(3, 0, 0))), 1.0),
        (Mesh(*icosphere(4, 0.5)), np.pi / 6),
        (Mesh(*torus(0.5, 0.2)), 2 * np.pi**2 * 0.5 * 0.2**2),
    ],
)
def test_volume_in_3d(shape: Shape, volume: float) -> None:
    errors = [abs(len(fill(shape, h, 3)) * h**3 / volume - 1) for h in (0.1, 0.025)]
    assert errors[1] < 0.012
    assert errors[1] <= errors[0]


@pytest.mark.parametrize(
    ("shape", "area"),
    [
        (Cylinder(0.5), np.pi / 4),
        (Cylinder(0.5, inner_radius=0.3), np.pi * 0.16),
        (Sphere(0.5, (0, 0, 0.3)), np.pi * 0.16),
        (Mesh(*cube(), placement=turn(0.25 * np.pi, axis=0)), np.sqrt(2)),
        (Mesh(*icosphere(4, 0.5)), np.pi / 4),
        (Mesh(*torus(0.5, 0.2)), np.pi * (0.7**2 - 0.3**2)),
    ],
)
def test_area_of_the_section_in_2d(shape: Shape, area: float) -> None:
    assert len(fill(shape, 0.01, 2)) * 0.01**2 == pytest.approx(area, rel=0.01)


def test_ring_of_two_particles_thickness() -> None:
    ring = fill(Cylinder(0.05, inner_radius=0.05 - 2 * 0.0083), 0.0083, 2)
    assert len(ring) == 64
    np.testing.assert_allclose(np.sort(ring[:, 0]), np.sort(-ring[:, 0]), atol=1e-15)


@pytest.mark.parametrize("node_axes", [(), (0,), (0, 1)])
@pytest.mark.parametrize(("low", "high"), [(0.5, 0.8), (1.01, 2.2), (-3.3, -2.6)])
def test_a_mesh_in_single_precision_is_filled_like_the_box(low: float, high: float, node_axes: tuple[int, ...]) -> None:
    """Rounded coordinates must not gain a column, whose particles would lie on the faces, nor lose those that do."""
    points, triangles = cube()
    corners = np.array([(low, 0.1, -0.5), (high, 0.15, 0.5)])
    box = Box.from_corners(*corners.tolist())
    points = np.float32(corners[0] + (points + 0.5) * (corners[1] - corners[0]))
    mesh = Mesh(points, triangles)
    expected = fill(box, 0.01, 2, node_axes=node_axes)
    np.testing.assert_allclose(fill(mesh, 0.01, 2, node_axes=node_axes), expected, atol=1e-6)
    assert particle_count(mesh, 0.01, 2, node_axes) == len(expected)


def test_mesh_of_a_cube_is_filled_like_the_box() -> None:
    mesh, box = fill(Mesh(*cube()), 0.1, 3), fill(Box((1, 1, 1)), 0.1, 3)
    np.testing.assert_allclose(mesh, box, atol=1e-14)
    mesh, box = (fill(s, 0.1, 3, node_axes=(1,)) for s in (Mesh(*cube()), Box((1, 1, 1))))
    np.testing.assert_allclose(mesh, box, atol=1e-14)


def test_section_of_a_mesh_centres_the_lattice() -> None:
    # The section of this slanted prism lies far from the middle of its bounds.
    points, triangles = cube()
    points = points * (1, 1, 4) + (0, 0, 1.5)
    points[:, 0] += points[:, 2]
    positions = fill(Mesh(points, triangles), 0.1, 2)
    assert len(positions) == 100
    np.testing.assert_allclose(positions.mean(0), 0.0, atol=1e-12)


def test_particles_are_returned_as_they_are() -> None:
    given = np.array([[1.0, 2.0], [3.0, 4.5]])
    np.testing.assert_array_equal(fill(Points(given), 3.0, 2), given)
    np.testing.assert_array_equal(fill(Points(given), 3.0, 3), np.pad(given, ((0, 0), (0, 1))))


@pytest.mark.parametrize(
    ("shape", "dimension", "attribute", "reason"),
    [
        (Box((1, 0.04)), 2, "spacing", "0.04 m along y, thinner than one particle"),
        (Sphere(0.02), 3, "spacing", "thinner than one particle"),
        (Cylinder(1, inner_radius=0.9999), 2, "spacing", "leaves no particle"),
        (Sphere(0.5, (0, 0, 2)), 2, "shape", "no section at z = 0"),
        (Mesh(cube()[0] + (0, 0, 2), cube()[1]), 2, "shape", "no section at z = 0"),
        (Mesh(cube()[0], cube()[1][1:]), 3, "shape", "not closed"),
        (Box((1, 1)), 3, "shape", "unbounded"),
    ],
)
def test_refusals_say_why(shape: Shape, dimension: int, attribute: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason) as caught:
        fill(shape, 0.1, dimension, where="/Beam")
    assert (caught.value.where, caught.value.attribute) == ("/Beam", attribute)


def test_count_is_exact_for_a_box_and_an_upper_bound_otherwise() -> None:
    for shape in (Box((1.04, 0.5, 0.3)), Points(np.outer(np.arange(7), (0.1, 0.0, 0.0)))):
        assert particle_count(shape, 0.1, 3) == len(fill(shape, 0.1, 3))
    assert particle_count(Box((0.4, 0.2)), 0.1, 2, node_axes=(0, 1)) == 15
    assert len(fill(Sphere(0.5), 0.1, 3)) <= particle_count(Sphere(0.5), 0.1, 3) == 1000


def test_count_of_more_particles_than_memory_holds() -> None:
    assert particle_count(Box((1, 1, 1)), 1e-7, 3) == 10**21


def test_a_large_mesh_takes_seconds_of_processor_time() -> None:
    points, triangles = icosphere(5, 0.5)
    assert len(triangles) == 20480
    begin = process_time()
    assert len(fill(Mesh(points, triangles), 0.0172, 3)) > 1e5
    assert process_time() - begin < 10.0

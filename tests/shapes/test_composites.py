"""Union, difference and intersection of shapes: membership, lattices, and volumes against the formulas."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shapes.surfaces import cube, icosphere
from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere, contains, fill, particle_count

A, B, C = Box((0.6, 0.5, 0.4), (0.1, 0.0, 0.0)), Sphere(0.3), Mesh(*cube()).turned(0.3, "x").moved((0.6, 0.1, -0.1))
CLOUD = np.random.default_rng(3).uniform(-0.8, 0.8, (4000, 3))


def members(shape: Shape) -> np.ndarray:
    """Which points of a cloud lie in a shape."""
    return contains(shape, CLOUD, 0.0)


def test_membership_is_that_of_the_operands() -> None:
    a, b, c = members(A), members(B), members(C)
    np.testing.assert_array_equal(members(A | B), a | b)
    np.testing.assert_array_equal(members(A - B), a & ~b)
    np.testing.assert_array_equal(members(A & B), a & b)
    np.testing.assert_array_equal(members((A | C) - B), (a | c) & ~b)
    assert 0 < (a & b & c).sum() < (a | b | c).sum() < len(CLOUD)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (A - (B | C), (A - B) - C),
        (A - (B & C), (A - B) | (A - C)),
        (A & (B | C), (A & B) | (A & C)),
        (A - (A - B), A & B),
        (A | B, B | A),
    ],
)
def test_identities_of_sets(one: Shape, other: Shape) -> None:
    assert members(one).any()
    np.testing.assert_array_equal(members(one), members(other))


def test_the_cut_face_belongs_to_a_difference() -> None:
    """Points on the face of the subtracted shape, and half a tolerance and two tolerances inside it."""
    shape, tolerance = Box((2.0, 2.0)) - Box((1.0, 2.0), (-0.5, 0.0)), 1e-3
    points = np.array([(0.0, 0.3), (-0.5e-3, 0.3), (-2e-3, 0.3), (1.0, 0.3)])
    assert contains(shape, points, tolerance).tolist() == [True, True, False, True]


def test_a_negative_tolerance_leaves_out_what_is_just_below_the_surface_of_a_mesh() -> None:
    points = np.array([(0.499, 0.1, 0.1), (0.49, 0.1, 0.1), (0.501, 0.1, 0.1)])
    assert contains(Mesh(*cube()), points, 0.0).tolist() == [True, True, False]
    assert contains(Mesh(*cube()), points, -0.002).tolist() == [False, True, False]
    assert contains(Mesh(*cube()), points, 0.002).tolist() == [True, True, True]


def test_a_difference_keeps_the_lattice_of_its_first_operand() -> None:
    """A plate of 6 x 4 particles with a hole of 2 x 2 in its middle, off the lattice of the hole's own."""
    plate = Box((0.6, 0.4), (0.3, 0.2))
    whole = fill(plate, 0.1, 2)
    left = fill(plate - Sphere(0.1, (0.3, 0.2)), 0.1, 2)
    assert (len(whole), len(left)) == (24, 20)
    middle = np.all(np.abs(whole - (0.3, 0.2)) < 0.06, axis=1)
    np.testing.assert_array_equal(left, whole[~middle])  # the same bits
    assert particle_count(plate - Sphere(0.1, (0.3, 0.2)), 0.1, 2) == 24


def test_a_union_continues_the_lattice_of_its_first_operand() -> None:
    """A foot of 2 x 1 particles at the left end of a beam of 4 x 1, half a spacing deep into it."""
    shape = Box.from_corners((0, 0), (0.4, 0.1)) | Box.from_corners((0, -0.1), (0.2, 0.05))
    expected = [(0.05, -0.05), (0.05, 0.05), (0.15, -0.05), (0.15, 0.05), (0.25, 0.05), (0.35, 0.05)]
    np.testing.assert_allclose(fill(shape, 0.1, 2), expected, atol=1e-12)


def test_an_intersection_takes_only_the_lattice_that_it_reaches() -> None:
    shape = Box((10.0, 10.0)) & Box.from_corners((0, 0), (0.3, 0.2))
    np.testing.assert_allclose(
        fill(shape, 0.1, 2), [(x, y) for x in (0.05, 0.15, 0.25) for y in (0.05, 0.15)], atol=1e-12
    )
    assert particle_count(shape, 0.1, 2) == 6


def test_particles_on_the_faces_of_node_axes_stay() -> None:
    shape = Box((0.4, 0.2)) - Box((0.1, 0.1))
    positions = fill(shape, 0.1, 2, node_axes=(0,))
    assert len(positions) == 5 * 2
    assert np.abs(positions[:, 0]).max() == pytest.approx(0.2)


def test_the_lattice_turns_with_the_first_operand() -> None:
    shape = Box((0.4, 0.2)) - Sphere(0.08, (0.2, 0.1))
    np.testing.assert_allclose(
        fill(shape.turned(0.5), 0.1, 2), fill(shape, 0.1, 2) @ [[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]]
    )


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        # a ball with a bore along its axis: 4/3 pi (R^2 - r^2)^(3/2)
        (Sphere(0.5) - Cylinder(0.2, 2.0, "x"), 4 / 3 * np.pi * (0.25 - 0.04) ** 1.5),
        # two balls with centres d apart share pi (4 R + d)(2 R - d)^2 / 12
        (Sphere(0.5) & Sphere(0.5, (0.4, 0, 0)), np.pi * 2.4 * 0.6**2 / 12),
        (Sphere(0.5) | Sphere(0.5, (0.4, 0, 0)), 8 / 3 * np.pi * 0.125 - np.pi * 2.4 * 0.6**2 / 12),
        # two cylinders that cross at right angles share 16 R^3 / 3
        (Cylinder(0.4, 2.0, "x") & Cylinder(0.4, 2.0, "y"), 16 / 3 * 0.4**3),
        (Box((1.0, 1.0, 1.0)) - Mesh(*icosphere(4, 0.4)), 1 - 4 / 3 * np.pi * 0.4**3),
    ],
)
def test_volumes_converge_to_the_formulas(shape: Shape, volume: float) -> None:
    errors = [abs(len(fill(shape, h, 3)) * h**3 / volume - 1) for h in (0.1, 0.02)]
    assert errors[1] < 0.01
    assert errors[1] <= errors[0]


def test_a_mesh_without_a_section_adds_nothing_to_a_plane() -> None:
    high = Mesh(*cube()).moved((0.6, 0, 3.0))
    plate = Box((0.4, 0.2))
    np.testing.assert_array_equal(fill(plate | high, 0.1, 2), fill(plate, 0.1, 2))
    with pytest.raises(InputError, match="has no section at z = 0"):
        fill(plate & high, 0.1, 2)


@pytest.mark.parametrize(
    ("shape", "match"),
    [
        (Box((1.0, 1.0)) & Sphere(0.2, (3.0, 0.0)), "is empty, or thinner than one particle"),
        (Box((1.0, 1.0)) - Sphere(2.0), "leaves no particle"),
        (Box((1.0, 1.0)) - Mesh(np.eye(3), [(0, 1, 2)]), r"not closed.* belongs to 1, as one of 3 such edges"),
    ],
)
def test_what_has_no_particle_is_refused(shape: Shape, match: str) -> None:
    with pytest.raises(InputError, match=match):
        fill(shape, 0.1, 2)


def test_what_has_no_inside_is_no_operand() -> None:
    with pytest.raises(InputError, match="Difference second: is Points, must be a shape with an inside"):
        Box((1.0, 1.0)) - Points(np.zeros((1, 2)))
    with pytest.raises(TypeError):
        Box((1.0, 1.0)) - 3  # type: ignore[operator]

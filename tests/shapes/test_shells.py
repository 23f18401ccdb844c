"""Meshes of several shells: unions where they overlap, cavities where one is turned inward."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shapes.surfaces import cube, icosphere
from warp_mps.errors import InputError
from warp_mps.shapes import Box, Mesh, contains, fill

Surface = tuple[np.ndarray, np.ndarray]
MIRRORED = np.diag([-1.0, 1.0, 1.0, 1.0])


def part(shift: tuple[float, float, float] = (0, 0, 0), size: float = 1.0, *, inward: bool = False) -> Surface:
    """A cube of a size whose centre is shifted."""
    points, triangles = cube()
    return points * size + np.array(shift), triangles[:, ::-1] if inward else triangles


def mesh(*parts: Surface, placement: np.ndarray | None = None) -> Mesh:
    """One mesh of several surfaces."""
    firsts = np.cumsum([0, *(len(points) for points, _ in parts)])
    triangles = [numbers + first for (_, numbers), first in zip(parts, firsts[:-1], strict=True)]
    return Mesh(np.concatenate([points for points, _ in parts]), np.concatenate(triangles), placement=placement)


@pytest.mark.parametrize(
    ("shape", "count"),
    [
        # in cells of 0.1, of which a unit cube has 1000
        (mesh(part(), part((0.5, 0, 0))), 1500),
        (mesh(part(), part((0.5, 0.5, 0.5))), 2000 - 125),
        (mesh(part(), part(size=0.5)), 1000),
        (mesh(part(), part(size=0.4, inward=True)), 1000 - 64),
        (mesh(part(inward=True), part(size=0.4)), 1000 - 64),
        (mesh(part(), part(size=0.4, inward=True), placement=MIRRORED), 1000 - 64),
        (mesh(part(), part((2, 0, 0), inward=True)), 2000),
        (mesh(part(size=2), part(inward=True), part(size=0.4)), 8000 - 1000 + 64),
        (mesh(part(size=2), part(inward=True), part((0.5, 0, 0), inward=True)), 8000 - 1500),
        (mesh(part(), part((0.3, 0, 0), 0.4, inward=True)), 1000 - 64),
        (mesh(part(), part(size=0.4, inward=True), part((0.5, 0, 0))), 1500 - 4 * 4 * 2),
    ],
    ids=["overlap", "corner", "nested", "cavity", "all turned", "mirrored", "one turned", "island", "cavities",
         "touching", "cavity beside"],
)  # fmt: skip
def test_what_shells_enclose(shape: Mesh, count: int) -> None:
    assert len(fill(shape, 0.1, 3)) == count


def test_the_section_of_overlapping_shells(tmp_path: object) -> None:
    assert len(fill(mesh(part(), part((0.5, 0, 0))), 0.1, 2)) == 150


def test_triangles_that_are_turned_at_random_enclose_the_same() -> None:
    points, triangles = icosphere(2, 0.5)
    turned = np.random.default_rng(0).random(len(triangles)) < 0.5
    mixed = np.where(turned[:, None], triangles[:, ::-1], triangles)
    np.testing.assert_array_equal(fill(Mesh(points, mixed), 0.05, 3), fill(Mesh(points, triangles), 0.05, 3))


def test_a_shell_with_a_triangle_turned_wrongly_goes_as_most_of_its_triangles() -> None:
    """The first triangle of the inner cube, of 12, is turned."""
    points, triangles = part(size=0.4)
    triangles = np.concatenate([triangles[:1, ::-1], triangles[1:]])
    assert len(fill(mesh(part(), (points, triangles)), 0.1, 3)) == 1000
    assert len(fill(mesh(part(), (points, triangles[:, ::-1])), 0.1, 3)) == 1000 - 64


def test_the_faces_inside_an_overlap_are_no_surface() -> None:
    """Also not for a margin: what a union is cut by reaches across them."""
    both = mesh(part(), part((0.5, 0, 0)))
    points = np.array([[0.0, 0.01, 0.02], [0.5, 0.01, 0.02], [0.499, 0.01, 0.02], [0.999, 0, 0.01], [0.98, 0, 0.01]])
    assert contains(both, points, -0.01).tolist() == [True, True, True, False, True]
    assert len(fill(Box((4, 1, 1)) - both, 0.5, 3)) == 8 * 4 - 12


def test_shells_turned_opposite_ways_that_cross_are_refused() -> None:
    crossing = mesh(part(), part((0.5, 0.03, 0.01), 0.4, inward=True))
    with pytest.raises(InputError, match=r"has shells that cross and are turned opposite ways, one of them at \("):
        fill(crossing, 0.1, 3)
    with pytest.raises(InputError, match="cross"):
        contains(crossing, np.zeros((1, 3)), 0.0)


def test_a_shell_that_adds_nothing_is_known() -> None:
    assert len(mesh(part(), part(size=0.4, inward=True)).idle_shells) == 0
    idle = mesh(part(), part(size=0.4), placement=np.diag([2.0, 2.0, 2.0, 1.0])).idle_shells
    np.testing.assert_allclose(abs(idle), [[0.4, 0.4, 0.4]])


def test_a_solid_in_a_cavity_is_not_idle() -> None:
    """1000 cells of 0.1, without the cavity's 216, with the 8 of the solid in it; one inside that solid is idle."""
    nested = [part(), part(size=0.6, inward=True), part(size=0.2)]
    assert len(fill(mesh(*nested), 0.1, 3)) == 1000 - 216 + 8
    assert len(mesh(*nested).idle_shells) == 0
    np.testing.assert_allclose(abs(mesh(*nested, part(size=0.1)).idle_shells), [[0.05, 0.05, 0.05]])


def test_an_open_edge_is_told_where_it_lies_in_the_scene() -> None:
    points, triangles = cube()
    placement = np.eye(4)
    placement[:3, 3] = (10, 20, 30)
    holed = Mesh(points, triangles[1:], placement=placement)
    for use in (lambda: fill(holed, 0.1, 3), lambda: contains(holed, np.zeros((1, 3)), 0.0)):
        with pytest.raises(InputError, match=r"that from \(9.5, 19.5, 29.5\) to"):
            use()


def test_a_surface_with_one_side_is_refused() -> None:
    """The projective plane of six vertices."""
    ring = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    triangles = np.array([*ring, (1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)])
    with pytest.raises(InputError, match="has one side only"):
        fill(Mesh(np.random.default_rng(0).uniform(size=(6, 3)), triangles), 0.1, 3)

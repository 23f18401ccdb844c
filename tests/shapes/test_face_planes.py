"""Lattices of walls that are no boxes, broken at their plane faces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.particles.test_met_faces import L0, cells, rows, tank, wall
from tests.shapes.surfaces import cube
from warp_mps.scene import Scene, Wall
from warp_mps.shapes import Box, Cylinder, Mesh, Shape, fill
from warp_mps.shapes.face_planes import broken_line, face_planes


def channel(thickness: float, width: float, top: float) -> Mesh:
    """A tank as a mesh in single precision: a U along z, in spacings."""
    t, w = thickness, width
    outline = [(-t, -t), (w + t, -t), (w + t, top), (w, top), (w, 0), (0, 0), (0, top), (-t, top)]
    ring, n = L0 * np.array(outline), len(outline)
    points = np.concatenate([np.column_stack((ring, np.full(n, z))) for z in (-1.0, 1.0)])
    cap = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)]
    faces = [(a, c, b) for a, b, c in cap] + [(a + n, b + n, c + n) for a, b, c in cap]
    for i, j in ((i, (i + 1) % n) for i in range(n)):
        faces += [(i, j, j + n), (i, j + n, i + n)]
    return Mesh(np.float32(points), np.array(faces))


def as_one_wall(kind: str, thickness: float, width: float, depth: float) -> Scene:
    """The tank as one wall: a box less its inside, a union of boxes, or a mesh."""
    t, top = thickness, depth + 6.0
    outer, inner = cells([-t, -t], [width + t, top]), cells([0.0, 0.0], [width, top + 9.0])
    sides = cells([-t, 0.0], [0.0, top]) | cells([width, 0.0], [width + t, top])
    shapes: dict[str, Shape] = {
        "difference": outer - inner,
        "union": cells([-t, -t], [width + t, 0.0]) | sides,
        "mesh": channel(t, width, top),
    }
    return tank(t, width, depth, walls=(Wall(name="tank", shape=shapes[kind], spacing=L0),))


@pytest.mark.parametrize(("thickness", "width"), [(3.0, 20.0), (3.45, 20.0), (3.8, 20.56)])
@pytest.mark.parametrize("kind", ["difference", "union", "mesh"])
def test_a_tank_of_one_wall_is_filled_as_one_of_several(kind: str, thickness: float, width: float) -> None:
    one, several = as_one_wall(kind, thickness, width, 10.0), tank(thickness, width, 10.0)
    x, y = rows(one, "tank").T
    for depth in (-y[(x > 0.0) & (x < width)], -x[(x < 0.0) & (y > 0.0)], x[(x > width) & (y > 0.0)] - width):
        levels = np.unique(depth.round(3))
        np.testing.assert_allclose(levels, np.arange(len(levels)) + 0.5, atol=2e-3)
        assert len(levels) >= round(thickness)
    columns = np.unique(x[(y < 0.0) & (x > 0.0) & (x < width)].round(3))
    np.testing.assert_allclose(columns, np.unique(rows(one, "water")[:, 0].round(3)), atol=2e-3)
    # the corner has no gap
    corner = np.linalg.norm(np.column_stack((x, y)) - (-0.5, -0.5), axis=1)
    assert corner.min() < 2e-3
    np.testing.assert_array_equal(rows(one, "water"), rows(several, "water"))


def test_a_mesh_of_a_box_is_a_box() -> None:
    points, triangles = cube()
    box = cells([10.0, 0.0], [13.22, 3.22])
    mesh = Mesh(np.float32((points + 0.5) * (3.22 * L0, 3.22 * L0, 1.0) + (10.0 * L0, 0.0, -0.5)), triangles)
    found = {
        kind: rows(tank(3.0, 24.0, 10.0, Wall(name="box", shape=shape, spacing=L0)), "box")
        for kind, shape in (("box", box), ("mesh", mesh))
    }
    np.testing.assert_allclose(found["mesh"], found["box"], atol=1e-3)


def test_plane_faces_are_those_across_the_axis() -> None:
    x, y = np.eye(3)[:2]
    box = Box((0.4, 0.2, 0.3), (1.0, 2.0, 0.0))
    np.testing.assert_allclose(face_planes(box, x, 0.01), (0.8, 1.2))
    assert len(face_planes(box.turned(0.3), x, 0.01)) == 0
    np.testing.assert_allclose(face_planes(box.turned(0.5 * np.pi), y, 0.01), (0.8, 1.2))
    mesh = channel(3.45, 20.0, 16.0)
    np.testing.assert_allclose(face_planes(mesh, y, L0) / L0, (-3.45, 0.0, 16.0), atol=1e-3)
    assert len(face_planes(Cylinder(0.5), x, 0.01)) == 0


def test_whole_numbers_and_round_shapes_keep_their_lattice() -> None:
    x, free = np.eye(3)[0], (False, False)
    assert broken_line(cells([0.0, 0.0], [8.0, 1.0]) - cells([2.0, 0.0], [6.0, 1.0]), x, 0.0, 8 * L0, L0, free) is None
    assert broken_line(Cylinder(0.105), x, -0.105, 0.105, 0.01, free) is None
    ring: dict[str, Any] = {"shape": Cylinder(0.21, inner_radius=0.11), "spacing": L0}
    found = rows(tank(3.0, 20.0, 10.0, Wall(name="ring", **ring), wall("far", [30.0, 0.0], [33.0, 3.0])), "ring")
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(fill(ring["shape"], L0, 2) / L0, axis=0), atol=1e-9)


def test_a_round_end_is_filled_up_to_it() -> None:
    """A half disc of a radius of 10.3 spacings on a plane face: rows begin at the face and end inside the arc."""
    disc = Cylinder(10.3 * L0) & cells([-20.0, 0.0], [20.0, 20.0])
    line = broken_line(disc, np.eye(3)[1], 0.0, 10.3 * L0, L0, (True, False))
    assert line is not None
    np.testing.assert_allclose(line.coordinates() / L0, np.arange(11) + 0.5)

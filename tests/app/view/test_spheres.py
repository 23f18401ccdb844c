"""Spheres as pixels: coverage, occlusion, shading."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.app.view import spheres as splat
from warp_mps.app.view.spheres import NOTHING, Spheres, ambient_occlusion, nearest, shade


def spheres(*rows: tuple[float, float, float, float]) -> Spheres:
    """Spheres from column, row, depth and radius, in pixels."""
    values = np.array(rows, dtype=float)
    return Spheres(values[:, :2], values[:, 2], values[:, 3], values[:, 3])


def random_spheres(count: int, seed: int = 1) -> Spheres:
    rng = np.random.default_rng(seed)
    centres, depths, radii = (
        rng.uniform(-5.0, 65.0, (count, 2)),
        rng.uniform(1.0, 40.0, count),
        rng.uniform(1, 9, count),
    )
    return Spheres(centres, depths, radii, radii)


def one_by_one(some: Spheres, width: int, height: int) -> np.ndarray:
    """Depths by the book: every pixel asks every sphere."""
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    depths = np.full((height, width), np.inf)
    for centre, depth, radius in zip(some.centres, some.depths, some.radii, strict=True):
        square = 1.0 - ((columns - centre[0]) ** 2 + (rows - centre[1]) ** 2) / radius**2
        inside = square > 0.0
        depths[inside] = np.minimum(depths[inside], depth - radius * np.sqrt(square[inside]))
    return depths


@pytest.mark.parametrize("chunk", [splat.CHUNK, 500])
def test_every_pixel_shows_the_nearest_surface(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(splat, "CHUNK", chunk)
    some = random_spheres(200)
    surface = nearest(some, 60, 50)
    expected = one_by_one(some, 60, 50)
    assert np.array_equal(surface.covered, np.isfinite(expected))
    assert surface.depths[surface.covered] == pytest.approx(expected[surface.covered], rel=1e-5)
    rows, columns = np.nonzero(surface.covered)
    owners = surface.owners[rows, columns]
    apart = np.hypot(columns + 0.5 - some.centres[owners, 0], rows + 0.5 - some.centres[owners, 1])
    assert (apart < some.radii[owners]).all()


def test_the_order_of_the_spheres_does_not_matter() -> None:
    some = random_spheres(100)
    turned = Spheres(some.centres[::-1], some.depths[::-1], some.radii[::-1], some.bulges[::-1])
    first, second = nearest(some, 60, 60), nearest(turned, 60, 60)
    assert np.array_equal(first.depths, second.depths)
    assert np.array_equal(first.owners[first.covered], 99 - second.owners[second.covered])


def test_a_nearer_sphere_hides_a_farther_one() -> None:
    both = spheres((20.0, 20.0, 10.0, 8.0), (24.0, 20.0, 30.0, 8.0))
    surface = nearest(both, 44, 40)
    assert surface.owners[20, 23] == 0
    assert surface.owners[20, 30] == 1
    assert surface.owners[0, 0] == NOTHING
    swapped = spheres((20.0, 20.0, 30.0, 8.0), (24.0, 20.0, 10.0, 8.0))
    assert nearest(swapped, 44, 40).owners[20, 23] == 1


def test_spheres_that_touch_meet_where_their_surfaces_do() -> None:
    """Equally far away, each shows up to the middle between them."""
    surface = nearest(spheres((20.0, 20.0, 10.0, 8.0), (28.0, 20.0, 10.0, 8.0)), 48, 40)
    assert surface.owners[20, :24].max() == 0
    assert surface.owners[20, 24:].min() <= 1
    assert set(surface.owners[20, 24:36]) == {1}


def test_the_smallest_spheres_are_seen_and_those_outside_cost_nothing() -> None:
    surface = nearest(spheres((5.5, 5.5, 1.0, 1e-3), (500.0, 5.0, 1.0, 3.0), (-1e9, 5.0, 1.0, 3.0)), 10, 10)
    assert surface.covered.sum() == 1
    assert surface.owners[5, 5] == 0


def test_light_falls_from_the_upper_left() -> None:
    ball = spheres((20.0, 20.0, 5.0, 15.0))
    surface = nearest(ball, 40, 40)
    image = shade(ball, surface, np.array([[0.5, 0.5, 0.5]]))
    assert (image[~surface.covered] == 0.0).all()
    upper_left, lower_right = image[12, 13].mean(), image[28, 27].mean()
    assert upper_left > 1.3 * lower_right
    assert lower_right > 0.2


def test_what_lies_behind_its_neighbours_is_darker() -> None:
    depths = np.full((20, 20), 10.0, dtype=np.float32)
    depths[:, 10:] = 4.0
    depths[:5] = np.inf
    light = ambient_occlusion(depths, 2, 1.0)
    assert light[12, 9] < 0.9 < light[12, 4] == 1.0
    assert light[12, 12] == 1.0
    assert (light[:5] == 1.0).all()

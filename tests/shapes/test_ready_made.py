"""Ready-made particles: those that coincide, or whose spacing is not theirs, are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.scenes import RUBBER, scene_of
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.misfits import remarks_on_misfits
from warp_mps.scene import Body, Fluid, Scene, Wall
from warp_mps.shapes import Points, check_spacing, median_distance
from warp_mps.shapes.point_search import crowd, near_points, nearest_points
from warp_mps.usd.case.read import read_stage


def lattice(count: int, dimension: int, spacing: float) -> np.ndarray:
    """A cube of so many particles along each edge."""
    line = [np.arange(count)] * dimension
    return spacing * np.stack(np.meshgrid(*line, indexing="ij"), axis=-1).reshape(-1, dimension).astype(float)


@pytest.mark.parametrize(("spacing", "factor"), [(0.2, "0.02"), (0.04, "0.02"), (0.01, "more than 0.015")])
def test_a_spacing_that_is_not_theirs_is_refused(spacing: float, factor: str) -> None:
    """6^3 particles 0.02 m apart: their masses would be 1000, 8 and 1/8 times what they should be."""
    reason = f"is {spacing:g} m, but its particles lie {factor} m apart"
    with pytest.raises(InputError, match=f"body 'cloud' spacing: {reason}"):
        fill_scene(scene_of(body(lattice(6, 3, 0.02), spacing), dimension=3))


def body(positions: np.ndarray, spacing: float = 0.02) -> Body:
    """A body of ready-made particles."""
    return Body(name="cloud", shape=Points(positions), material=RUBBER, spacing=spacing)


@pytest.mark.parametrize("shift", [0.0, 1e-3])
@pytest.mark.parametrize("kind", ["body", "fluid", "wall"])
def test_two_points_at_one_place_are_named(kind: str, shift: float) -> None:
    points = lattice(4, 2, 0.02)
    points = np.vstack([points, points[5] + (shift, 0.0)])
    items: dict[str, Scene] = {
        "body": scene_of(body(points)),
        "fluid": Scene(fluids=(Fluid(name="cloud", shape=Points(points), spacing=0.02),), duration=0.1),
        "wall": scene_of(
            replace(body(lattice(3, 2, 0.02) - 1.0), name="other"),
            walls=(Wall(name="cloud", shape=Points(points), spacing=0.02),),
        ),
    }
    with pytest.raises(InputError, match=rf"{kind} 'cloud' positions: rows 5 and 16 coincide at \(0.02, 0.02\) m"):
        fill_scene(items[kind])


def test_a_stage_is_refused_as_it_is_read(tmp_path: Path) -> None:
    source = Usd.Stage.Open("stages/ring_collision_gray.usda")
    path = next(str(prim.GetPath()) for prim in source.Traverse() if prim.IsA(UsdGeom.Points))
    points = UsdGeom.Points(source.GetPrimAtPath(path)).GetPointsAttr()
    rows = list(points.Get())
    points.Set([*rows, rows[3]])
    source.Export(str(tmp_path / "twice.usda"))
    with pytest.raises(InputError, match=f"{path} points: rows 3 and {len(rows)} coincide"):
        read_stage(tmp_path / "twice.usda")
    points.Set(rows)
    source.GetPrimAtPath(path).GetAttribute("mps:spacing").Set(0.02)
    source.Export(str(tmp_path / "coarse.usda"))
    with pytest.raises(InputError, match=f"{path} mps:spacing: is 0.02 m, but its particles lie"):
        read_stage(tmp_path / "coarse.usda")


def test_packings_pass_and_loose_ones_are_remarked() -> None:
    rng = np.random.default_rng(2)
    shaken = lattice(12, 2, 0.02) + rng.uniform(-0.002, 0.002, (144, 2))
    hexagons = lattice(12, 2, 0.02) * (1.0, np.sqrt(0.75)) + np.outer(np.tile([0.0, 0.01], 72), (1.0, 0.0))
    for points, spacing in ((shaken, 0.02), (hexagons, 0.02 * 0.75**0.25)):
        check_spacing(Points(points), spacing, 2, "cloud")
        assert remarks_on_misfits(scene_of(body(points, spacing))) == []
    (line,) = remarks_on_misfits(scene_of(body(lattice(6, 2, 0.02), 0.026)))
    assert line.startswith("body 'cloud': its points lie 0.769 spacings apart")
    assert line.endswith("so that their masses are 1.69 times those of a lattice with a spacing of 0.02 m")


def test_a_single_particle_has_no_distance() -> None:
    check_spacing(Points(np.zeros((1, 2))), 0.1, 2, "one")
    assert median_distance(Points(np.zeros((1, 2))), 0.1, 2) == np.inf
    with pytest.raises(InputError, match=r"more than 0\.15 m apart"):
        check_spacing(Points(np.arange(2.0)[:, None] * (1.0, 0.0)), 0.1, 2, "two")


def test_the_search_is_that_of_all_pairs() -> None:
    """Also among points that are as far apart as numbers allow."""
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.uniform(0.0, 1.0, (150, 3)), [(1e9, 0.0, 0.0), (1e9, 0.05, 0.0)]])
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    queries = rng.uniform(-0.1, 1.1, (200, 3))
    expected = (np.linalg.norm(queries[:, None] - points[None], axis=2) <= 0.1).any(axis=1)
    np.testing.assert_array_equal(near_points(queries, points, 0.1), expected)
    np.fill_diagonal(apart, np.inf)
    some = np.arange(1, 152, 2)
    distances, nearest = nearest_points(points[some], points, 0.2, some)
    least = apart[some].min(axis=1)
    np.testing.assert_allclose(distances, np.where(least <= 0.2, least, np.inf))
    found = np.isfinite(distances)
    np.testing.assert_array_equal(nearest[found], apart[some].argmin(axis=1)[found])
    assert crowd(lattice(8, 3, 0.1) + 0.01, 0.2) == pytest.approx(8.0)


def test_a_dense_cluster_is_refused_at_once() -> None:
    cluster = np.random.default_rng(0).uniform(0.0, 1e-3, (20_000, 3))
    with pytest.raises(InputError, match="coincide"):
        check_spacing(Points(cluster), 0.1, 3, "cluster")

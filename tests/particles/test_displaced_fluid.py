"""Fluids drawn through bodies and walls: what gives way, what stays, and a hull that starts afloat."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, SOFT
from tests.fluid.scenes import L0, box, walls_about, water
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Fluid, Material, Scene, Wall
from warp_mps.shapes import Box, Mesh, Points, Shape, Sphere


def of(scene: Scene, name: str) -> np.ndarray:
    """Positions of the particles of a body, wall or fluid in spacings of the fluid, rounded and sorted."""
    particles = fill_scene(scene)
    first, last = particles.ranges[particles.names.index(name)]
    rows = (particles.positions[first:last] / L0).round(6) + 0.0
    return rows[np.lexsort(rows.T)]


def cells(low: list[float], high: list[float]) -> Box:
    """A box whose corners are in spacings of the fluid."""
    return box(L0 * np.array(low), L0 * np.array(high))


def scene_with(*bodies: Body, size: tuple[int, ...] = (10, 8), depth: int = 6, **fields: Any) -> Scene:
    """A tank of 10 x 8 particles, 6 deep in water that is drawn as one box."""
    dimension = len(size)
    top = [*size]
    top[1] = depth
    walls = walls_about(L0 * np.array(size, float), layers=4)
    fluid = water([0.0] * dimension, [L0 * n for n in top])
    given: dict[str, Any] = {"fluids": (fluid,), "walls": walls, "gravity": (0.0, -9.81, 0.0)[:dimension]}
    return Scene(bodies=bodies, dimension=dimension, duration=0.1, contact=ALONE, **{**given, **fields})


def body(shape: Shape, *, ratio: int = 1, **fields: Any) -> Body:
    """A soft body whose particles are so many to a spacing of the fluid."""
    return Body(**{"name": "baffle", "shape": shape, "material": SOFT, "spacing": L0 / ratio, **fields})


@pytest.mark.parametrize("ratio", [1, 2, 4])
def test_one_box_of_water_about_a_baffle_is_several_that_leave_it_out(ratio: int) -> None:
    """A baffle of 2 x 4 of the 10 x 6 particles: 52 are left, the rows beside it half a spacing off its faces."""
    baffle = body(cells([4, 0], [6, 4]), ratio=ratio)
    one = scene_with(baffle)
    parts = [("left", [0, 0], [4, 4]), ("right", [6, 0], [10, 4]), ("above", [0, 4], [10, 6])]
    several = replace(
        one,
        fluids=tuple(Fluid(name=name, shape=cells(low, high), spacing=L0) for name, low, high in parts),  # type: ignore[arg-type]
    )
    found, expected = of(one, "water"), np.concatenate([of(several, name) for name, *_ in parts])
    np.testing.assert_array_equal(found, expected[np.lexsort(expected.T)])
    assert len(found) == 60 - 8
    beside = found[found[:, 1] < 4.0]
    assert np.abs(beside[:, 0] - 5.0).min() == pytest.approx(1.5)
    particles = fill_scene(one)
    assert particles.displaced == (("water", "baffle", 8),)
    assert particles.remarks() == ["water: 8 particles give way to baffle, which it was drawn into"]
    assert fill_scene(several).displaced == ()


def test_three_dimensions() -> None:
    scene = scene_with(body(cells([2, 0, 2], [4, 3, 3]), ratio=2), size=(6, 6, 5), depth=4)
    assert len(of(scene, "water")) == 6 * 4 * 5 - 2 * 3 * 1


def test_water_that_only_touches_is_left_as_it_is_drawn() -> None:
    """10.6 spacings take 11 particles, the outermost 0.3 spacings off the walls and so 0.8 from their particles."""
    whole = water([0.0, 0.0], [10.6 * L0, 6 * L0])
    walls = walls_about(L0 * np.array([10.6, 8.0]), layers=4)
    scene = scene_with(fluids=(whole,), walls=walls)
    assert len(of(scene, "water")) == 11 * 6
    assert fill_scene(scene).displaced == ()


def test_water_gives_way_to_walls_it_is_drawn_into() -> None:
    """Two spacings too long on either side and three too deep."""
    wide = water([-2 * L0, -3 * L0], [12 * L0, 6 * L0])
    np.testing.assert_array_equal(of(scene_with(fluids=(wide,)), "water"), of(scene_with(), "water"))
    displaced = fill_scene(scene_with(fluids=(wide,))).displaced
    assert {name for _, name, _ in displaced} == {wall.name for wall in scene_with().walls}
    assert sum(count for *_, count in displaced) == 14 * 9 - 60


def test_a_plate_between_two_rows_takes_both() -> None:
    """A plate of one row, on the face between two rows of water: no particle of either lies in the other's shape."""
    scene = scene_with(body(cells([2, 2.5], [8, 3.5])))
    left = of(scene, "water")
    assert len(left) == 60 - 2 * 6
    assert not ((np.abs(left[:, 1] - 3.0) < 0.9) & (np.abs(left[:, 0] - 5.0) < 3.0)).any()


def test_ready_made_particles_and_their_velocities_give_way_as_well() -> None:
    x = L0 * (np.stack(np.meshgrid(np.arange(10.0), np.arange(6.0)), axis=-1).reshape(-1, 2) + 0.5)
    fluid = Fluid(name="water", shape=Points(x, 3.0 * x), spacing=L0)
    particles = fill_scene(scene_with(body(cells([4, 0], [6, 4])), fluids=(fluid,)))
    assert particles.liquid == 52
    np.testing.assert_allclose(particles.velocities[-52:], 3.0 * particles.positions[-52:])


def test_what_is_left_turns_about_its_own_centre_of_mass() -> None:
    scene = scene_with(body(cells([0, 0], [4, 4])))
    turning = replace(scene, fluids=(replace(scene.fluids[0], angular_velocity=5.0),))
    particles = fill_scene(turning)
    np.testing.assert_allclose(particles.velocities[-particles.liquid :].mean(axis=0), 0.0, atol=1e-14)


def test_water_of_which_nothing_is_left_is_refused() -> None:
    stone = Wall(name="stone", shape=cells([-20, -20], [20, 20]), spacing=L0, path="/World/stone")
    with pytest.raises(InputError, match="fluid 'water' shape: lies inside /World/stone: nothing of it is left"):
        fill_scene(scene_with(walls=(stone,)))


def hull(half_beam: float, keel: float, deck: float) -> Mesh:
    """A prism with the section of a V: from a keel up to a deck of a half beam, long along z [m]."""
    section = [(0.0, keel), (half_beam, deck), (-half_beam, deck)]
    points = np.array([(x, y, z) for z in (-1.0, 1.0) for x, y in section])
    triangles = [(0, 2, 1), (3, 4, 5)]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        triangles += [(a, b, b + 3), (a, b + 3, a + 3)]
    return Mesh(points, np.array(triangles))


def afloat(kind: str, ratio: int) -> tuple[Scene, float]:
    """A hull that floats in a tank of 30 x 20 particles, and the area of its section under water in particles."""
    if kind == "vee":  # 16 particles wide and 8 high, 6 of them under water
        shape, area, density = hull(8 * L0, 4.0 * L0, 12.0 * L0).moved((15 * L0, 0.0)), 36.0, 562.5
    else:  # a disc half under water, off the lattice of the water
        shape, area, density = Sphere(6.3 * L0, (15.3 * L0, 10.3 * L0)), 0.5 * np.pi * 6.3**2, 500.0
    boat = body(shape, name="hull", ratio=ratio, material=Material(density, 5e6, 0.3))
    return scene_with(boat, size=(30, 20), depth=10, frame_rate=1000.0), area


@pytest.mark.parametrize("ratio", [1, 2])
@pytest.mark.parametrize("kind", ["vee", "disc"])
def test_the_fluid_that_gives_way_to_a_hull_has_its_volume(kind: str, ratio: int) -> None:
    """Within half a spacing of it along its surface, which is 17 (V) and 20 (disc) spacings long under water."""
    scene, area = afloat(kind, ratio)
    particles = fill_scene(scene)
    ((fluid, solid, count),) = particles.displaced
    assert (fluid, solid) == ("water", "hull")
    assert abs(count - area) < 0.4 * (17 if kind == "vee" else 20)
    wet, dry = particles.positions[-particles.liquid :], particles.positions[: particles.elastic]
    mean_spacing = 0.5 * (1 + 1 / ratio) * L0
    assert np.linalg.norm(wet[:, None] - dry[None], axis=2).min() >= 0.7 * mean_spacing


@pytest.mark.parametrize("kind", ["vee", "disc"])
@pytest.mark.long
def test_a_hull_starts_afloat_without_a_jolt(kind: str) -> None:
    """Pressures of 20 steps stay within half of the hydrostatic one above it, and the hull within a fifth of free fall.

    A box that fits the lattice of the water starts with 43 % more than the hydrostatic pressure.
    """
    scene, _ = afloat(kind, 2)
    simulation = Simulation(scene, announce=None)
    elastic = simulation.particles.elastic
    highest = fastest = 0.0
    while simulation.steps_done < 20:
        simulation.advance(1)
        highest = max(highest, float(simulation.pressures.max()))
        fastest = max(fastest, float(np.abs(simulation.velocities[:elastic]).max()))
    assert highest < 1.5 * 1000.0 * 9.81 * 10 * L0
    assert fastest < 0.2 * 9.81 * simulation.time

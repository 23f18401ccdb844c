"""Probes in fluids: water at rest, surfaces that are known, walls that move, and places without fluid."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.observers.views import FakeView, view_of
from warp_mps.observers.sampling import Sampler, make_sampler
from warp_mps.scene import Flow, Fluid, HarmonicRotation, Liquid, Probe, Scene, Wall
from warp_mps.shapes import Box

SPACING, WIDTH, DEPTH, DENSITY, GRAVITY = 0.02, 0.4, 0.3, 900.0, 10.0


def pool(dimension: int = 2, **fields: Any) -> Scene:
    """Liquid of some depth on a floor whose top is at 0, from -WIDTH/2 to WIDTH/2."""
    beside = [0.0] * (dimension - 1)
    across = [WIDTH] * (dimension - 2)
    water = Fluid(
        name="water",
        shape=Box([WIDTH, DEPTH, *across], [0.0, DEPTH / 2, 0.0][:dimension]),
        liquid=Liquid(density=DENSITY),
        spacing=SPACING,
    )
    floor = Wall(name="floor", shape=Box([WIDTH, 0.08, *across], [0.0, -0.04, 0.0][:dimension]), spacing=SPACING)
    good = {"fluids": (water,), "walls": (floor,), "gravity": [0.0, -GRAVITY, *beside[1:]], "duration": 1.0}
    return Scene(**{**good, "dimension": dimension, **fields})


def at_rest(scene: Scene) -> FakeView:
    """A moment of the pool at rest, under its own weight."""
    view = view_of(scene)
    view.pressures = DENSITY * GRAVITY * (DEPTH - view.positions[:, 1])
    view.pressures[: -view.particles.liquid] = 1e9  # a wall's pressures are not the fluid's
    return view


def value(view: FakeView, **probe: Any) -> np.ndarray:
    return sampler(view, **probe).sample(view)


def sampler(view: FakeView, **probe: Any) -> Sampler:
    return make_sampler(Probe(name="p", **probe), view.scene, view.particles)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("place", [(0.0, 0.0), (-WIDTH / 2, 0.1), (0.013, 0.171), (WIDTH / 2, 0.0)])
def test_pressure_of_water_at_rest_is_exact(dimension: int, place: tuple[float, float]) -> None:
    """Also at the bottom, on a side and in a corner, where all particles lie to one side."""
    view = at_rest(pool(dimension))
    point = [*place, 0.05][:dimension]
    assert value(view, point=point, quantity="pressure") == pytest.approx([DENSITY * GRAVITY * (DEPTH - place[1])])


def test_pressure_where_there_is_no_water() -> None:
    view = at_rest(pool())
    assert value(view, point=(0.0, 1.0), quantity="pressure") == [0.0]
    assert value(view, region=Box((0.1, 0.1), (0.0, 1.0)), quantity="pressure") == [0.0]
    assert value(view, point=(0.0, 1.0), quantity="velocity") == pytest.approx([0.0, 0.0])
    # just above the surface it would be below that of the air
    assert value(view, point=(0.0, DEPTH + 0.01), quantity="pressure") == [0.0]
    pulling = at_rest(pool(flow=Flow(negative_pressure="allowed")))
    assert value(pulling, point=(0.0, DEPTH + 0.01), quantity="pressure") == pytest.approx([-0.01 * DENSITY * GRAVITY])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("pressures", ["clipped", "allowed"])
def test_drops_beside_a_dry_gauge_are_no_head_of_water(dimension: int, pressures: str) -> None:
    """A drop without pressure, above or below a gauge on a dry wall and within its effective radius."""
    view = at_rest(pool(dimension, flow=Flow(negative_pressure=pressures)))
    drop = len(view.positions) - 1
    for side in (1.9, -1.9):
        place = np.array([1.0, 0.5 + side * SPACING, 0.02][:dimension])
        view.displacements[drop] += place - view.positions[drop]
        view.pressures[drop] = 0.0
        assert value(view, point=[1.0, 0.5, 0.02][:dimension], quantity="pressure") == [0.0]


def test_a_region_has_the_mean_of_what_is_in_it_now() -> None:
    view = at_rest(pool())
    strip = {"region": Box((2 * SPACING, DEPTH), (0.1, DEPTH / 2))}
    assert value(view, quantity="pressure", **strip) == pytest.approx([0.5 * DENSITY * GRAVITY * DEPTH])
    view.velocities[:, 0] = view.positions[:, 0]
    assert value(view, quantity="velocity", **strip) == pytest.approx([0.1, 0.0])
    # the water that was there has moved on
    view.displacements[-view.particles.liquid :, 0] += 2 * SPACING
    assert value(view, quantity="velocity", **strip) == pytest.approx([0.1 - 2 * SPACING, 0.0])


@pytest.mark.parametrize("radius", [2.1, 3.1])
def test_velocity_at_a_point_is_a_mean_of_near_particles(radius: float) -> None:
    view = at_rest(pool(flow=Flow(effective_radius=radius)))
    view.velocities[:] = (3.0, -1.0)
    assert value(view, point=(0.013, 0.171), quantity="velocity") == pytest.approx([3.0, -1.0])
    view.velocities[:] = view.positions
    near = value(view, point=(0.013, 0.171), quantity="velocity")
    assert near == pytest.approx([0.013, 0.171], abs=0.1 * SPACING)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("x", [-0.19, -0.1, 0.003, 0.2])
def test_elevation_of_a_plane_surface(dimension: int, x: float) -> None:
    view = at_rest(pool(dimension))
    probe = {"point": [x, 0.0, 0.02][:dimension], "quantity": "elevation"}
    assert value(view, **probe) == pytest.approx([DEPTH], abs=0.02 * SPACING)
    # a drop above the water is not its surface
    drop = np.argmax(abs(view.positions[:, 0] - x) - view.positions[:, 1] + 9.0 * (view.positions[:, 1] > 0.0))
    view.displacements[drop, :2] = (x, 0.5) - view.positions[drop, :2]
    assert value(view, **probe) == pytest.approx([DEPTH], abs=0.25 * SPACING)


def test_elevation_of_a_wave_and_of_a_dry_bottom() -> None:
    view = at_rest(pool())
    x, y = view.positions.T
    view.displacements[:, 1] = 0.06 * np.sin(np.pi * x / WIDTH) * y / DEPTH
    for place in np.linspace(-0.15, 0.15, 13):
        level = DEPTH + 0.06 * np.sin(np.pi * place / WIDTH)
        assert value(view, point=(place, 0.0), quantity="elevation") == pytest.approx([level], abs=0.1 * SPACING)
    assert value(view, point=(1.0, -0.02), quantity="elevation") == pytest.approx([-0.02])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wet", [True, False])
def test_spray_is_no_surface(dimension: int, wet: bool) -> None:
    """A clump of 3 x 3 (x 3) particles, as dense as water, flies above the water or over a dry bottom."""
    view = at_rest(pool(dimension))
    place = np.array([0.003 if wet else 1.0, 0.9, 0.02][:dimension])
    clump = np.stack(np.meshgrid(*[SPACING * np.arange(-1, 2)] * dimension), axis=-1).reshape(-1, dimension)
    taken = np.flatnonzero(view.positions[:, 1] < 0.1)[-len(clump) :]
    view.displacements[taken] += place + clump - view.positions[taken]
    probe = {"point": [place[0], 0.0, 0.02][:dimension], "quantity": "elevation"}
    assert value(view, **probe) == pytest.approx([DEPTH if wet else 0.0], abs=0.05 * SPACING)


def test_water_that_is_thrown_up_is_its_surface() -> None:
    """A jet of a quarter of the water, above a gap; and a tongue that hangs over, held by the water behind it."""
    view = at_rest(pool())
    jet = view.positions[:, 1] > 0.75 * DEPTH
    view.displacements[jet, 1] += 0.2
    assert value(view, point=(0.0, 0.0), quantity="elevation") == pytest.approx([DEPTH + 0.2], abs=0.1 * SPACING)
    view = at_rest(pool())
    x, y = view.positions.T
    hollow = (x > 0.0) & (y > 0.1) & (y < 0.26)
    view.displacements[hollow, 0] -= WIDTH
    assert value(view, point=(0.1, 0.0), quantity="elevation") == pytest.approx([DEPTH], abs=0.25 * SPACING)


def test_elevation_is_along_gravity() -> None:
    """In a pool that lies on its side, the height counts against gravity from the origin."""
    scene = pool(gravity=(GRAVITY, 0.0))
    level = value(view_of(scene), point=(0.0, 0.1), quantity="elevation")
    assert level == pytest.approx([WIDTH / 2], abs=0.02 * SPACING)


def turned(view: FakeView, angle: float, pivot: np.ndarray) -> np.ndarray:
    """Turn all particles about a pivot; the rotation, shape [d, d]."""
    turn = np.eye(view.scene.dimension)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    reference = view.particles.positions
    view.displacements[:] = pivot + (reference - pivot) @ turn.T - reference
    return turn


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_point_moves_with_a_wall(dimension: int) -> None:
    view = at_rest(pool(dimension))
    pivot, point = np.array([0.1, -0.3, 0.2])[:dimension], np.array([0.15, 0.0, 0.1])[:dimension]
    turn = turned(view, 0.3, pivot)
    moved = pivot + turn @ (point - pivot)
    view.pressures = DENSITY * GRAVITY * (1.0 - view.positions[:, 1])
    expected = pytest.approx([DENSITY * GRAVITY * (1.0 - moved[1])])
    assert value(view, point=point, quantity="pressure", moves_with="floor") == expected
    assert value(view, point=point, quantity="pressure") != expected


def test_a_point_moves_with_a_wall_one_particle_thin() -> None:
    """Which way it is turned, and not reflected, is seen although its particles lie on a line."""
    floor = Wall(name="floor", shape=Box((WIDTH, SPACING), (0.0, -SPACING / 2)), spacing=SPACING)
    view = at_rest(pool(walls=(floor,)))
    pivot, point = np.array([0.1, -0.3]), np.array([0.15, 0.2])
    moved = pivot + turned(view, -0.4, pivot) @ (point - pivot)
    view.pressures = DENSITY * GRAVITY * (1.0 - view.positions[:, 1])
    found = value(view, point=point, quantity="pressure", moves_with="floor")
    assert found == pytest.approx([DENSITY * GRAVITY * (1.0 - moved[1])])


@pytest.mark.parametrize("dimension", [2, 3])
def test_force_and_moment_on_a_wall(dimension: int) -> None:
    """The weight of the liquid, and its moment about one end of the floor, which the floor carries along."""
    scene = pool(dimension, walls=(replace(pool(dimension).walls[0], rotation=_swing(dimension)),))
    view = at_rest(scene)
    top = np.isclose(view.positions[:, 1], -SPACING / 2)
    view.contact_forces[top, 1] = -DENSITY * GRAVITY * DEPTH * SPACING ** (dimension - 1)
    weight = DENSITY * GRAVITY * DEPTH * WIDTH ** (dimension - 1)
    assert value(view, body="floor", quantity="contact_force")[:2] == pytest.approx([0.0, -weight])
    end = [-WIDTH / 2, 0.0, 0.0][:dimension]
    moment = value(view, body="floor", quantity="contact_moment", about=end)
    assert moment[-1] == pytest.approx(-weight * WIDTH / 2)
    assert len(moment) == 2 * dimension - 3
    turn = turned(view, 0.5, np.array([3.0, 2.0, 1.0])[:dimension])
    view.contact_forces = view.contact_forces @ turn.T
    assert value(view, body="floor", quantity="contact_moment", about=end) == pytest.approx(moment)


def _swing(dimension: int) -> HarmonicRotation:
    axis = (0.0, 0.0, 1.0) if dimension == 3 else ()
    return HarmonicRotation(amplitude=0.5, frequency=1.0, pivot=[3.0, 2.0, 1.0][:dimension], axis=axis)


@pytest.mark.parametrize("dimension", [2, 3])
def test_quantities_of_a_fluid(dimension: int) -> None:
    view = at_rest(pool(dimension))
    view.displacements[-view.particles.liquid :, 0] = 0.1
    view.velocities[:, 1] = 2.0
    view.volumes[-view.particles.liquid :] = 1.1 * SPACING**dimension
    mass = DENSITY * DEPTH * WIDTH ** (dimension - 1)
    assert value(view, body="water", quantity="position")[:2] == pytest.approx([0.1, DEPTH / 2])
    assert value(view, body="water", quantity="lowest")[:2] == pytest.approx([0.1 - WIDTH / 2, 0.0], abs=1e-12)
    assert value(view, body="water", quantity="highest")[:2] == pytest.approx([0.1 + WIDTH / 2, DEPTH])
    assert value(view, body="water", quantity="extent")[:2] == pytest.approx([WIDTH, DEPTH])
    assert value(view, body="water", quantity="momentum")[1] == pytest.approx(2.0 * mass)
    assert value(view, body="water", quantity="kinetic_energy") == pytest.approx([2.0 * mass])
    assert value(view, body="water", quantity="volume") == pytest.approx([1.1 * mass / DENSITY])
    unit = "J/m" if dimension == 2 else "J"
    assert sampler(view, body="water", quantity="kinetic_energy").labels == (f"p [{unit}]",)

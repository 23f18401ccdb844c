"""Moving least squares between particles."""

from __future__ import annotations

import numpy as np
import pytest

from tests.observers.views import RUBBER, blocks
from warp_mps.errors import InputError
from warp_mps.observers.interpolation import interpolate
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Body, Scene
from warp_mps.shapes import Box


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("first", [0.0, 0.0371, 0.15, 0.199, 0.2])
def test_linear_fields_are_exact_up_to_the_surface(dimension: int, first: float) -> None:
    particles = fill_scene(blocks(dimension))
    point = np.array([first, *[0.2] * (dimension - 1)])
    indices, weights = interpolate(particles, point, "probe")
    slope = np.arange(1.0, dimension + 1)
    assert weights @ (2.0 + particles.positions[indices] @ slope) == pytest.approx(2.0 + point @ slope, rel=1e-12)


def test_only_the_nearest_body_takes_part() -> None:
    particles = fill_scene(blocks())
    indices, _ = interpolate(particles, np.array([0.24, 0.05]), "probe")
    assert set(particles.bodies[indices]) == {0}
    indices, _ = interpolate(particles, np.array([0.26, 0.05]), "probe")
    assert set(particles.bodies[indices]) == {1}


def test_weights_favour_the_particles_beside_the_point() -> None:
    particles = fill_scene(blocks())
    indices, weights = interpolate(particles, np.array([0.05, 0.05]), "probe")
    nearest = np.argmin(np.linalg.norm(particles.positions[indices] - [0.05, 0.05], axis=1))
    assert np.argmax(weights) == nearest
    assert len(indices) < 16


def test_a_row_of_particles_is_interpolated_along_the_row() -> None:
    row = Body(name="row", shape=Box(size=[1.0, 0.1]), material=RUBBER, spacing=0.1)
    particles = fill_scene(Scene(bodies=(row,), duration=1.0))
    indices, weights = interpolate(particles, np.array([0.13, 0.02]), "probe")
    assert weights.sum() == pytest.approx(1.0, rel=1e-12)
    assert weights @ particles.positions[indices, 0] == pytest.approx(0.13, rel=1e-12)


def test_a_point_outside_every_body_is_refused() -> None:
    with pytest.raises(InputError, match=r"^/Probe point: \(0, 0\.5\) m lies outside every body"):
        interpolate(fill_scene(blocks()), np.array([0.0, 0.5]), "/Probe")

"""The time step: the limit against the highest eigenfrequency, and runs on either side of it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.elastic.springs.linear import linear_system
from tests.scenes import random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene
from warp_mps.shapes import Box

SIZES = {2: ((24, 24), (24, 2), (24, 1), (2, 2)), 3: ((8, 8, 8), (8, 8, 1), (10, 1, 1), (2, 2, 2))}


def body_of(
    cells: tuple[int, ...], nu: float, plane: str, radius: float, normalization: str = "lattice", **scene: object
) -> Scene:
    """A free body of so many particles along each axis."""
    shape = Box([0.01 * number for number in cells])
    body = Body(name="body", shape=shape, material=Material(1000.0, 1e6, nu), spacing=0.01)
    elasticity = Elasticity(model="springs", effective_radius=radius, normalization=normalization)
    return scene_of(body, dimension=len(cells), plane=plane, elasticity=elasticity, **scene)


def stable_step(scene: Scene) -> float:
    """The largest stable step of velocity Verlet, 2 / omega of the fastest mode [s]."""
    return 2.0 / linear_system(scene, fill_scene(scene)).highest_frequency()


@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize("radius", [1.5, 2.1, pytest.param(3.1, marks=pytest.mark.long)])
@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.48])
@pytest.mark.parametrize(("dimension", "plane"), [(2, "stress"), (2, "strain"), (3, "strain")])
def test_the_limit_and_the_default_are_below_what_is_stable(
    dimension: int, plane: str, nu: float, radius: float, normalization: str
) -> None:
    for cells in SIZES[dimension]:
        scene = body_of(cells, nu, plane, radius, normalization)
        clock = Clock(scene)
        assert clock.dt_limit < stable_step(scene)
        assert clock.dt < clock.dt_limit


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_rotation_of_particles_sets_the_limit(dimension: int) -> None:
    """omega^2 = 24 mu / (rho l0^2): inside a body, a particle's springs hold its rotation by 4 mu V0."""
    scene = body_of((12,) * dimension, 0.0, "strain", 1.5)
    speed = np.sqrt(1e6 / (2 * 1000.0))
    assert stable_step(scene) == pytest.approx(2.0 / np.sqrt(24.0) * 0.01 / speed, rel=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
def test_runs_on_either_side_of_the_limit(dimension: int) -> None:
    """At the stability limit noise stays bounded; 2 % above it, it grows without bound."""
    cells, growth = (10, 6, 4)[:dimension], []
    linear = body_of(cells, 0.0, "strain", 1.5)
    for step in (Clock(linear).dt_limit, 0.98 * stable_step(linear), 1.02 * stable_step(linear)):
        simulation = Simulation(body_of(cells, 0.0, "strain", 1.5, time_step=step))
        simulation.solid.state.v.assign(1e-6 * random(simulation.particles.count, dimension))
        start = simulation.energy.total
        # few enough steps that what grows stays a finite number
        simulation.advance(300)
        growth.append(simulation.energy.total / start)
    assert growth[0] < 3.0
    assert growth[1] < 10.0
    assert growth[2] > 1e4

"""Evaluation of probes in fluids: particles come and go, so neighbours are found among the present positions.

With the weight w(r) = (1 - r/r_e)^2 of the effective radius r_e, at a point x that stays in space or moves with a wall:

- ``velocity``: sum_j w v_j / sum_j w, over the fluid particles within r_e, a Shepard mean.
- ``pressure``: sum_j w (p_j + rho g . (x - x_j)) / sum_j w, the mean of what each particle's pressure is at the point's
  height, so that it is exact in water at rest, also on a wall, to one side of which all particles lie; where pressures
  are clipped, at least 0. It is 0 where no particle is within `WET` spacings of the point: the height of drops beyond
  is no head of water.
- ``elevation``: the level of the free surface on the line through x along gravity, without detached spray, and that of
  x where the line is dry (`warp_mps.observers.surface_level`).

Over a region both are the plain mean over the fluid particles that lie in it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warp_mps.observers.base import View
from warp_mps.observers.rigid_point import rigid_point
from warp_mps.observers.surface_level import surface_level
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import REGION_TOLERANCE
from warp_mps.scene import Probe, Scene
from warp_mps.shapes import Shape, contains

Sample = Callable[[View], np.ndarray]
# how near a particle is to a gauge in water, in spacings: half a spacing on a wall at rest, and on the walls of a
# dam break at most 1.0
WET = 1.5


def sample_of_fluid(probe: Probe, scene: Scene, particles: Particles) -> Sample:
    """Prepare a probe at a point or a region of a scene of fluids."""
    fluid = slice(particles.count - particles.liquid, particles.count)
    if probe.region is not None:
        return _of_region(probe.quantity, probe.region, fluid, scene)
    locate = _locator(probe, particles)
    if probe.quantity == "elevation":
        return lambda view: _elevation(view.positions[fluid], locate(view), scene)
    reach = scene.flow.radius(scene.dimension) * scene.fluids[0].spacing
    return lambda view: _shepard(probe.quantity, view, fluid, locate(view), reach)


def _of_region(quantity: str, region: Shape, fluid: slice, scene: Scene) -> Sample:
    tolerance = REGION_TOLERANCE * scene.fluids[0].spacing
    width = scene.dimension if quantity == "velocity" else 1

    def sample(view: View) -> np.ndarray:
        inside = contains(region, view.positions[fluid], tolerance)
        if not inside.any():
            return np.zeros(width)
        values = view.velocities if quantity == "velocity" else view.pressures
        return np.atleast_1d(values[fluid][inside].mean(axis=0))

    return sample


def _locator(probe: Probe, particles: Particles) -> Callable[[View], np.ndarray]:
    """Where the point of a probe is: where it was, or where the wall that it moves with has taken it."""
    point = np.asarray(probe.point, float)
    if probe.moves_with is None:
        return lambda view: point
    return rigid_point(particles, probe.moves_with, point)


def _shepard(quantity: str, view: View, fluid: slice, point: np.ndarray, reach: float) -> np.ndarray:
    arms = point - view.positions[fluid]
    distances = np.linalg.norm(arms, axis=1)
    near = distances < reach
    weights = (1.0 - distances[near] / reach) ** 2
    scene = view.scene
    if not near.any():
        return np.zeros(scene.dimension if quantity == "velocity" else 1)
    if quantity == "pressure" and distances[near].min() > WET * scene.fluids[0].spacing:
        return np.zeros(1)
    weights /= weights.sum()
    if quantity == "velocity":
        return weights @ view.velocities[fluid][near]
    pressures = view.pressures[fluid][near]
    if len(scene.gravity):
        pressures = pressures + scene.fluids[0].liquid.density * (arms[near] @ np.asarray(scene.gravity, float))
    value = weights @ pressures
    return np.atleast_1d(max(value, 0.0) if scene.flow.negative_pressure == "clipped" else value)


def _elevation(positions: np.ndarray, point: np.ndarray, scene: Scene) -> np.ndarray:
    gravity = np.asarray(scene.gravity, float)
    up = -gravity / np.linalg.norm(gravity)
    return np.atleast_1d(surface_level(positions, point, up, scene.fluids[0].spacing))

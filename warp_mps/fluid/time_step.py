"""How long a time step of fluids may be, and whether viscosity must be implicit in it."""

from __future__ import annotations

import math

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# explicit viscosity is stable up to this many l0^2 / nu (0.25 in 2-D is the limit of central differences)
VISCOUS_STEP = 0.125
# the longest step of a fluid that nothing sets in motion [s]
LONGEST_STEP = 0.05


def step_limits(scene: Scene, particles: Particles) -> dict[str, float]:
    """Limits of the time step that a fluid may take from its start on [s], by what sets them.

    A particle must not cross more than `courant` of a spacing in a step, at the speed of a fall through the fluid's
    height or at its initial speed.
    """
    part = slice(particles.count - particles.liquid, None)
    x, u = particles.positions[part], particles.velocities[part]
    fluid, flow = scene.fluids[0], scene.flow
    limits = {f"the longest step of a fluid, {LONGEST_STEP:g} s": LONGEST_STEP}
    if len(scene.gravity) and np.any(scene.gravity):
        fall = np.ptp(x @ np.asarray(scene.gravity, float)) + fluid.spacing * float(np.linalg.norm(scene.gravity))
        speed = math.sqrt(2.0 * fall)
        cause = f"CFL number {flow.courant:g} at {speed:.3g} m/s, a fall through the height of the fluid"
        limits[cause] = flow.courant * fluid.spacing / speed
    speed = float(np.sqrt((u**2).sum(axis=1).max()))
    if speed > 0.0:
        cause = f"CFL number {flow.courant:g} at {speed:.3g} m/s, the initial speed of the fluid"
        limits[cause] = flow.courant * fluid.spacing / speed
    return limits


def step_limit(scene: Scene, particles: Particles) -> tuple[float, bool]:
    """Longest time step that a fluid may take from its start on [s], and whether viscosity must be implicit in it.

    Viscosity is explicit where that is stable in such a step.
    """
    fluid, limit = scene.fluids[0], min(step_limits(scene, particles).values())
    return limit, min(limit, scene.time_step or limit) * fluid.liquid.viscosity > VISCOUS_STEP * fluid.spacing**2


def longest_step(scene: Scene, particles: Particles) -> float:
    """Longest step that a fluid takes at its start: the scene's, where the limit is not shorter [s]."""
    limit, _ = step_limit(scene, particles)
    return min(limit, scene.time_step or limit)

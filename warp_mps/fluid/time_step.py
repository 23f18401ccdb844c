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


def step_limit(scene: Scene, particles: Particles) -> tuple[float, bool]:
    """Longest time step that a fluid may take from its start on [s], and whether viscosity must be implicit in it.

    A particle must not cross more than `courant` of a spacing in a step, at the speed of a fall through the fluid's
    height or at its initial speed. Viscosity is explicit where that is stable in such a step.
    """
    part = slice(particles.count - particles.liquid, None)
    x, u = particles.positions[part], particles.velocities[part]
    fluid, flow = scene.fluids[0], scene.flow
    limits = [LONGEST_STEP]
    if len(scene.gravity) and np.any(scene.gravity):
        fall = np.ptp(x @ np.asarray(scene.gravity, float)) + fluid.spacing * float(np.linalg.norm(scene.gravity))
        limits.append(flow.courant * fluid.spacing / math.sqrt(2.0 * fall))
    speed = float(np.sqrt((u**2).sum(axis=1).max()))
    if speed > 0.0:
        limits.append(flow.courant * fluid.spacing / speed)
    limit = min(limits)
    return limit, min(limit, scene.time_step or limit) * fluid.liquid.viscosity > VISCOUS_STEP * fluid.spacing**2


def longest_step(scene: Scene, particles: Particles) -> float:
    """Longest step that a fluid takes at its start: the scene's, where the limit is not shorter [s]."""
    limit, _ = step_limit(scene, particles)
    return min(limit, scene.time_step or limit)

"""How elastic bodies follow the water: implicitly with its step, or by explicit steps of their own within it.

The water holds on to the velocities at the end of its step. Of a mode of angular frequency omega that is faster than
it, omega dt > pi, these answer to a force over the step with sin(omega dt)/(omega dt), which may be negative: then
water that is heavy next to the body pumps energy into the mode. The theta rule damps such modes; explicit steps do as
it does, by a viscous stress of the retardation time (2 theta - 1) dt, with the same ratio (theta - 1/2) omega dt.
"""

from __future__ import annotations

import math
from dataclasses import replace

from warp_mps.elastic.material import stable_time_step
from warp_mps.fluid.limits import step_limit
from warp_mps.particles import Particles
from warp_mps.scene import Material, Scene

# of the largest stable step: what a step of the bodies has at most
SAFETY = 0.9
# sub-steps in the longest step of the water above which an implicit step is quicker
MOST_SUBSTEPS = 200
# the least number of sub-steps in the longest step, so that the water's can be shortened where it is fast
LEAST_SUBSTEPS = 4


def damped(scene: Scene, particles: Particles) -> Scene:
    """The scene with the least damping of its bodies that explicit steps within those of the water need."""
    least = (2.0 * scene.theta - 1.0) * _longest(scene, particles)

    def damp(material: Material) -> Material:
        return replace(material, retardation_time=max(material.retardation_time, least))

    bodies = tuple(
        replace(
            body,
            material=damp(body.material),
            parts=tuple(replace(part, material=damp(part.material)) for part in body.parts),
        )
        for body in scene.bodies
    )
    return replace(scene, bodies=bodies)


def stable_step(scene: Scene) -> float:
    """Largest explicit step of the bodies, contact included [s]."""
    slower = math.sqrt(max(1.0, scene.contact.stiffness))
    return SAFETY * min(stable_time_step(body, scene) for body in scene.bodies) / slower


def takes_implicit_steps(scene: Scene, particles: Particles) -> bool:
    """Whether the bodies follow the water implicitly.

    As the scene says; ``auto`` is implicit where explicit steps would be more than `MOST_SUBSTEPS` for one of the
    water, and where nothing speaks against it: contact, or viscosity of a material.
    """
    if scene.integrator != "auto":
        return scene.integrator == "implicit"
    viscous = any(material.retardation_time for material in scene.materials)
    if scene.contact.between != "none" or viscous:
        return False
    return _longest(scene, particles) > MOST_SUBSTEPS * stable_step(damped(scene, particles))


def substep(scene: Scene, particles: Particles, interval: float) -> float:
    """Length of the bodies' explicit steps, of which a whole number makes an interval between two samples [s]."""
    longest = min(stable_step(damped(scene, particles)), _longest(scene, particles) / LEAST_SUBSTEPS)
    return interval / math.ceil(interval / longest)


def _longest(scene: Scene, particles: Particles) -> float:
    limit, _ = step_limit(scene, particles)
    return min(limit, scene.time_step or limit)

"""How elastic bodies follow the water: implicitly with its step, or by explicit steps of their own within it.

The water holds on to the velocities at the end of its step. Of a mode of angular frequency omega that is faster than
it, omega dt > pi, these answer to a force over the step with sin(omega dt)/(omega dt), which may be negative: then
water that is heavy next to the body pumps energy into the mode. The theta rule damps such modes; explicit steps do as
it does, by a viscous stress of the retardation time (2 theta - 1) dt, with the same ratio (theta - 1/2) omega dt.
"""

from __future__ import annotations

import math

from warp_mps.elastic.explicit.time_step import SAFETY, stable_limit
from warp_mps.fluid.time_step import longest_step
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene
from warp_mps.scene.validation.implicit import touches

# the least number of sub-steps in the longest step, so that the water's can be shortened where it is fast
LEAST_SUBSTEPS = 4


def stable_step(scene: Scene) -> float:
    """Largest explicit step of the bodies, contact included [s]."""
    return SAFETY * stable_limit(scene)


def takes_implicit_steps(scene: Scene) -> bool:
    """Whether the bodies follow the water implicitly.

    As the scene says; ``auto`` is implicit where nothing speaks against it: another model than ``hamiltonian``, a
    contact, or a viscosity of the material. Explicit steps see the water's force constant over its whole step. That is
    right for soft bodies, whose oscillations out of the water are slow against that step, and not for stiff ones.
    """
    if scene.integrator != "auto":
        return scene.integrator == "implicit"
    viscous = any(material.retardation_time for material in scene.materials)
    return scene.elasticity.model == "hamiltonian" and not touches(scene) and not viscous


def substep(scene: Scene, particles: Particles, interval: float) -> tuple[float, float]:
    """Length of the bodies' explicit steps, and the retardation time that damps what the water cannot follow [s].

    A whole number of steps makes an interval between two samples. The viscous force is that of the step before, and
    2/omega_max shrinks to (sqrt(1 + s^2) - s) 2/omega_max, s = tau omega_max/2 (Belytschko, Liu and Moran, chapter 6).
    """
    longest, stable = longest_step(scene, particles), stable_step(scene)
    tau = (2.0 * scene.theta - 1.0) * longest
    ratio = tau * SAFETY / stable
    stable *= math.sqrt(1.0 + ratio**2) - ratio
    return interval / math.ceil(interval / min(stable, longest / LEAST_SUBSTEPS)), tau

"""The time integration of elastic bodies in fluids: implicit steps with those of the fluid, or explicit sub-steps.

The fluid is coupled to the velocities at the end of its step dt. The response of a mode of angular frequency omega to
a constant force over the step is proportional to sin(omega dt)/(omega dt), which may be negative where omega dt > pi:
then a fluid that is heavy next to the body pumps energy into the mode. The theta rule damps such modes. Explicit
sub-steps damp them as much, by a viscous stress of the retardation time (2 theta - 1) dt, with the same damping ratio
(theta - 1/2) omega dt.
"""

from __future__ import annotations

import math

from warp_mps.elastic.explicit.time_step import SAFETY, stable_limit
from warp_mps.fluid.time_step import longest_step
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene
from warp_mps.scene.validation.implicit import touches

# least number of sub-steps in the longest step, so that a step can be shortened where the fluid is fast
LEAST_SUBSTEPS = 4


def stable_step(scene: Scene) -> float:
    """Largest stable explicit step of the bodies, contact included [s]."""
    return SAFETY * stable_limit(scene)


def takes_implicit_steps(scene: Scene) -> bool:
    """Whether the bodies take implicit steps.

    As the scene says; ``auto`` is implicit unless the scene has another model than ``hamiltonian``, a contact, or a
    viscosity of the material. To explicit sub-steps the force of the fluid is constant over the whole step. That is
    accurate for soft bodies, whose dry oscillations are slow against the step, and inaccurate for stiff ones.
    """
    if scene.integrator != "auto":
        return scene.integrator == "implicit"
    viscous = any(material.retardation_time for material in scene.materials)
    return scene.elasticity.model == "hamiltonian" and not touches(scene) and not viscous


def substep(scene: Scene, particles: Particles, interval: float) -> tuple[float, float]:
    """Length of the bodies' explicit sub-steps, and the retardation time that damps modes too fast for the fluid [s].

    A whole number of sub-steps makes an interval between two samples. The viscous force is that of the sub-step before:
    the stable step 2/omega_max shrinks to (sqrt(1 + s^2) - s) 2/omega_max, s = tau omega_max/2 (Belytschko, Liu and
    Moran, chapter 6).
    """
    longest, stable = longest_step(scene, particles), stable_step(scene)
    tau = (2.0 * scene.theta - 1.0) * longest
    ratio = tau * SAFETY / stable
    stable *= math.sqrt(1.0 + ratio**2) - ratio
    return interval / math.ceil(interval / min(stable, longest / LEAST_SUBSTEPS)), tau

"""Where fluids are computed: the box that particles may not leave."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


def domain(scene: Scene, particles: Particles) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of the domain [m]; by default the particles' box, and its size about it.

    Against gravity it is twice the size, for water that is thrown up comes back.

    Raises:
        InputError: The domain of the scene does not hold its fluids.
    """
    if scene.flow.domain is not None:
        low, high = (np.asarray(corner, float) for corner in scene.flow.domain)
        _check_domain(scene, particles.positions[particles.count - particles.liquid :], low, high)
        return low, high
    low, high = particles.positions.min(axis=0), particles.positions.max(axis=0)
    margin = max(float((high - low).max()), 10.0 * scene.fluids[0].spacing)
    gravity = scene.gravity_vector
    up = -gravity / (float(np.linalg.norm(gravity)) or 1.0)
    return low - margin * (1.0 + np.maximum(-up, 0.0)), high + margin * (1.0 + np.maximum(up, 0.0))


def _check_domain(scene: Scene, x: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    """Check that a domain holds particles, except along its periodic axes, along which they are wrapped into it."""
    wraps = np.isin(np.arange(len(low)), scene.flow.periodic)
    for name, outside in (("low", x < low), ("high", x > high)):
        strays = np.flatnonzero((outside & ~wraps).any(axis=1))
        if len(strays):
            at = ", ".join(f"{c:.4g}" for c in x[strays[0]])
            raise InputError(scene.path, f"flow.domain.{name}", f"leaves out fluid at ({at}) m")

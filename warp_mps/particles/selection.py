"""Particles that lie in a region, or that a support or a load acts on."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.scene import Load, Support
from warp_mps.scene.validation.rules import place
from warp_mps.shapes import Shape, contains

# in particle spacings: particles on a face of a region belong to it, in spite of rounding
REGION_TOLERANCE = 1e-6


def select(particles: Particles, region: Shape, bodies: tuple[str, ...] = ()) -> np.ndarray:
    """Indices of the elastic particles whose reference position lies in a region.

    Args:
        particles: The particles.
        region: The region; its faces belong to it.
        bodies: Names of the bodies to look at, all when empty.
    """
    part = slice(particles.elastic)
    inside = contains(region, particles.positions[part], REGION_TOLERANCE * float(particles.spacings[part].min()))
    if bodies:
        inside &= np.isin(particles.bodies[part], [particles.names.index(name) for name in bodies])
    return np.flatnonzero(inside)


def select_held(particles: Particles, item: Support | Load) -> np.ndarray:
    """Indices of the particles that a support holds or a load acts on.

    Raises:
        InputError: The region holds no particle.
    """
    found = select(particles, item.region, item.bodies)
    if len(found) == 0:
        kind = "support" if isinstance(item, Support) else "load"
        raise InputError(
            place(item, kind), "region", f"the {kind} holds no particle: its region must reach into a body"
        )
    return found

"""Particles that lie in a region, or that a support or a load acts on."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.scene import Load, Scene, Support
from warp_mps.scene.bonds import bonded_bodies
from warp_mps.scene.validation.rules import place
from warp_mps.shapes import Shape, contains

# in particle spacings: particles on a face of a region belong to it, in spite of rounding
REGION_TOLERANCE = 1e-6
# in particle spacings: a clamp holds the particles in front of its face that are closer to it than this
CLAMP_REACH = 0.38


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


def is_clamp(support: Support, dimension: int) -> bool:
    """Whether a support holds its particles wholly: along every axis, and their rotation."""
    every_axis = not support.axes or len(set(support.axes)) == dimension
    return every_axis and support.hold_rotation is not False


def free_bodies(scene: Scene, particles: Particles) -> dict[str, list[int]]:
    """Bodies that no support holds, neither themselves nor what they are bonded to: by name, the numbers of these."""
    held = {int(number) for item in scene.supports for number in particles.bodies[select_held(particles, item)]}
    groups = {}
    for body in scene.bodies:
        group = [scene.bodies.index(other) for other in bonded_bodies(body, scene.bodies)]
        if held.isdisjoint(group):
            groups[body.name] = group
    return groups


def select_held(particles: Particles, item: Support | Load) -> np.ndarray:
    """Indices of the particles that a support holds or a load acts on.

    Those of a region; a clamp also holds the particles of its bodies that nearly touch its face, whose bonds across it
    would be too short and stiff.

    Raises:
        InputError: The region holds no particle.
    """
    found = select(particles, item.region, item.bodies)
    if len(found) == 0:
        kind = "support" if isinstance(item, Support) else "load"
        raise InputError(
            place(item, kind), "region", f"the {kind} holds no particle: its region must reach into a body"
        )
    if isinstance(item, Support) and is_clamp(item, particles.dimension):
        return _with_touching(particles, item, found)
    return found


def _with_touching(particles: Particles, clamp: Support, found: np.ndarray) -> np.ndarray:
    """Particles in the region of a clamp, and those of the same bodies in front of its face that nearly touch it."""
    part = slice(particles.elastic)
    near = np.isin(particles.bodies[part], particles.bodies[found])
    for spacing in np.unique(particles.spacings[found]):
        same = np.flatnonzero(near & (particles.spacings[part] == spacing))
        near[same] = contains(clamp.region, particles.positions[same], CLAMP_REACH * float(spacing))
    near[found] = True
    return np.flatnonzero(near)

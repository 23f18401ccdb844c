"""Bodies that have gone into walls or each other by the end of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.run.inventory.surfaces import nearest_offsets
from warp_mps.scene import Scene
from warp_mps.scene.validation.rules import place

# in mean spacings: particles of two solids whose faces meet are 1 apart, and nearer than this within each other
NEAREST = 0.7


def remarks_on_penetrations(scene: Scene, particles: Particles, positions: np.ndarray) -> list[str]:
    """A line for each body and each wall or other body that it has gone into, where it was clear of it at the start.

    Args:
        scene: The case.
        particles: Its particles.
        positions: Their positions [m], shape [n, d].
    """
    if not particles.elastic or not np.isfinite(positions).all():
        return []
    return [
        line
        for index in range(particles.elastic_bodies)
        for other in range(index + 1, int(particles.bodies[: particles.count - particles.liquid].max()) + 1)
        if particles.groups[particles.ranges[index, 0]] != particles.groups[particles.ranges[other, 0]]
        for line in _penetration(scene, particles, positions, index, other)
    ]


def _penetration(scene: Scene, particles: Particles, positions: np.ndarray, index: int, other: int) -> Iterator[str]:
    own, others = slice(*particles.ranges[index]), slice(*particles.ranges[other])
    mean = 0.5 * float(particles.spacings[own.start] + particles.spacings[others.start])
    gaps = _distances(positions[own], positions[others], NEAREST * mean)
    before = _distances(particles.positions[own], particles.positions[others], NEAREST * mean)
    gone = np.flatnonzero(np.isfinite(gaps) & np.isnan(before))
    if not len(gone):
        return
    deepest = gone[np.argmin(gaps[gone])]
    at = ", ".join(f"{c:.4g}" for c in positions[own][deepest])
    where, name = place(scene.bodies[index], "body"), particles.names[other]
    count = f"{len(gone)} particles" if len(gone) > 1 else "1 particle"
    if scene.contact.between == "none":
        remedy = "contact is 'none' (mps:contact): use 'bodies'"
    else:
        remedy = "raise contact.stiffness (mps:contactStiffness), or take a smaller spacing"
    yield f"{where}: {count} went into '{name}', by {1.0 - gaps[deepest] / mean:.2f} spacings at ({at}) m: {remedy}"


def _distances(x: np.ndarray, points: np.ndarray, distance: float) -> np.ndarray:
    """Distance from each position to the nearest of the points, NaN where none is nearer than a distance [m]."""
    return np.linalg.norm(nearest_offsets(x, points, distance), axis=1)

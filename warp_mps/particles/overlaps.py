"""Checks between bodies, walls and fluids once they are filled: overlaps, and bonds out of reach."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.scene import Fluid, Scene, Wall
from warp_mps.scene.validation.rules import kind_of, place
from warp_mps.shapes import Points, contains

# in mean particle spacings: particles of touching bodies lie no deeper than this below each other's surface, and no
# closer to another's particle than half a spacing
SURFACE = 1e-3
OVERLAP = 0.499


def refuse_loose_bonds(scene: Scene, particles: Particles) -> None:
    """Refuse a bond between bodies that have no two particles within the effective radius of each other."""
    for i, body in enumerate(scene.bodies):
        for name in body.bonded_to:
            j = particles.names.index(name)
            here, there = (particles.positions[slice(*particles.ranges[k])] for k in (i, j))
            reach = scene.elasticity.effective_radius * body.spacing
            if i == j or not contains(Points(there), here, reach).any():
                reason = f"names {name!r}, which it does not touch: no two particles are within {reach:.3g} m"
                raise InputError(place(body, "body"), "bonded_to", reason)


def refuse_overlap(scene: Scene, particles: Particles) -> None:
    """Refuse a particle inside another body, or on top of another body's particle.

    Walls may share space, and fluids have given way to bodies and walls (`warp_mps.particles.displaced_fluid`).
    """
    for a, b in _near(scene, particles):
        one, other = scene.filled[a], scene.filled[b]
        fluids = isinstance(one, Fluid) + isinstance(other, Fluid)
        if fluids == 1 or (isinstance(one, Wall) and isinstance(other, Wall)):
            continue
        positions = particles.positions[slice(*particles.ranges[a])]
        others = particles.positions[slice(*particles.ranges[b])]
        mean_spacing = 0.5 * (one.spacing + other.spacing)
        near = np.all((positions > others.min(0) - mean_spacing) & (positions < others.max(0) + mean_spacing), axis=1)
        positions = positions[near]
        bad = contains(other.shape, positions, -SURFACE * mean_spacing)
        bad |= contains(Points(others), positions, OVERLAP * mean_spacing)
        if bad.any():
            at = ", ".join(f"{c:.6g}" for c in positions[np.argmax(bad)])
            kinds = "fluids" if fluids else "bodies"
            reason = f"overlaps {place(other, kind_of(other))} at ({at}) m; {kinds} may touch but not share space"
            raise InputError(place(one, kind_of(one)), "shape", reason)


def bounds_meet(positions: np.ndarray, others: np.ndarray, margin: float) -> bool:
    """Whether the bounding boxes of two sets of positions [m], shapes [n, d] and [m, d], are nearer than a margin."""
    apart = (positions.min(0) >= others.max(0) + margin) | (positions.max(0) <= others.min(0) - margin)
    return not apart.any()


def _near(scene: Scene, particles: Particles) -> Iterator[tuple[int, int]]:
    """Pairs of different bodies whose bounding boxes are nearer than a particle is wide."""
    parts = [particles.positions[slice(*bounds)] for bounds in particles.ranges]
    low, high = np.array([part.min(axis=0) for part in parts]), np.array([part.max(axis=0) for part in parts])
    spacings = np.array([item.spacing for item in scene.filled])
    for a, spacing in enumerate(spacings):
        margin = 0.5 * (spacing + spacings)[:, None]
        for b in np.flatnonzero(np.all((high[a] > low - margin) & (low[a] < high + margin), axis=1)):
            if a != b:
                yield a, int(b)

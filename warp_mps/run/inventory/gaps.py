"""Gaps between a body, a wall or a fluid and what lies beside it, and which of its faces are wet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.run.inventory.surfaces import nearest_offsets, surface_particles

# in spacings: gaps that are told, and gaps up to which a face is wet; how far to the side of a particle the nearest one
# of a neighbour may lie that it faces
REACH, WET, ASIDE = 2.0, 1.0, 0.51


@dataclass(frozen=True, kw_only=True)
class Gap:
    """The gap between the particles of an item and those of a neighbour on one side of it.

    Attributes:
        neighbour: Name of the neighbour.
        side: Where it lies: ``-x``, ``+x``, ``-y``, ...
        gap: Least distance between the faces of the particles, in spacings of the coarser; negative where they
            overlap [-].
        particles: Number of particles of the item with the neighbour on this side of them.
        area: Area that they make up, (number) l0^(d-1) [m^2], in 2-D length [m].
        wet: Whether the neighbour is a fluid that the item is in touch with.
    """

    neighbour: str
    side: str
    gap: float
    particles: int
    area: float
    wet: bool


def gaps(particles: Particles) -> list[tuple[Gap, ...]]:
    """Gaps of each body, wall and fluid to its neighbours within two spacings, in the order of the particles."""
    first_wall, first_fluid = particles.elastic_bodies, int(np.sum(particles.ranges[:, 1] <= _dry(particles)))
    surfaces = []
    for low, high in particles.ranges:
        spacing = float(particles.spacings[low])
        surfaces.append(
            (particles.positions[low:high][surface_particles(particles.positions[low:high], spacing)], spacing)
        )
    beside = _boxes_near(surfaces)
    found: list[tuple[Gap, ...]] = []
    for own, others in enumerate(beside):
        mine: list[Gap] = []
        for other in np.flatnonzero(others).tolist():
            # the joints of walls are no gaps of a tank, which its fluid shows
            both_walls = first_wall <= own < first_fluid and first_wall <= other < first_fluid
            if other != own and not both_walls:
                mine += _between(surfaces[own], surfaces[other], particles.names[other], other >= first_fluid > own)
        found.append(tuple(mine))
    return found


def _boxes_near(surfaces: list[tuple[np.ndarray, float]]) -> np.ndarray:
    """Whether the boxes about two items lie so near to each other that a gap may be told, shape [items, items]."""
    low, high = (np.array([extreme(x, axis=0) for x, _ in surfaces]) for extreme in (np.min, np.max))
    spacings = np.array([spacing for _, spacing in surfaces])
    reach = (1.0 + REACH) * np.maximum(spacings[:, None], spacings[None, :])
    return np.all(low[None, :] - high[:, None] <= reach[..., None], axis=2) & np.all(
        low[:, None] - high[None, :] <= reach[..., None], axis=2
    )


def _dry(particles: Particles) -> int:
    return particles.count - particles.liquid


def _between(own: tuple[np.ndarray, float], other: tuple[np.ndarray, float], name: str, is_wet: bool) -> list[Gap]:
    """Gaps of an item to a neighbour, one for each side of it that the neighbour lies on."""
    (x, spacing), (y, other_spacing) = own, other
    touch, coarser = 0.5 * (spacing + other_spacing), max(spacing, other_spacing)
    offsets = nearest_offsets(x, y, touch + REACH * coarser)
    # what lies across a corner is not faced; NaN compares as false
    offsets = offsets[np.sort(np.abs(offsets), axis=1)[:, -2] <= ASIDE * coarser]
    if not len(offsets):
        return []
    axes = np.argmax(np.abs(offsets), axis=1)
    along = offsets[np.arange(len(offsets)), axes]
    result = []
    for axis in range(offsets.shape[1]):
        for sign, mark in ((-1.0, "-"), (1.0, "+")):
            here = along[(axes == axis) & (sign * along > 0.0)]
            if not len(here):
                continue
            gap = (float(np.abs(here).min()) - touch) / coarser
            near = int(np.sum(np.abs(here) <= touch + (max(gap, 0.0) + 0.5) * coarser))
            area = near * spacing ** (offsets.shape[1] - 1)
            wet = is_wet and gap < WET
            result.append(
                Gap(neighbour=name, side=f"{mark}{'xyz'[axis]}", gap=round(gap, 6), particles=near, area=area, wet=wet)
            )
    return result

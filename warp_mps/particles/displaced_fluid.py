"""Fluid that bodies and walls displace: the particles of a fluid that give way to solids at the start.

A fluid may be drawn through solids, as one box about a hull or across a tank with a baffle. It then gives way to each
solid that it overlaps: particles inside the solid's shape are left out, and so are those that crowd one of its
particles, nearer than `NEAR` of the mean of the two spacings.

Rows of fluid and solid that meet across a common face are a mean spacing apart. Where the lattices do not fit, a fluid
particle in the middle of a cell of the solid's lattice is sqrt(1/2) of a spacing (2-D) or sqrt(3/4) (3-D) away from its
corners, and must stay: without it the fluid loses up to a third more than the volume of the hull, and the hull falls
into the gap and slams. Balls and V-shaped hulls afloat start within 1.5 of the hydrostatic pressure with 0.7, and
with up to 2.4 of it with 1.

A fluid that merely touches a solid is left as it is drawn, even where its lattice does not fit and its outermost row
lies nearer than that: leaving a whole row out would lose more of its volume than the fit does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.overlaps import OVERLAP, SURFACE, bounds_meet
from warp_mps.scene import Body, Fluid, Wall
from warp_mps.scene.validation.rules import kind_of, place
from warp_mps.shapes import Points, contains

# in mean particle spacings: fluid particles nearer to a solid's particle give way
NEAR = 0.7

Solid = tuple[Body | Wall, np.ndarray]


def kept_of_fluid(
    fluid: Fluid, positions: np.ndarray, solids: Sequence[Solid]
) -> tuple[np.ndarray, list[tuple[str, str, int]]]:
    """Tell which particles of a fluid remain beside the solids that it overlaps.

    Args:
        fluid: The fluid.
        positions: Positions of its lattice [m], shape [n, dimension].
        solids: Bodies and walls, each with the positions of its particles [m], shape [m, dimension].

    Returns:
        Flags of those that remain, shape [n]; and the name of the fluid, that of a solid, and the number of particles
        that give way to it, for each solid to which some do.

    Raises:
        InputError: Nothing of the fluid is left.
    """
    kept = np.ones(len(positions), bool)
    displaced = []
    for solid, others in solids:
        gone = kept & _displaced(fluid, positions, solid, others)
        if gone.any():
            kept &= ~gone
            displaced.append((fluid.name, solid.name, int(gone.sum())))
        if not kept.any():
            reason = f"lies inside {place(solid, kind_of(solid))}: nothing of it is left beside bodies and walls"
            raise InputError(place(fluid, "fluid"), "shape", reason)
    return kept, displaced


def _displaced(fluid: Fluid, positions: np.ndarray, solid: Body | Wall, others: np.ndarray) -> np.ndarray:
    """Which particles of a fluid give way to a solid, shape [n]."""
    mean_spacing = 0.5 * (fluid.spacing + solid.spacing)
    result = np.zeros(len(positions), bool)
    if not bounds_meet(positions, others, mean_spacing):
        return result
    near = np.flatnonzero(
        np.all((positions > others.min(0) - mean_spacing) & (positions < others.max(0) + mean_spacing), axis=1)
    )
    inside = contains(solid.shape, positions[near], -SURFACE * mean_spacing)
    overlap = inside.any() or contains(fluid.shape, others, -SURFACE * mean_spacing).any()
    if overlap or contains(Points(others), positions[near], OVERLAP * mean_spacing).any():
        result[near] = inside | contains(Points(others), positions[near], NEAR * mean_spacing)
    return result

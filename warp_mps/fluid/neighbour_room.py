"""Room for the neighbours of fluid particles, and how many particles it can be given to.

The rows of the pressure matrix lie in one array, k-th row from k * room on, and places in it are counted in 32 bits.
"""

from __future__ import annotations

import math

from warp_mps.core.weights import lattice_neighbours
from warp_mps.scene.numerics import SKIN

# room for neighbours, in units of those in even water
ROOM = 1.75
# the room that they may have, in units of that at first
MOST_ROOM = 8
# entries of an array that can be counted
MOST_ENTRIES = 2**31 - 1


def expected_neighbours(dimension: int, effective_radius: float) -> int:
    """Neighbours in a list of even water, the margin included: of a full lattice, or of disorder, which has no shells.

    Args:
        dimension: 2 or 3.
        effective_radius: In spacings [-].
    """
    reach = effective_radius + SKIN
    ball = math.pi * reach**2 if dimension == 2 else 4.0 / 3.0 * math.pi * reach**3
    return max(lattice_neighbours(dimension, reach), round(ball) - 1)


def room_for(neighbours: int) -> int:
    """Room of a list at first, where even water has so many neighbours."""
    return int(ROOM * neighbours)


def most_particles(dimension: int, effective_radius: float) -> int:
    """Number of fluid particles up to which the entries of the pressure matrix can be counted."""
    return MOST_ENTRIES // room_for(expected_neighbours(dimension, effective_radius))

"""The contact law of two lattices: the contact density of a particle in another body, and the energy of its excess.

The contact density q_iB of a particle i of spacing l_i in the particles j of another body B, of spacing l_B, is

    q_iB = w_iB sum_j W(|x_ij| / s_iB),   W(s) = (1 - s)^4 (1 + 4 s) for s < 1, else 0,   s_iB = 2 max(l_i, l_B)

with w_iB such that q_iB = 1, in the mean over all lateral positions, where i touches a flat lattice: its centre is half
of both spacings before the nearest layer. The excess stores the energy

    V_iB = 1/2 c_iB min(E_i, E_B) (q_iB - 1)^2,   c_iB = stiffness l_i^(d-1) l / (2 S_iB^2),   l = (l_i + l_B)/2

where S_iB = -l dq_iB/dz at touch. Two flat faces, each with the potentials of its particles, then resist a small
penetration z with the pressure stiffness E z / l. W is Wendland's C2 kernel: it has two continuous derivatives, and is
wide enough that a lattice acts as a plane. Equal lattices resist sliding by 0.6 % of the pressure at touch and by 1 %
at a quarter of a spacing deep in 2-D, by 1.1 % and 0.2 % in 3-D.

References:
    Wendland, H., Advances in Computational Mathematics 4 (1995) 389.
"""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np

from warp_mps.core.weights import wendland_c2, wendland_c2_slope

# support of W, in units of the larger spacing of a pair
SUPPORT = 2.0
# particles of one body that were closer than this are held apart by its elasticity: in units of the spacing, with room
# for a lattice to be compressed by 20 % before such pairs have to be looked at
APART = 2.5
# lateral positions along each axis of the face, over which the means are taken
LATERAL = 8
# candidates of a particle: a part of the lattice that its reach holds, and some more
FILLED, SPARE = 0.6, 8


@functools.cache
def law_constants(dimension: int, own: float, other: float) -> tuple[float, float]:
    """Weight w and energy c / stiffness of a particle in contact with the lattice of another body.

    Args:
        dimension: 2 or 3.
        own: Spacing of the particle [m].
        other: Spacing of the lattice [m].

    Returns:
        w [-], and c / stiffness [m^dimension].
    """
    support, mean = SUPPORT * max(own, other), 0.5 * (own + other)
    x = _half_space(dimension, other, support) + mean * np.eye(dimension)[-1]
    # a lattice that is fine beside the support looks the same at every lateral position
    count = 1 if other < 0.1 * support else LATERAL
    offsets = other * (np.arange(count) + 0.5) / count
    sums = np.zeros(2)
    for offset in itertools.product(offsets, repeat=dimension - 1):
        shifted = x + np.array([*offset, 0.0])
        r = np.linalg.norm(shifted, axis=1)
        gradient = np.sum(wendland_c2_slope(r / support) / support * shifted[:, -1] / r)
        sums += np.sum(wendland_c2(r / support)), -mean * gradient
    density, slope = sums / count ** (dimension - 1)
    return 1.0 / density, own ** (dimension - 1) * mean / (2.0 * (slope / density) ** 2)


def _half_space(dimension: int, spacing: float, support: float) -> np.ndarray:
    """Lattice points of a half-space up to the surface z = 0 that could lie within the support, shape [n, d]."""
    reach = math.ceil(support / spacing) + 1
    lateral = spacing * np.arange(-reach, reach + 1)
    axes = [lateral] * (dimension - 1) + [spacing * np.arange(reach + 1)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dimension)


def capacity(dimension: int, reach: float, spacing: float, filling: float = 0.0) -> int:
    """Length of a candidate list, sufficient unless bodies are crushed into each other.

    Args:
        dimension: 2 or 3.
        reach: Distance within which they are listed [m].
        spacing: Spacing of the finest other body [m].
        filling: Share of the surroundings that they fill, if large, in units of a full lattice [-].
    """
    ball = {2: math.pi, 3: 4.0 * math.pi / 3.0}[dimension] * (reach / spacing) ** dimension
    return math.ceil(max(FILLED, filling) * ball) + SPARE

"""Faces of clamps: the operators of a body end at the drawn face of a support that holds it wholly.

A clamp holds the material behind its face, and the face lies anywhere between two layers of particles. The bond from a
free particle i to a held one j meets it at X_i + t_ij X_ij, and there the displacement is that of the clamp. Taken as
linear along the bond, the difference of displacements over the whole bond is u_ij / t_ij, so that the pair acts as one
of the vector t_ij X_ij and the weight omega_ij / t_ij^2: first moments keep their shape tensor, and all forces stay the
gradient of one energy.

The particles next to the face share its cells with the clamp: a held one a depth s behind the face still has the share
max(0, 1/2 - s/l0) of its volume in front of it. Its neighbourhood is one-sided: it is taken as mirrored at the face,
which doubles the sums over free particles while the share halves the result. A uniform strain up to the face then gives
no force on any free particle, whatever the face's place (with r_e = 1.5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import REGION_TOLERANCE, is_clamp, select_held
from warp_mps.scene import Scene
from warp_mps.shapes import Shape, contains

# a held particle may stand in front of the face: bonds to it are searched for the face up to this multiple
_FARTHEST = (1.0, 1.25, 1.5, 2.0)
# least share of a bond in front of the face: a shorter one would be too stiff
_LEAST = 0.2
# least share of a volume: the kernels take ratios to it
_LEAST_VOLUME = 1e-9
# halvings of a bond in the search for the face: 1e-6 of the bond
_HALVINGS = 20
# resultant of the bonds to free particles over the sum of their lengths: below, a held particle has free ones all round
_ONE_SIDED = 0.3


@dataclass(frozen=True, kw_only=True)
class ClampFaces:
    """Where the bonds of a body meet the faces of clamps.

    Attributes:
        pairs: Pairs of a free and a held particle, and pairs of held ones whose weight changes, shape [k].
        fraction: Share t_ij of the bond from the free particle to the face, of pairs of held ones 1, shape [k].
        weight: Factor of the weight of a pair, but for its fraction, shape [k].
        next_to: Held particles next to free ones, shape [m].
        one_sided: Whether all these free ones are on one side, shape [m].
        share: Share of their volume in front of the face, or of the faces on either side [-], shape [m].
    """

    pairs: np.ndarray
    fraction: np.ndarray
    weight: np.ndarray
    next_to: np.ndarray
    one_sided: np.ndarray
    share: np.ndarray

    @property
    def doubling(self) -> np.ndarray:
        """Weight of sums over free particles whose mirror images are left out, over that of all [-], shape [m]."""
        return np.where(self.one_sided, 2.0, 1.0)


def clamp_faces(scene: Scene, particles: Particles, start: np.ndarray, index: np.ndarray) -> ClampFaces | None:
    """Faces of the clamps of a scene; None if no clamp holds a part of a body.

    Args:
        scene: The case.
        particles: Its elastic particles.
        start: First pair of each particle, shape [n + 1].
        index: Neighbour j of each pair.
    """
    clamps = [support for support in scene.supports if is_clamp(support, particles.dimension)]
    held = np.zeros((len(clamps), particles.count), bool)
    for row, support in zip(held, clamps, strict=True):
        row[select_held(particles, support)] = True
    any_held: np.ndarray = np.logical_or.reduce(held, axis=0)
    i = np.repeat(np.arange(particles.count), np.diff(start))
    crossing = np.flatnonzero(any_held[i] != any_held[index])
    if not len(crossing):
        return None
    ends = np.column_stack((i[crossing], index[crossing]))
    free, fixed = np.where(any_held[ends[:, :1]], ends[:, ::-1], ends).T
    fraction = np.full(len(crossing), np.inf)
    for row, support in zip(held, clamps, strict=True):
        here = np.flatnonzero(row[fixed])
        fraction[here] = np.minimum(fraction[here], _fractions(support.region, particles, free[here], fixed[here]))
    next_to, one_sided, share = _shares(particles, free, fixed, fraction)
    # 0 for free particles, 1 for held ones, 2 for those next to free ones, 3 if these are all on one side
    kind = any_held.astype(int)
    kind[next_to] = 2 + one_sided
    between = np.flatnonzero(any_held[i] & any_held[index] & (np.maximum(kind[i], kind[index]) == 3))
    weight = np.where(np.minimum(kind[i[between]], kind[index[between]]) > 1, 0.5, 0.0)
    return ClampFaces(
        pairs=np.concatenate((crossing, between)),
        fraction=np.concatenate((fraction, np.ones(len(between)))),
        weight=np.concatenate((np.ones(len(crossing)), weight)),
        next_to=next_to,
        one_sided=one_sided,
        share=np.where(one_sided, share, 2.0 * share),
    )


def _fractions(region: Shape, particles: Particles, free: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Multiple of the bonds from free to held particles at which they enter a region; 1 where no face is found."""
    tail, head = particles.positions[free], particles.positions[fixed]
    tolerance = REGION_TOLERANCE * float(particles.spacings.min())

    def inside(multiple: np.ndarray | float) -> np.ndarray:
        return contains(region, tail + np.reshape(multiple, (-1, 1)) * (head - tail), tolerance)

    high = np.zeros(len(free))
    for multiple in _FARTHEST:
        high[(high == 0.0) & inside(multiple)] = multiple
    # a particle of a body that the support does not hold may lie in its region
    lost = (high == 0.0) | inside(0.0)
    low = np.zeros(len(free))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        within = inside(middle)
        low, high = np.where(within, low, middle), np.where(within, middle, high)
    return np.where(lost, 1.0, np.maximum(high, _LEAST))


def _shares(
    particles: Particles, free: np.ndarray, fixed: np.ndarray, fraction: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Held particles next to free ones, whether these are all on one side, and 1/2 less the depth in spacings."""
    bonds = particles.positions[free] - particles.positions[fixed]
    lengths = np.linalg.norm(bonds, axis=1)
    next_to, number = np.unique(fixed, return_inverse=True)
    resultant = np.zeros((len(next_to), particles.dimension))
    np.add.at(resultant, number, bonds)
    one_sided = np.linalg.norm(resultant, axis=1) > _ONE_SIDED * np.bincount(number, lengths)
    depth = (1.0 - fraction) * lengths
    nearest = np.lexsort((np.abs(depth), number))
    first = nearest[np.searchsorted(number[nearest], np.arange(len(next_to)))]
    share = np.clip(0.5 - depth[first] / particles.spacings[next_to], _LEAST_VOLUME, 1.0)
    return next_to, one_sided, share

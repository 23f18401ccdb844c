"""Mass, centre of gravity and inertia of particles, each a square or a cube of its spacing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class MassProperties:
    """Mass properties of a set of particles; in 2-D per metre of depth.

    Attributes:
        volume: Volume [m^3], in 2-D area [m^2].
        mass: Mass [kg], in 2-D [kg/m]; None for walls, whose mass has no effect.
        centre: Centre of gravity [m], shape [dimension]; of walls the centre of their volume.
        inertia: Moments of inertia about axes through the centre of gravity along those of the scene [kg m^2], shape
            [3, 3]; in 2-D about the normal [kg m], shape [1, 1]; None for walls.
    """

    volume: float
    mass: float | None
    centre: tuple[float, ...]
    inertia: tuple[tuple[float, ...], ...] | None


def mass_properties(positions: np.ndarray, masses: np.ndarray | None, spacings: np.ndarray) -> MassProperties:
    """Mass properties of particles.

    A particle is a square or a cube of edge l0 with the moment of inertia m l0^2/6 of its own, so that a box of a whole
    number of spacings has the moments m (a^2 + b^2)/12 of a solid one.

    Args:
        positions: Positions [m], shape [n, dimension].
        masses: Masses [kg], in 2-D [kg/m], shape [n]; None for walls.
        spacings: Particle spacings [m], shape [n].
    """
    volumes = spacings ** positions.shape[1]
    weights = volumes if masses is None else masses
    centre = weights @ positions / weights.sum()
    result = MassProperties(volume=float(volumes.sum()), mass=None, centre=tuple(centre.tolist()), inertia=None)
    if masses is None:
        return result
    arms = positions - centre
    own = float(masses @ spacings**2) / 6.0
    moments = np.einsum("n,ni,nj->ij", masses, arms, arms)
    if positions.shape[1] == 2:
        inertia = np.array([[np.trace(moments) + own]])
    else:
        inertia = (np.trace(moments) + own) * np.eye(3) - moments
    rows = tuple(tuple(row) for row in inertia.tolist())
    return MassProperties(volume=result.volume, mass=float(masses.sum()), centre=result.centre, inertia=rows)

"""The state of the particles in every elastic model; a model may add a state of its own."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.particles.particles import Particles


@dataclass(kw_only=True)
class ElasticState:
    """Device arrays of the n particles of bodies and walls, a row for each.

    Attributes:
        u:          Displacement x - X [m],                    vec [n]
        v:          Velocity [m/s],                            vec [n]
        force:      Total force, supports excluded [N],        vec [n]
        contact:    Contact force [N],                         vec [n]
        driven:     Prescribed acceleration [m/s^2],           vec [n]
        dissipated: Energy dissipated by damping so far [J],   float64 [n]
    """

    u: wp.array
    v: wp.array
    force: wp.array
    contact: wp.array
    driven: wp.array
    dissipated: wp.array

    def evolving(self) -> list[wp.array]:
        """All arrays."""
        return [getattr(self, item.name) for item in fields(self)]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of all arrays, by name."""
        return {item.name: getattr(self, item.name).numpy().copy() for item in fields(self)}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for item in fields(self):
            getattr(self, item.name).assign(arrays[item.name])


def initial_state(particles: Particles, *, types: NumericTypes, device: Any) -> ElasticState:
    """The undeformed particles with their initial velocities."""
    n = particles.count

    def zeros(dtype: Any) -> wp.array:
        return wp.zeros(n, dtype=dtype, device=device)

    return ElasticState(
        u=zeros(types.vec),
        v=wp.array(particles.velocities, dtype=types.vec, device=device),
        force=zeros(types.vec),
        contact=zeros(types.vec),
        driven=zeros(types.vec),
        dissipated=zeros(wp.float64),
    )

"""Everything of a fluid that evolves."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid.lists import NeighbourLists
from warp_mps.particles.particles import Particles


@dataclass(kw_only=True)
class FluidState:
    """State of the walls and of the fluid on a device, walls first; n particles, m of them fluid.

    Attributes:
        x:        Positions [m], vec [n].
        u:        Velocities [m/s], vec [n].
        a:        Accelerations of the walls, 0 for the fluid [m/s^2], vec [n].
        lost:     Whether a particle has left the domain, int32 [n].
        order:    Particle whose place in the arrays this is, counted among the fluid's, int32 [m].
        p:        Pressures [Pa], float64 [m].
        n:        Number densities [-], real [m].
        impulse:  Impulse of the fluid on the walls since the last whole interval [N s], in 2-D [N s/m], float64 [w].
        work:     Work of the walls on the fluid [J], in 2-D [J/m], float64 [w].
        forces:   Force of the fluid on the walls, its mean over the last whole interval [N], in 2-D [N/m], float64 [w].
        fallen:   Fall through periods so far, g times way, of what was at this place [m^2/s^2], float64 [m].
        time:     Time [s], float64 [1].
        steps:    Number of steps done, int32 [1].
        x_listed: Positions at which the neighbour lists were made [m], vec [n].
        stale:    Whether the lists must be made anew before they are used again, int32 [1].
    """

    x: wp.array
    u: wp.array
    a: wp.array
    lost: wp.array
    order: wp.array
    p: wp.array
    n: wp.array
    impulse: wp.array
    work: wp.array
    forces: wp.array
    fallen: wp.array
    time: wp.array
    steps: wp.array
    x_listed: wp.array
    stale: wp.array

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything."""
        return {item.name: getattr(self, item.name).numpy().copy() for item in fields(self)}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Take over arrays that `arrays` gave."""
        for item in fields(self):
            getattr(self, item.name).assign(arrays[item.name])


def initial_state(
    particles: Particles, lists: NeighbourLists, n0: float, *, types: NumericTypes, device: Any
) -> FluidState:
    """The state at the start of a run.

    Args:
        particles: The particles, walls first.
        lists: The neighbour lists.
        n0: Number density of a full lattice.
        types: Number types.
        device: Warp device.
    """
    n, m = particles.count, particles.liquid
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)

    def array(values: Any, kind: Any) -> wp.array:
        return wp.array(values, dtype=kind, device=device)

    return FluidState(
        x=array(particles.positions, types.vec),
        u=array(particles.velocities, types.vec),
        a=wp.zeros(n, dtype=types.vec, device=device),
        lost=wp.zeros(n, dtype=wp.int32, device=device),
        order=array(np.arange(m), wp.int32),
        p=wp.zeros(m, dtype=wp.float64, device=device),
        n=wp.full(m, n0, dtype=types.real, device=device),
        impulse=wp.zeros(max(n - m, 1), dtype=vec64, device=device),
        work=wp.zeros(max(n - m, 1), dtype=wp.float64, device=device),
        forces=wp.zeros(max(n - m, 1), dtype=vec64, device=device),
        fallen=wp.zeros(m, dtype=wp.float64, device=device),
        time=wp.zeros(1, dtype=wp.float64, device=device),
        steps=wp.zeros(1, dtype=wp.int32, device=device),
        x_listed=lists.x_listed,
        stale=lists.stale,
    )

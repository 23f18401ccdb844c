"""State of a fluid: everything that evolves."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import warp as wp

from warp_mps.core.counters import require_within, whole_numbers
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.neighbours import NeighbourLists


@dataclass(kw_only=True)
class FluidState:
    """State of n particles, the first w of them walls, the last m fluid; all of it is in a checkpoint.

    Arrays of fluid particles are in the order of the cells that the particles are in, see `sort`.

    Attributes:
        x:        Positions [m], vec [n].
        u:        Velocities [m/s], vec [n].
        a:        Accelerations of the walls less the body forces there, 0 for the fluid [m/s^2], vec [n].
        lost:     1 if a particle has left the domain, else 0, int32 [n].
        order:    Particle at each place of the arrays, counted among the fluid's, int32 [m].
        p:        Pressures [Pa], float64 [m].
        n:        Number densities [-], real [m].
        impulse:  Impulse of the fluid on the walls in the present interval [N s], in 2-D [N s/m], vec64 [w].
        work:     Work of the walls on the fluid [J], in 2-D [J/m], float64 [w].
        forces:   Mean force of the fluid on the walls over the last whole interval [N], in 2-D [N/m], vec64 [w].
        fallen:   Sum of gravity times the periods that particles were wrapped by at a place [m^2/s^2], float64 [m].
        time:     Time [s], float64 [1].
        steps:    Number of steps done, int32 [1].
        x_listed: Positions at which the neighbour lists were made [m], vec [n].
        stale:    1 if the lists must be renewed before they are used again, else 0, int32 [1].
        u_before: Velocities at the start of the last interval, in the order of the scene [m/s], host, shape [n, d].
        interval: Length of the last interval [s], host; infinite before the first.
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
    u_before: np.ndarray
    interval: float

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything."""
        device = {name: getattr(self, name).numpy().copy() for name in _device_fields()}
        return {**device, "u_before": self.u_before, "interval": np.array(self.interval)}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: The order does not hold every particle once, or a flag or a counter is none.
        """
        if not np.array_equal(np.sort(arrays["order"]), np.arange(len(self.order))):
            raise ValueError(f"order must hold each whole number from 0 to {len(self.order) - 1} once")
        require_within("lost", arrays["lost"], 1)
        require_within("stale", arrays["stale"], 1)
        whole_numbers(arrays["steps"])
        for name in _device_fields():
            getattr(self, name).assign(arrays[name])
        self.u_before, self.interval = arrays["u_before"].copy(), float(arrays["interval"])

    @property
    def walls(self) -> int:
        """Number of wall particles w."""
        return len(self.x) - len(self.p)

    @property
    def now(self) -> float:
        """Time on the host [s]."""
        return float(self.time.numpy()[0])

    def fluid_in_scene_order(self, values: np.ndarray) -> np.ndarray:
        """Values of the fluid particles in the order of the scene, as float64, shape [m, ...]."""
        ordered = np.empty(values.shape, float)
        ordered[self.order.numpy()] = values
        return ordered

    def in_scene_order(self, array: wp.array) -> np.ndarray:
        """Values of all particles in the order of the scene, as float64, shape [n, ...]."""
        values, w = array.numpy(), self.walls
        return np.concatenate((values[:w].astype(float), self.fluid_in_scene_order(values[w:])))

    def sort(self, low: np.ndarray, cell: float) -> None:
        """Put the fluid particles in the order of cells, so that neighbours in space are near in memory.

        Neighbour lists must be renewed afterwards.

        Args:
            low: Lowest corner of the domain [m], shape [d].
            cell: Size of a cell [m].
        """
        w = self.walls
        x = self.x.numpy()[w:].astype(float)
        cells = np.floor((x - low) / cell).astype(np.int64)
        new = np.lexsort((*x.T[::-1], *cells.T[::-1]))
        for array in (self.order, self.p, self.n):
            array.assign(array.numpy()[new])
        for array in (self.x, self.u, self.lost):
            values = array.numpy().copy()
            values[w:] = values[w:][new]
            array.assign(values)


def initial_state(model: FluidModel, neighbours: NeighbourLists) -> FluidState:
    """The state at the start of a run.

    Args:
        model: Constants of the run.
        neighbours: Its neighbour lists.
    """
    particles, types, device = model.particles, model.types, model.device
    n, m, w = particles.count, model.count, max(model.walls, 1)
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    return FluidState(
        x=wp.array(particles.positions, dtype=types.vec, device=device),
        u=wp.array(particles.velocities, dtype=types.vec, device=device),
        a=wp.zeros(n, dtype=types.vec, device=device),
        lost=wp.zeros(n, dtype=wp.int32, device=device),
        order=wp.array(np.arange(m), dtype=wp.int32, device=device),
        p=wp.zeros(m, dtype=wp.float64, device=device),
        n=wp.full(m, model.operators.number_density, dtype=types.real, device=device),
        impulse=wp.zeros(w, dtype=vec64, device=device),
        work=wp.zeros(w, dtype=wp.float64, device=device),
        forces=wp.zeros(w, dtype=vec64, device=device),
        fallen=wp.zeros(m, dtype=wp.float64, device=device),
        time=wp.zeros(1, dtype=wp.float64, device=device),
        steps=wp.zeros(1, dtype=wp.int32, device=device),
        x_listed=neighbours.x_listed,
        stale=neighbours.stale,
        u_before=particles.velocities,
        interval=math.inf,
    )


def _device_fields() -> list[str]:
    """Names of the fields that are arrays on the device."""
    return [item.name for item in fields(FluidState) if item.name not in ("u_before", "interval")]

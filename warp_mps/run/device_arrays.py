"""Arrays of a running simulation on its device, as the kernels work on them, without a copy.

The names, and what the arrays hold; vec is a vector of the scene's dimension and real a number, both in the run's
precision:

- ``solid.displacements``: u = x - X [m], vec [s].
- ``solid.velocities``: [m/s], vec [s].
- ``solid.forces``: Total force on each particle at the end of the last step [N], vec [s].
- ``fluid.positions``: x [m], vec [n].
- ``fluid.velocities``: [m/s], vec [n].
- ``fluid.pressures``: [Pa], float64 [m].
- ``fluid.number_densities``: In units of 1, not of a full lattice's [-], real [m].
- ``fluid.order``: For each row of the fluid, the number of its particle among the fluids' particles, int32 [m].

Rows of ``solid`` are in the order of `Simulation.particles`: s elastic particles, and walls that they may touch after
them. Rows of ``fluid`` begin with the n - m particles of walls (beside elastic bodies first with markers, particles of
the fluid's spacing that stand for the bodies), then come the m particles of the fluids. These are sorted by cells every
100 steps: row ``n - m + k`` of the positions, and row ``k`` of the pressures, are those of the fluids' particle
``order[k]``.

An array stays the same object, on the device of the simulation, as long as the simulation lives; its contents change
with every step. Do not write to it: other arrays depend on what it holds.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import warp as wp


def device_arrays(solid: Any, fluids: Any) -> Mapping[str, wp.array]:
    """The arrays of a simulation by name.

    Args:
        solid: The elastic bodies, a `warp_mps.elastic.system.ElasticSystem`, or None.
        fluids: The fluids, a `warp_mps.fluid.fluids.Fluids`, or None.
    """
    found: dict[str, wp.array] = {}
    if solid is not None:
        state = solid.state
        found |= {"solid.displacements": state.u, "solid.velocities": state.v, "solid.forces": state.force}
    if fluids is not None:
        state = fluids.state
        found |= {"fluid.positions": state.x, "fluid.velocities": state.u, "fluid.pressures": state.p}
        found |= {"fluid.number_densities": state.n, "fluid.order": state.order}
    return MappingProxyType(found)

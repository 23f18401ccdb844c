"""All kernels of fluids, by name."""

import functools
from types import SimpleNamespace

from warp_mps.core.types import NumericTypes
from warp_mps.fluid.adaptive_step_kernels import adaptive_step_kernels
from warp_mps.fluid.collisions import collision_kernels
from warp_mps.fluid.gradient import gradient_kernels
from warp_mps.fluid.implicit_viscosity import implicit_viscosity_kernels
from warp_mps.fluid.mirror_planes import mirror_plane_kernels
from warp_mps.fluid.neighbour_search import neighbour_search_kernels
from warp_mps.fluid.pressure.level import level_kernels
from warp_mps.fluid.pressure.rows import row_kernels
from warp_mps.fluid.shifting import shifting_kernels
from warp_mps.fluid.still_water import still_water_kernels
from warp_mps.fluid.time_integration import integration_kernels
from warp_mps.fluid.viscosity import viscosity_kernels
from warp_mps.fluid.volumes import volume_kernels
from warp_mps.fluid.wall_forces import wall_force_kernels

# cached factories over the number types, of which each makes the kernels of one file
FACTORIES = (
    neighbour_search_kernels,
    adaptive_step_kernels,
    viscosity_kernels,
    implicit_viscosity_kernels,
    integration_kernels,
    mirror_plane_kernels,
    still_water_kernels,
    row_kernels,
    level_kernels,
    gradient_kernels,
    wall_force_kernels,
    shifting_kernels,
    collision_kernels,
    volume_kernels,
)


@functools.cache
def fluid_kernels(types: NumericTypes) -> SimpleNamespace:
    """All kernels of fluids, declared on the first call."""
    kernels: dict[str, object] = {}
    for make in FACTORIES:
        kernels.update(vars(make(types)))
    return SimpleNamespace(**kernels)

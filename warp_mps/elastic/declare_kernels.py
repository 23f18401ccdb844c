"""The kernels of elastic bodies and their contact, declared together so that their module is compiled once."""

from __future__ import annotations

from dataclasses import replace

from warp_mps.core.neighbours import METHOD as NEIGHBOURS
from warp_mps.core.neighbours import neighbour_kernels
from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.boundary.boundary_kernels import boundary_kernels
from warp_mps.elastic.contact.friction_kernels import friction_kernels
from warp_mps.elastic.contact.kernels import contact_kernels
from warp_mps.elastic.contact.search_kernels import search_kernels
from warp_mps.elastic.damping.kernels import viscous_kernels
from warp_mps.elastic.explicit.kernels import motion_kernels
from warp_mps.elastic.hamiltonian.dilatation_kernels import dilatation_kernels
from warp_mps.elastic.hamiltonian.kernels import hamiltonian_kernels
from warp_mps.elastic.output.energies import energy_kernels
from warp_mps.elastic.output.inversion_kernels import inversion_kernels
from warp_mps.elastic.output.stresses import stress_kernels
from warp_mps.elastic.springs.kernels import spring_kernels
from warp_mps.elastic.springs.rotation_kernels import rotation_kernels

KERNELS = (
    *(spring_kernels, rotation_kernels, hamiltonian_kernels, dilatation_kernels, inversion_kernels),
    *(motion_kernels, boundary_kernels, search_kernels, contact_kernels, energy_kernels, stress_kernels),
    *(viscous_kernels, friction_kernels),
)


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare every kernel of a dimension and precision, and return the names of their modules."""
    for declare in KERNELS:
        declare(types)
    # the reference neighbours are searched in double precision, whatever that of the run
    double = replace(types, precision="float64")
    neighbour_kernels(double)
    return [types.module(METHOD), double.module(NEIGHBOURS)]

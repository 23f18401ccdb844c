"""The interface of an elastic model."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
import warp as wp

from warp_mps.elastic.output.stresses import StressFields
from warp_mps.elastic.springs.rotation import ParticleRotation
from warp_mps.elastic.state import ElasticState

# launches over particles, from (state, first, count)
Pass = Callable[[ElasticState, int, int], None]


class ElasticModel(Protocol):
    """The constants of a model for a set of particles, and the launches that use them."""

    @property
    def rotation(self) -> ParticleRotation | None:
        """Rotation of the particles; None where the model gives them none."""

    @property
    def index(self) -> wp.array:
        """Neighbour of each pair."""

    @property
    def start(self) -> wp.array:
        """First pair of each particle, shape [n + 1]."""

    @property
    def bond(self) -> wp.array:
        """Reference vector X_ij of each pair [m]."""

    @property
    def inverted(self) -> wp.array:
        """1 where J has been 0 or less in an evaluation, int32 [n]; a model without J leaves it to others."""

    def gradients(self, state: ElasticState) -> wp.array:
        """Displacement gradients H = F - I [-], shape [n, d, d]; those of the last evaluation where the model has F."""

    @property
    def passes(self) -> list[tuple[str, Pass]]:
        """The launches that evaluate the forces, in order, each by name; a pass reads the results of the one before."""

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Elastic energy of every particle [J]."""

    def pressures(self) -> np.ndarray:
        """Pressures at the last evaluation of the forces [Pa], shape [n]."""

    def stress_fields(self, state: ElasticState) -> StressFields:
        """Stresses and strains; see `warp_mps.elastic.output.stresses`."""

    def energy_densities(self, state: ElasticState) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""

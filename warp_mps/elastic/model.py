"""What an elastic model is, and which there are."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.elastic.spins import Spins
from warp_mps.elastic.state import ElasticState
from warp_mps.elastic.stresses import StressFields
from warp_mps.particles import Particles
from warp_mps.scene import Scene

# launches over a number of particles from a first one on
Pass = Callable[[ElasticState, int, int], None]


class ElasticModel(Protocol):
    """The constants of a model for a set of particles, and the launches that use them."""

    @property
    def spins(self) -> Spins | None:
        """Rotation of the particles; None where the model gives them none."""

    @property
    def index(self) -> wp.array:
        """Neighbour of each pair."""

    @property
    def passes(self) -> list[tuple[str, Pass]]:
        """What evaluates the forces, in order, each by name; a pass reads what the one before wrote."""

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Elastic energy of every particle [J]."""

    def pressures(self) -> np.ndarray:
        """Pressures at the last evaluation of the forces [Pa], shape [n]."""

    def stress_fields(self, state: ElasticState) -> StressFields:
        """Stresses and strains; see `warp_mps.elastic.stresses`."""

    def energy_densities(self, state: ElasticState) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""


def make_model(scene: Scene, particles: Particles, held: np.ndarray, *, kit: Kit, device: Any) -> ElasticModel:
    """The model that a scene names.

    Args:
        scene: The case.
        particles: Its particles.
        held: Whether the rotation of each particle is held, shape [n].
        kit: Number types.
        device: Warp device.
    """
    from warp_mps.elastic.hamiltonian_model import HamiltonianModel
    from warp_mps.elastic.springs_model import SpringModel

    if scene.elasticity.model == "hamiltonian":
        return HamiltonianModel(scene, particles, kit=kit, device=device)
    return SpringModel(scene, particles, held, kit=kit, device=device)

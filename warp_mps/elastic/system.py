"""The elastic bodies of a scene as a simulation sees them; how they advance is left to a subclass."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import warp as wp

from warp_mps.elastic.boundary.conditions import BoundaryConditions
from warp_mps.elastic.contact.model import Contacts
from warp_mps.elastic.model import ElasticModel
from warp_mps.elastic.output.stresses import StressFields
from warp_mps.elastic.parts import SolidParts
from warp_mps.elastic.readings import SolidReadings
from warp_mps.elastic.solid_state import SolidState
from warp_mps.elastic.state import ElasticState
from warp_mps.results.energy import Energy


class ElasticSystem(ABC):
    """Parts, state and readings of elastic bodies; it is a `warp_mps.run.system.System`.

    Args:
        parts: Parts of the bodies.
        evolution: Everything that evolves.
        readings: Quantities of the particles, and energies.

    Attributes:
        parts: As given.
        evolution: As given.
        readings: As given.
    """

    def __init__(self, parts: SolidParts, evolution: SolidState, readings: SolidReadings) -> None:
        self.parts, self.evolution, self.readings = parts, evolution, readings

    @abstractmethod
    def start(self) -> None:
        """Evaluate the forces of the initial state, with which the first step begins."""

    @property
    def state(self) -> ElasticState:
        """Displacements, velocities and forces of the particles, on the device."""
        return self.parts.state

    @property
    def model(self) -> ElasticModel:
        """The elastic model."""
        return self.parts.model

    @property
    def boundary(self) -> BoundaryConditions:
        """Supports and loads."""
        return self.parts.boundary

    @property
    def contacts(self) -> Contacts | None:
        """Contact; None if nothing can touch."""
        return self.parts.contacts

    @property
    def external(self) -> wp.array | None:
        """Forces on the particles beside those of the scene [N], vec [n]; None if there never are any."""
        return self.parts.external

    def evolving(self) -> list[wp.array]:
        """Device arrays of everything that evolves."""
        return self.evolution.evolving()

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything that evolves, by name, for a checkpoint."""
        return self.evolution.arrays()

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.evolution.assign(arrays)

    def trouble(self) -> str | None:
        """Why the run cannot go on; None if it can."""
        return self.readings.trouble()

    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self.readings.displacements()

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self.readings.velocities()

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self.readings.rotations()

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self.readings.angular_velocities()

    def pressures(self) -> np.ndarray:
        """Pressures at the last evaluation of the forces [Pa], shape [n]."""
        return self.readings.pressures()

    def number_densities(self) -> np.ndarray:
        """1, since no particle belongs to a fluid [-], shape [n]."""
        return np.ones(self.parts.particles.count)

    def volumes(self) -> np.ndarray:
        """0, since no particle belongs to a fluid [m^d], shape [n]."""
        return np.zeros(self.parts.particles.count)

    def stress_fields(self) -> StressFields:
        """Cauchy stresses [Pa] and Green-Lagrange strains [-], shape [n, 3, 3]."""
        return self.readings.stress_fields()

    def energy_densities(self) -> np.ndarray:
        """Strain energy of each particle per reference volume [J/m^3], shape [n]."""
        return self.readings.energy_densities()

    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, d]."""
        return self.readings.contact_forces()

    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces: the total force less weight and loads [N], shape [n, d]."""
        return self.readings.internal_forces()

    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self.readings.elastic_torques()

    def reactions(self) -> np.ndarray:
        """Forces that the supports exert on the particles [N], shape [n, d]."""
        return self.readings.reactions()

    def work(self) -> float:
        """Work done on the bodies so far [J]."""
        return self.readings.work()

    def energy(self) -> Energy:
        """Energies of the present state [J], in 2-D [J/m]."""
        return self.readings.energy()

    def energy_of_bodies(self) -> Energy | None:
        """None: there is no water."""
        return None

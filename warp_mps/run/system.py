"""Interface of the simulation to the method of a scene: elastic bodies, fluids, or both coupled."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from warp_mps.results.energy import Energy


class System(Protocol):
    """Particles that move together; quantities are float64 host arrays in the order of the particles."""

    def start(self) -> None:
        """Evaluate the forces or neighbours of the initial state."""

    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""

    def number_densities(self) -> np.ndarray:
        """Number densities of fluids in units of a full lattice's, else 1 [-], shape [n]."""

    def volumes(self) -> np.ndarray:
        """Volumes that particles of fluids take up, else 0 [m^d], shape [n]."""

    def stress_fields(self) -> Any:
        """Stresses and strains; see `warp_mps.elastic.output.stresses.StressFields`."""

    def energy_densities(self) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""

    def contact_forces(self) -> np.ndarray:
        """Forces of contact, and of fluids on walls [N], shape [n, d]."""

    def internal_forces(self) -> np.ndarray:
        """Forces of the particles on each other [N], shape [n, d]."""

    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    def reactions(self) -> np.ndarray:
        """Forces that supports exert on the particles [N], shape [n, d]."""

    def energy(self) -> Energy:
        """Energies of all particles."""

    def energy_of_bodies(self) -> Energy | None:
        """Energies of elastic bodies in water alone, on which the water does work; None if either is missing."""

    def trouble(self) -> str | None:
        """Why the run must stop, without the time; None if it need not."""

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""


class PacedSystem(System, Protocol):
    """A system that decides on the host how a step of the run proceeds, so that no step is one replayed graph."""

    def advance(self, time: float) -> object:
        """Advance to a time [s], or in statics to a load factor.

        Raises:
            RunError: A step, or an equilibrium, could not be solved, or a fluid particle ran away.
        """

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of its solvers, by the field of `warp_mps.results.summary.RunSummary` that holds them."""

"""Readings of a run at one moment: quantities of its particles, as read-only NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from warp_mps.core.warp_turn import warp_turn
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.run.system import System


class Readings:
    """Quantities of the present moment, read from the device when first asked for and kept until the next step.

    Arrays are float64 and read-only, in the order of `particles`: elastic bodies, walls, fluids, each as the scene has
    them. n is the number of particles and d the dimension. In 2-D every extensive quantity (mass, force, energy) is per
    metre of depth.

    Attributes:
        particles: The particles in their reference configuration.

    Args:
        particles: The particles.
        system: The system that is read.
    """

    def __init__(self, particles: Particles, system: System) -> None:
        self.particles, self._system = particles, system
        self._read: dict[str, Any] = {}

    def forget(self) -> None:
        """Read everything again when it is next asked for, since the state has changed."""
        self._read.clear()

    @property
    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self._once("u", self._system.displacements)

    @property
    def positions(self) -> np.ndarray:
        """Positions x [m], shape [n, d]."""
        return self._once("x", lambda: self.particles.positions + self.displacements)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._once("v", self._system.velocities)

    @property
    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("q", self._system.rotations)

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("omega", self._system.angular_velocities)

    @property
    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""
        return self._once("p", self._system.pressures)

    @property
    def number_densities(self) -> np.ndarray:
        """Number densities of fluids in units of a full lattice's, else 1 [-], shape [n]."""
        return self._once("n", self._system.number_densities)

    @property
    def volumes(self) -> np.ndarray:
        """Volumes that particles of fluids take up, else 0 [m^d], shape [n]; see `warp_mps.fluid.volumes`."""
        return self._once("volumes", self._system.volumes)

    @property
    def stresses(self) -> np.ndarray:
        """Cauchy stresses along the scene's axes [Pa], shape [n, 3, 3]; see `warp_mps.elastic.output.stresses`."""
        return self._once("stress", self._system.stress_fields).stresses

    @property
    def strains(self) -> np.ndarray:
        """Green-Lagrange strains along the scene's axes [-], shape [n, 3, 3]."""
        return self._once("stress", self._system.stress_fields).strains

    @property
    def von_mises(self) -> np.ndarray:
        """Von Mises stresses [Pa], shape [n]."""
        from warp_mps.elastic.output.stresses import von_mises

        return self._once("von Mises", lambda: von_mises(self.stresses))

    @property
    def strain_energy_densities(self) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""
        return self._once("density", self._system.energy_densities)

    @property
    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, d]."""
        return self._once("contact", self._system.contact_forces)

    @property
    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces: the total force less weight and loads [N], shape [n, d]."""
        return self._once("internal", self._system.internal_forces)

    @property
    def elastic_forces(self) -> np.ndarray:
        """Elastic forces, and those of the material's damping, on the particles [N], shape [n, d]."""
        return self._once("elastic", lambda: self.internal_forces - self.contact_forces)

    @property
    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("torques", self._system.elastic_torques)

    @property
    def reactions(self) -> np.ndarray:
        """Forces that the supports exert on the particles [N], shape [n, d]."""
        return self._once("reactions", self._system.reactions)

    @property
    def energy(self) -> Energy:
        """Energies of all particles [J], in 2-D [J/m]."""
        return self._once("energy", self._system.energy)

    @property
    def energy_of_bodies(self) -> Energy | None:
        """Energies of elastic bodies in water alone, on which the water does work [J]; None if either is missing."""
        return self._once("energy of bodies", self._system.energy_of_bodies)

    def _once(self, name: str, read: Callable[[], Any]) -> Any:
        with warp_turn:
            return self._read[name] if name in self._read else self._keep(name, read())

    def _keep(self, name: str, value: Any) -> Any:
        for array in value if isinstance(value, tuple) else (value,):
            if isinstance(array, np.ndarray):
                # observers share it
                array.flags.writeable = False
        self._read[name] = value
        return value

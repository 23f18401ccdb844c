"""Readings of elastic bodies: quantities of their particles as host arrays, and energies."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.elastic.explicit.kernels import motion_kernels
from warp_mps.elastic.output.energies import CHUNK, energy_kernels
from warp_mps.elastic.output.stresses import StressFields
from warp_mps.elastic.parts import SolidParts
from warp_mps.results.energy import Energy


class SolidReadings:
    """Quantities of the n particles of elastic bodies and of the walls that they touch, float64, in their order.

    Args:
        parts: The parts of the bodies.
    """

    def __init__(self, parts: SolidParts) -> None:
        self.parts, self._state = parts, parts.state
        self._motion, self._sums = motion_kernels(parts.types), energy_kernels(parts.types)
        n, device = parts.particles.count, parts.device
        self._values = wp.zeros((4, n), dtype=parts.types.real, device=device)
        self._chunks = wp.zeros((4, -(-n // CHUNK)), dtype=wp.float64, device=device)

    def energy(self) -> Energy:
        """Energies of the present state [J]."""
        parts, state, values = self.parts, self._state, self._values
        inputs = [parts.gravity, parts.mass, state.u, state.v]
        kernels, device = self._sums, parts.device
        wp.launch(kernels.particle_energies, parts.count, inputs, [values[0], values[1]], device=device)
        if parts.model.rotation:
            parts.model.rotation.add_kinetic(values[0])
        parts.model.launch_energy(state, values[2])
        if parts.contacts:
            parts.contacts.launch_energy(state, values[3])
        for k in range(4):
            sums = self._chunks[k]
            wp.launch(kernels.chunk_sums, len(sums), [values[k]], [sums], device=device)
        kinetic, potential, elastic, contact = self._chunks.numpy().sum(axis=1)
        return Energy(
            kinetic=float(kinetic),
            elastic=float(elastic),
            contact=float(contact),
            potential=float(potential),
            work=self.work(),
            dissipated=float(np.sum(state.dissipated.numpy().astype(float))),
        )

    def work(self) -> float:
        """Work of supports, loads, moving walls and body forces so far [J]."""
        parts = self.parts
        return float(sum(part.work() for part in (parts.boundary, parts.walls, parts.body_forces) if part))

    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self._state.u.numpy().astype(float)

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._state.v.numpy().astype(float)

    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, d]."""
        return self._state.contact.numpy().astype(float)

    def reactions(self) -> np.ndarray:
        """Force that the supports exert on each particle: m a - f on the held axes [N], shape [n, d].

        A clamp exerts them at its face, not where its particles stand.
        """
        inertial = self.parts.masses[:, None] * self._state.driven.numpy()
        return np.where(self.parts.boundary.held, inertial - self._state.force.numpy(), 0.0)

    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces: the total force less weight and loads [N], shape [n, d]."""
        parts = self.parts
        weight = np.outer(parts.masses, [float(g) for g in parts.gravity])
        loads = wp.zeros_like(self._state.force)
        parts.boundary.add_loads(loads, parts.mass)
        if parts.external is not None:
            wp.launch(self._motion.add_force, parts.count, [parts.external], [loads], device=parts.device)
        if parts.body_forces:
            wp.launch(self._motion.add_force, parts.count, [parts.body_forces.force], [loads], device=parts.device)
        return self._state.force.numpy().astype(float) - weight - loads.numpy()

    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        rotation = self.parts.model.rotation
        return self._with_walls(rotation.torque.numpy().astype(float) if rotation else self._no_rotation())

    def stress_fields(self) -> StressFields:
        """Cauchy stresses [Pa] and Green-Lagrange strains [-] of the present state, shape [n, 3, 3]."""
        return StressFields(*map(self._with_walls, self.parts.model.stress_fields(self._state)))

    def energy_densities(self) -> np.ndarray:
        """Strain energy of each particle per reference volume [J/m^3], shape [n]."""
        return self._with_walls(self.parts.model.energy_densities(self._state))

    def pressures(self) -> np.ndarray:
        """Pressures at the last evaluation of the forces [Pa], shape [n]."""
        return self._with_walls(self.parts.model.pressures())

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        walls = self.parts.walls
        return self._with_walls(self.parts.model.rotations(), walls.turns()[0] if walls else None)

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        rotation, walls = self.parts.model.rotation, self.parts.walls
        omega = rotation.omega.numpy().astype(float) if rotation else self._no_rotation()
        return self._with_walls(omega, walls.turns()[1] if walls else None)

    def trouble(self) -> str | None:
        """Why the run cannot go on; None if it can.

        A particle is turned inside out, or it has more contact candidates than its list holds.
        """
        parts = self.parts
        if (trouble := parts.inversions.trouble(self._state)) is not None:
            return trouble
        if not parts.contacts or (particle := parts.contacts.overflowed()) is None:
            return None
        return (
            f"{parts.particles.describe(particle)} meets more particles of other bodies than a contact can hold: "
            "the bodies are crushed into each other; stiffen the contact"
        )

    def _no_rotation(self) -> np.ndarray:
        return np.zeros((self.parts.count, 2 * self.parts.types.dimension - 3))

    def _with_walls(self, elastic: np.ndarray, walls: np.ndarray | None = None) -> np.ndarray:
        """Values of the elastic particles, followed by those of the walls, which are 0 if not given."""
        if not self.parts.walls:
            return elastic
        count = self.parts.particles.count - self.parts.count
        return np.concatenate((elastic, np.zeros((count, *elastic.shape[1:])) if walls is None else walls))

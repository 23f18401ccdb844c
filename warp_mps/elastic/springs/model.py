"""The constants of the spring model for a given set of particles, and the launches that use them."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.neighbours import reference_neighbours
from warp_mps.core.rotation import rotation_vectors
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import lattice_number_density
from warp_mps.elastic.boundary.clamp_faces import clamp_faces
from warp_mps.elastic.materials.constants import lame_constants
from warp_mps.elastic.model import Pass
from warp_mps.elastic.output.stresses import StressFields, stress_fields, stress_kernels
from warp_mps.elastic.springs.kernels import spring_kernels
from warp_mps.elastic.springs.rotation import ParticleRotation
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class SpringModel:
    """The paper's model on a set of particles.

    Attributes:
        start: First pair of each particle, shape [n + 1].
        index: Neighbour of each pair.
        bond: Reference vector X_ij of each pair [m], shape [pairs, d].
        area: d w_ij / |X_ij| of each pair, without 1/n [1/m].
        stiffness: Spring stiffness k_ij of each pair [N/m].
        bulk: V0 lambda / n^2 of each particle [N m].
        rotation: Rotation of the particles.
        pressure: V0 lambda (div u)_i / n_i of each particle [N m], shape [n].
        inverted: 1 where J has been 0 or less; nothing here finds it, int32, shape [n].
        number_density: Number density that normalizes the operators of each particle, n0 or n_i [-], shape [n].
    """

    def __init__(
        self, scene: Scene, particles: Particles, held: np.ndarray, *, types: NumericTypes, device: Any
    ) -> None:
        self.kernels = spring_kernels(types)
        self._types, self.device = types, device
        self.rotation = ParticleRotation(particles, held, types=types, device=device)
        self.pressure = wp.zeros(particles.count, dtype=types.real, device=device)
        d, n, radius = particles.dimension, particles.count, scene.elasticity.effective_radius
        reach = radius * particles.spacings
        self.start, self.index = reference_neighbours(particles.positions, particles.groups, reach, device=device)
        constants = [lame_constants(material, d, scene.plane) for material in scene.materials]
        lame = np.array(constants)[particles.materials]
        self.volume = particles.spacings**d
        self._lame, self._plane_stress = lame, int(d == 2 and scene.plane == "stress")

        def double(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=wp.float64, device=device)

        vec64 = wp.types.vector(length=d, dtype=wp.float64)
        reference = wp.array(particles.positions, dtype=vec64, device=device)
        places = [self.start, self.index, reference, double(reach)]
        density = double(np.full(n, lattice_number_density(d, radius)))
        if scene.elasticity.normalization == "particle":
            wp.launch(self.kernels.number_density, n, places, [density], device=device)
        # a particle without neighbours has no force to normalize
        self.number_density = np.maximum(density.numpy(), 1e-12)
        pairs = len(self.index)
        self.bond = wp.empty(pairs, dtype=types.vec, device=device)
        self.area = wp.empty(pairs, dtype=types.real, device=device)
        self.stiffness = wp.empty(pairs, dtype=types.real, device=device)
        inputs = [*places, double(self.volume), double(lame[:, 1]), double(1.0 / self.number_density)]
        wp.launch(self.kernels.bonds, n, inputs, [self.bond, self.area, self.stiffness], device=device)
        bulk = self.volume * lame[:, 0] / self.number_density**2
        self._end_at_clamps(scene, particles, bulk)
        self.bulk = wp.array(bulk, dtype=types.real, device=device)
        self.inverted = wp.zeros(n, dtype=wp.int32, device=device)

    @property
    def passes(self) -> list[tuple[str, Pass]]:
        """The launches that evaluate the forces, in order: volume changes, then forces and torques."""
        return [("pressure", self._launch_pressure), ("force", self._launch_force)]

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Elastic energy of every particle [J]."""
        inputs = [self.start, self.index, self.bond, self.area, self.stiffness, self.bulk, state.u, self.rotation.q]
        wp.launch(self.kernels.energy, len(self.bulk), inputs, [energy_out], device=self.device)

    def pressures(self) -> np.ndarray:
        """Pressure p_i = -lambda (div u)_i of each particle (eq. 14) [Pa], shape [n]."""
        return -self.pressure.numpy().astype(float) * self.number_density / self.volume

    def gradients(self, state: ElasticState) -> wp.array:
        """Displacement gradients that fit the neighbours best [-], shape [n, d, d]."""
        gradients = wp.empty(len(self.bulk), dtype=self._types.mat, device=self.device)
        inputs = [self.start, self.index, self.bond, self.area, state.u, self.rotation.q]
        wp.launch(stress_kernels(self._types).fit, len(gradients), inputs, [gradients], device=self.device)
        return gradients

    def stress_fields(self, state: ElasticState) -> StressFields:
        """Stresses and strains of the deformation that fits the neighbours best."""
        gradients = self.gradients(state)
        laws = wp.zeros(len(gradients), dtype=wp.int32, device=self.device)
        constants = [wp.array(values, dtype=self._types.real, device=self.device) for values in self._lame.T]
        constants = [laws, *constants, self._plane_stress]
        none = wp.zeros(len(gradients), dtype=self._types.real, device=self.device)
        return stress_fields(gradients, constants, none, types=self._types, device=self.device)

    def energy_densities(self, state: ElasticState) -> np.ndarray:
        """Energy of the springs and of the volume change per reference volume [J/m^3], shape [n]."""
        energies = wp.empty(len(self.bulk), dtype=self._types.real, device=self.device)
        self.launch_energy(state, energies)
        return energies.numpy().astype(float) / self.volume

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return rotation_vectors(self.rotation.q.numpy().astype(float))

    def _end_at_clamps(self, scene: Scene, particles: Particles, bulk: np.ndarray) -> None:
        """End the pairs at the faces of clamps: a spring cut short to the share t of its length is 1/t as stiff.

        The free neighbours of a held particle next to a face count twice in its volume change, mirrored at the face.
        """
        faces = clamp_faces(scene, particles, self.start.numpy(), self.index.numpy())
        if faces is None:
            return
        for array, share in ((self.bond, 1.0), (self.area, -1.0), (self.stiffness, -1.0)):
            values = array.numpy()
            values[faces.pairs] = (values[faces.pairs].T * faces.fraction**share).T
            array.assign(values)
        bulk[faces.next_to] *= faces.share * faces.doubling**2

    def _launch_pressure(self, state: ElasticState, first: int, count: int) -> None:
        inputs = [first, self.start, self.index, self.bond, self.area, self.bulk, state.u, self.rotation.q]
        wp.launch(self.kernels.pressure, count, inputs, [self.pressure], device=self.device)

    def _launch_force(self, state: ElasticState, first: int, count: int) -> None:
        constants = [first, self.start, self.index, self.bond, self.area, self.stiffness]
        inputs = [*constants, state.u, self.rotation.q, self.pressure]
        wp.launch(self.kernels.force, count, inputs, [state.force, self.rotation.torque], device=self.device)

"""The constants of the Hamiltonian model for a given set of particles, and the launches that use them."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.neighbours import reference_neighbours
from warp_mps.core.rotation import rotation_vectors
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.boundary.clamp_faces import clamp_faces
from warp_mps.elastic.hamiltonian.clamped_pairs import end_pairs_at_faces
from warp_mps.elastic.hamiltonian.control import control_share
from warp_mps.elastic.hamiltonian.kernels import FLAT, hamiltonian_kernels
from warp_mps.elastic.hamiltonian.mean_dilatation import MeanDilatation
from warp_mps.elastic.materials.constants import law_constants, mean_lame
from warp_mps.elastic.model import Pass
from warp_mps.elastic.output.stresses import StressFields, stress_fields, stress_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.scene import LAWS, Scene
from warp_mps.scene.validation.scene import place


class HamiltonianModel:
    """Hamiltonian MPS on a set of particles.

    Attributes:
        rotation: None, since particles have no rotation of their own.
        start: First pair of each particle, shape [n + 1].
        index: Neighbour of each pair.
        bond: Reference vector X_ij of each pair [m], shape [pairs, d].
        weight: Weight omega_ij of each pair [1/m^2].
        kappa: Stiffness of the control of zero-energy modes at rest [N m], shape [n].
        resistance: The same at the last evaluation, kappa_i g(J_i) [N m], shape [n].
        dilatation: The mean dilatation.
        gradient: Displacement gradient H_i [-], shape [n, d, d].
        pull: B_i [N m], shape [n, d, d].
        inverted: 1 where J_i has been 0 or less in an evaluation, int32, shape [n].
    """

    rotation = None

    def __init__(self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._types, self._device = hamiltonian_kernels(types), types, device
        n, d = particles.count, particles.dimension
        reach = scene.elasticity.effective_radius * particles.spacings
        self.start, self.index = reference_neighbours(particles.positions, particles.groups, reach, device=device)

        def real(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=types.real, device=device)

        self.bond = wp.empty(len(self.index), dtype=types.vec, device=device)
        self.weight = wp.empty(len(self.index), dtype=types.real, device=device)
        self._inverse_shape = wp.zeros(n, dtype=types.mat, device=device)
        density = self._set_up(scene, particles, reach)
        materials = scene.materials
        lame, mu = np.array([law_constants(material, d, scene.plane) for material in materials])[particles.materials].T
        averaged = np.array([mean_lame(material, d, scene.plane) for material in materials])[particles.materials]
        volume = particles.spacings**d
        laws = np.array([LAWS.index(material.law) for material in materials])[particles.materials]
        self._law = wp.array(laws, dtype=wp.int32, device=device)
        self._plane_stress = int(d == 2 and scene.plane == "stress")
        stiffness = scene.elasticity.control * volume * 2.0 * mu * d / density * control_share(averaged, lame)
        self._end_at_clamps(scene, particles, volume, stiffness, averaged)
        self._volume = real(volume)
        kinds = np.column_stack((laws, lame, mu, particles.spacings))
        groups = np.unique(kinds, axis=0, return_inverse=True)[1].reshape(-1)
        self.dilatation = MeanDilatation(averaged, groups, self.operators(), self._law, types=types, device=device)
        self._lame, self._mu = real(lame - self.dilatation.lame.numpy()), real(mu)
        self.kappa = real(stiffness)
        self.resistance = wp.clone(self.kappa)
        self.gradient = wp.zeros(n, dtype=types.mat, device=device)
        self.pull = wp.zeros(n, dtype=types.mat, device=device)
        self.inverted = wp.zeros(n, dtype=wp.int32, device=device)

    @property
    def passes(self) -> list[tuple[str, Pass]]:
        """The launches that evaluate the forces, in order: stresses, mean dilatations if any, then forces."""
        mean: list[tuple[str, Pass]] = [("mean", self._launch_mean), ("gather", self._launch_gather)]
        return [("stress", self._launch_stress), *(mean if self.dilatation.acts else []), ("force", self._launch_force)]

    def gradients(self, state: ElasticState) -> wp.array:
        """Displacement gradients H_i at the last evaluation of the stresses [-], shape [n, d, d]."""
        return self.gradient

    def evaluate_stresses(self, state: ElasticState) -> None:
        """Launch all passes but the forces."""
        for _, launch in self.passes[:-1]:
            launch(state, 0, len(self.gradient))

    def operators(self) -> list[wp.array]:
        """Start and index of the pairs, their vectors and weights; A_i^-1 and volume of the particles."""
        return [self.start, self.index, self.bond, self.weight, self._inverse_shape, self._volume]

    def constants(self) -> list[Any]:
        """Law, lambda and mu of the particles, and whether the scene is in plane stress, as kernels take them.

        lambda is what acts on the particle's own dilatation.
        """
        return [self._law, self._lame, self._mu, self._plane_stress]

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Elastic energy of every particle at the last evaluation of the stresses [J]."""
        pairs = [self.start, self.index, self.bond, self.weight]
        inputs = [*pairs, self._volume, *self.constants(), self.dilatation.lame]
        inputs += [state.u, self.gradient, self.resistance, self.dilatation.mean]
        wp.launch(self._kernels.energy, len(self._volume), inputs, [energy_out], device=self._device)

    def pressures(self) -> np.ndarray:
        """Pressure -tr(sigma)/d of the Cauchy stress sigma = P F^T / J in the scene's dimensions [Pa], shape [n]."""
        d = self._types.dimension
        stresses = self._stress_fields().stresses
        return -np.trace(stresses[:, :d, :d], axis1=1, axis2=2) / d

    def stress_fields(self, state: ElasticState) -> StressFields:
        """Stresses and strains at the last evaluation of the stresses."""
        return self._stress_fields()

    def energy_densities(self, state: ElasticState) -> np.ndarray:
        """Strain energy per reference volume, without that of the hourglass control [J/m^3], shape [n]."""
        densities = wp.empty(len(self.gradient), dtype=self._types.real, device=self._device)
        inputs = [*self.constants(), self.dilatation.lame, self.gradient, self.dilatation.mean]
        wp.launch(stress_kernels(self._types).density, len(densities), inputs, [densities], device=self._device)
        return densities.numpy().astype(float)

    def rotations(self) -> np.ndarray:
        """Rotation vectors of R in F = R U [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        f = self.gradient.numpy().astype(float) + np.eye(self.gradient.numpy().shape[-1])
        if f.shape[-1] == 2:
            return np.arctan2(f[:, 1, 0] - f[:, 0, 1], f[:, 0, 0] + f[:, 1, 1])[:, None]
        return rotation_vectors(_nearest_rotors(f))

    def _set_up(self, scene: Scene, particles: Particles, reach: np.ndarray) -> np.ndarray:
        """Weights and shapes of the neighbourhoods; the number densities n_i."""
        n, device = particles.count, self._device
        vec64 = wp.types.vector(length=particles.dimension, dtype=wp.float64)
        reference = wp.array(particles.positions, dtype=vec64, device=device)
        radius = wp.array(reach, dtype=wp.float64, device=device)
        density, condition = (wp.zeros(n, dtype=wp.float64, device=device) for _ in range(2))
        outputs = [self.bond, self.weight, self._inverse_shape, density, condition]
        wp.launch(self._kernels.shapes, n, [self.start, self.index, reference, radius], outputs, device=device)
        flat = np.flatnonzero(condition.numpy() <= FLAT)
        if len(flat):
            body = scene.bodies[particles.bodies[flat[0]]]
            at = ", ".join(f"{c:.6g}" for c in particles.positions[flat[0]])
            reason = (
                f"leaves the body one particle thick at ({at}) m; the hamiltonian model needs two, springs does not"
            )
            raise InputError(place(body, "body"), "spacing", reason)
        return density.numpy()

    def _stress_fields(self) -> StressFields:
        constants, types = self.constants(), self._types
        return stress_fields(self.gradient, constants, self.dilatation.stress, types=types, device=self._device)

    def _end_at_clamps(
        self,
        scene: Scene,
        particles: Particles,
        volume: np.ndarray,
        stiffness: np.ndarray,
        averaged: np.ndarray,
    ) -> None:
        """End the pairs at the faces of clamps; next to them a part of the volume and of the control is left.

        Held particles take no part in mean dilatations, for which all volumes are the same.
        """
        start, index = self.start.numpy(), self.index.numpy()
        faces = clamp_faces(scene, particles, start, index)
        if faces is not None:
            end_pairs_at_faces(faces, start, index, self.bond, self.weight, self._inverse_shape)
            volume[faces.next_to] *= faces.share
            stiffness[faces.next_to] *= faces.share * faces.doubling
            averaged[faces.next_to] = 0.0

    def _launch_stress(self, state: ElasticState, first: int, count: int) -> None:
        pairs = [first, self.start, self.index, self.bond, self.weight]
        inputs = [*pairs, self._inverse_shape, self._volume, self.kappa, *self.constants()]
        inputs += [int(self.dilatation.acts), state.u]
        outputs = [self.gradient, self.dilatation.dilatation, self.resistance, self.pull, self.inverted]
        wp.launch(self._kernels.stress, count, inputs, outputs, device=self._device)

    def _launch_mean(self, state: ElasticState, first: int, count: int) -> None:
        self.dilatation.average(self.dilatation.dilatation, self.dilatation.mean, first, count)

    def _launch_gather(self, state: ElasticState, first: int, count: int) -> None:
        mean = self.dilatation
        mean.gather(self.gradient, mean.mean, mean.stress, self.pull, first, count)

    def _launch_force(self, state: ElasticState, first: int, count: int) -> None:
        inputs = [first, self.start, self.index, self.bond, self.weight, state.u, self.resistance, self.pull]
        wp.launch(self._kernels.force, count, inputs, [state.force], device=self._device)


def _nearest_rotors(f: np.ndarray) -> np.ndarray:
    """Unit quaternions of the rotation in the polar decomposition of each F, shape [n, 4].

    It is the R with the largest R : F, a quadratic form of the quaternion; its best one is an eigenvector, as exact for
    half a turn as for none.
    """
    trace = np.trace(f, axis1=1, axis2=2)
    form = np.empty((len(f), 4, 4))
    form[:, 0, 0] = trace
    form[:, 0, 1:] = np.stack((f[:, 2, 1] - f[:, 1, 2], f[:, 0, 2] - f[:, 2, 0], f[:, 1, 0] - f[:, 0, 1]), axis=1)
    form[:, 1:, 0] = form[:, 0, 1:]
    form[:, 1:, 1:] = f + np.swapaxes(f, 1, 2) - trace[:, None, None] * np.eye(3)
    _, vectors = np.linalg.eigh(form)
    return vectors[:, :, -1]

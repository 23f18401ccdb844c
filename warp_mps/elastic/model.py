"""The constants of the spring model for a given set of particles, and the launches that use them."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.core.neighbours import reference_neighbours
from warp_mps.core.weights import lattice_number_density, weight
from warp_mps.elastic.material import lame_constants
from warp_mps.elastic.springs import spring_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles import Particles
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
        number_density: What the operators of each particle are normalized by, n0 or n_i [-], shape [n].
    """

    def __init__(self, scene: Scene, particles: Particles, *, kit: Kit, device: Any) -> None:
        self.kernels = spring_kernels(kit)
        self.device = device
        d = particles.dimension
        radius = scene.elasticity.effective_radius * particles.spacings
        start, index = reference_neighbours(particles.positions, particles.groups, radius, device=device)
        i = np.repeat(np.arange(particles.count), np.diff(start))
        bond = particles.positions[index] - particles.positions[i]
        length = np.linalg.norm(bond, axis=1)
        w = weight(length, radius[i])
        n = np.full(particles.count, lattice_number_density(d, scene.elasticity.effective_radius))
        if scene.elasticity.normalization == "particle":
            n = np.maximum(np.bincount(i, w, particles.count), 1e-12)
        lame = np.array([lame_constants(body.material, d, scene.plane) for body in scene.bodies])[particles.bodies]
        volume = particles.spacings**d
        # springs of two materials in series: the harmonic mean
        mu = 2.0 / (1.0 / lame[i, 1] + 1.0 / lame[index, 1])
        stiffness = volume[i] * 4.0 * d * mu * w / length**2 * 0.5 * (1.0 / n[i] + 1.0 / n[index])
        self.number_density = n
        self.volume = volume
        self.start = wp.array(start, dtype=wp.int32, device=device)
        self.index = wp.array(index, dtype=wp.int32, device=device)
        self.bond = wp.array(bond, dtype=kit.vec, device=device)
        self.area = wp.array(d * w / length, dtype=kit.real, device=device)
        self.stiffness = wp.array(stiffness, dtype=kit.real, device=device)
        self.bulk = wp.array(volume * lame[:, 0] / n**2, dtype=kit.real, device=device)

    def launch_pressure(self, state: ElasticState, first: int, count: int) -> None:
        """Volume change of `count` particles from `first` on."""
        inputs = [first, self.start, self.index, self.bond, self.area, self.bulk, state.u, state.q]
        wp.launch(self.kernels.pressure, count, inputs, [state.pressure], device=self.device)

    def launch_force(self, state: ElasticState, first: int, count: int) -> None:
        """Elastic force and torque of `count` particles from `first` on."""
        inputs = [first, self.start, self.index, self.bond, self.area, self.stiffness, state.u, state.q, state.pressure]
        wp.launch(self.kernels.force, count, inputs, [state.force, state.torque], device=self.device)

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Elastic energy of every particle [J]."""
        inputs = [self.start, self.index, self.bond, self.area, self.stiffness, self.bulk, state.u, state.q]
        wp.launch(self.kernels.energy, len(state.u), inputs, [energy_out], device=self.device)

    def pressures(self, state: ElasticState) -> np.ndarray:
        """Pressure p_i = -lambda (div u)_i of each particle (eq. 14) [Pa], shape [n]."""
        return -state.pressure.numpy().astype(float) * self.number_density / self.volume

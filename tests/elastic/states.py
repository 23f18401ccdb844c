"""Models and a state of their particles, without a simulation around them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from tests.core.rotors import matrices_of, rotors_of
from tests.scenes import random
from warp_mps.core.device import open_device
from warp_mps.core.rotation import identity_rotors
from warp_mps.core.types import numeric_types
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.springs.model import SpringModel
from warp_mps.elastic.state import ElasticState, initial_state
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


@dataclass(frozen=True)
class Held:
    """A model with its state, whose particles are placed by the test."""

    particles: Particles
    model: SpringModel
    state: ElasticState

    def put(self, displacements: np.ndarray, rotors: np.ndarray | None = None) -> Held:
        """Displace and rotate the particles."""
        self.state.u.assign(displacements.astype(self.state.u.numpy().dtype))
        if rotors is None:
            rotors = identity_rotors(self.particles.count, self.particles.dimension)
        self.model.rotation.q.assign(rotors.astype(self.model.rotation.q.numpy().dtype))
        return self

    def loads(self) -> tuple[np.ndarray, np.ndarray]:
        """Elastic forces [N], shape [n, d], and torques [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        for _, launch in self.model.passes:
            launch(self.state, 0, self.particles.count)
        return self.state.force.numpy().astype(float), self.model.rotation.torque.numpy().astype(float)

    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""
        self.loads()
        return self.model.pressures()

    def energy(self) -> float:
        """Elastic energy [J]."""
        energies = wp.zeros_like(self.model.pressure)
        self.model.launch_energy(self.state, energies)
        return float(energies.numpy().astype(float).sum())


def hold(scene: Scene, precision: str = "float64") -> Held:
    """The model of a scene on the CPU, at rest."""
    device: Any = open_device("cpu")
    numbers = numeric_types(scene.dimension, precision)
    particles = fill_scene(scene)
    model = SpringModel(scene, particles, np.zeros(particles.count, bool), types=numbers, device=device)
    return Held(particles, model, initial_state(particles, types=numbers, device=device))


def random_state(particles: Particles, *, size: float = 0.1, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of up to `size` spacings on top of a large common rotation, and rotors near that rotation."""
    n, d = particles.positions.shape
    common = np.array([1.3]) if d == 2 else np.array([0.4, -0.9, 0.7])
    displacements = rigid_displacement(particles, common) + size * particles.spacings[:, None] * random(n, d, seed=seed)
    return displacements, rotors_of(common + size * random(n, 2 * d - 3, seed=seed + 1))


def rigid_displacement(particles: Particles, rotation: np.ndarray, shift: float = 0.0) -> np.ndarray:
    """Displacements of a rotation about the origin [rad] and a shift of every component [m], shape [n, d]."""
    matrix = matrices_of(rotors_of(rotation[None]))[0]
    return particles.positions @ matrix.T - particles.positions + shift


@dataclass(frozen=True)
class Strained:
    """A Hamiltonian model with its state, whose particles are placed by the test."""

    particles: Particles
    model: HamiltonianModel
    state: ElasticState
    number: Any

    def put(self, displacements: np.ndarray) -> Strained:
        """Displace the particles, and evaluate the forces."""
        self.state.u.assign(displacements.astype(self.state.u.numpy().dtype))
        for _, launch in self.model.passes:
            launch(self.state, 0, self.particles.count)
        return self

    @property
    def forces(self) -> np.ndarray:
        """Elastic forces [N], shape [n, d]."""
        return self.state.force.numpy().astype(float)

    @property
    def gradients(self) -> np.ndarray:
        """Displacement gradients H [-], shape [n, d, d]."""
        return self.model.gradient.numpy().astype(float)

    @property
    def energy(self) -> float:
        """Elastic energy [J]."""
        energies = wp.zeros(self.particles.count, dtype=self.number)
        self.model.launch_energy(self.state, energies)
        return float(energies.numpy().astype(float).sum())


def strain(scene: Scene, precision: str = "float64") -> Strained:
    """The Hamiltonian model of a scene on the CPU, at rest."""
    device: Any = open_device("cpu")
    numbers = numeric_types(scene.dimension, precision)
    particles = fill_scene(scene)
    model = HamiltonianModel(scene, particles, types=numbers, device=device)
    return Strained(particles, model, initial_state(particles, types=numbers, device=device), numbers.real)

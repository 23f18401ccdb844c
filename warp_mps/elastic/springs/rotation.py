"""Particles' own rotation, for a model that has one: its state, and its part of a step (eq. 4)."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.rotation import identity_rotors
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.springs.rotation_kernels import rotation_kernels
from warp_mps.particles.particles import Particles

EVOLVING = ("q", "omega", "torque")


class ParticleRotation:
    """Rotation of the particles on a device.

    Attributes:
        q: Rotation, see `warp_mps.core.rotation`, rotor [n].
        omega: Angular velocity [rad/s], axial [n].
        torque: Torque [N m], axial [n].
    """

    def __init__(self, particles: Particles, held: np.ndarray, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device, self._n = rotation_kernels(types), device, particles.count
        # a square or cube of side l0
        inertia = particles.masses * particles.spacings**2 / 6.0
        omega = np.where(held[:, None], 0.0, particles.angular_velocities)
        self.q = wp.array(identity_rotors(self._n, types.dimension), dtype=types.rotor, device=device)
        self.omega = wp.array(omega, dtype=types.axial, device=device)
        self.torque = wp.zeros(self._n, dtype=types.axial, device=device)
        self._inertia = wp.array(inertia, dtype=types.real, device=device)
        self._inverse_inertia = wp.array(np.where(held, 0.0, 1.0 / inertia), dtype=types.real, device=device)

    def drift(self, dt: float, first: int, count: int) -> None:
        """Half a kick with the torques of the last step, then the rotation by omega dt."""
        inputs = [first, dt, self._inverse_inertia, self.torque]
        wp.launch(self._kernels.drift, count, inputs, [self.q, self.omega], device=self._device)

    def kick(self, dt: float, first: int, count: int) -> None:
        """The second half of the kick."""
        inputs = [first, dt, self._inverse_inertia, self.torque]
        wp.launch(self._kernels.kick, count, inputs, [self.omega], device=self._device)

    def damp(self, factor: float, dissipated: wp.array) -> None:
        """Multiply the angular velocities by a factor, and add the energy loss to the dissipated energy."""
        inputs = [factor, self._inertia, self._inverse_inertia]
        wp.launch(self._kernels.damp, self._n, inputs, [self.omega, dissipated], device=self._device)

    def add_kinetic(self, kinetic_out: wp.array) -> None:
        """Add the kinetic energy of the rotation of each particle [J]."""
        wp.launch(self._kernels.add_kinetic, self._n, [self._inertia, self.omega], [kinetic_out], device=self._device)

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [getattr(self, name) for name in EVOLVING]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        return {name: getattr(self, name).numpy().copy() for name in EVOLVING}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for name in EVOLVING:
            getattr(self, name).assign(arrays[name])

"""The elastic bodies of a scene on a device: one step of them, and what can be asked of them."""

from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.core.neighbours import METHOD as NEIGHBOURS
from warp_mps.core.neighbours import neighbour_kernels
from warp_mps.elastic.contact import contact_kernels
from warp_mps.elastic.contacts import Contacts, needs_contact
from warp_mps.elastic.energies import CHUNK, energy_kernels
from warp_mps.elastic.loads import METHOD, load_kernels
from warp_mps.elastic.model import SpringModel
from warp_mps.elastic.motion import motion_kernels
from warp_mps.elastic.outside import Outside
from warp_mps.elastic.springs import spring_kernels
from warp_mps.elastic.state import ElasticState, initial_state
from warp_mps.energy import Energy
from warp_mps.particles import Particles
from warp_mps.scene import Scene


def declare_kernels(kit: Kit) -> list[str]:
    """Declare every kernel of a kit, so that each module is compiled once, and return the modules' names."""
    for declare in (spring_kernels, motion_kernels, load_kernels, contact_kernels, energy_kernels):
        declare(kit)
    # the reference neighbours are searched in double precision whatever the run's
    double = replace(kit, precision="float64")
    neighbour_kernels(double)
    return [kit.module(METHOD), double.module(NEIGHBOURS)]


class Solid:
    """The elastic bodies of a scene: constants, state, and the launches of a step.

    A step is the same Python whether it is run eagerly or captured: it reads nothing back and allocates nothing.
    """

    def __init__(self, scene: Scene, particles: Particles, *, dt: float, kit: Kit, device: Any) -> None:
        self._kit, self._device, self._dt = kit, device, dt
        self._n, d = particles.count, particles.dimension
        self._motion, self._sums = motion_kernels(kit), energy_kernels(kit)
        self.state: ElasticState = initial_state(particles, kit=kit, device=device)
        self.model = SpringModel(scene, particles, kit=kit, device=device)
        self.outside = Outside(scene, particles, dt=dt, kit=kit, device=device)
        self.contacts = Contacts(scene, particles, kit=kit, device=device) if needs_contact(scene, particles) else None
        self._masses = particles.masses
        self._damping = scene.damping
        self._gravity = kit.vec(*scene.gravity) if len(scene.gravity) else kit.vec()
        # a square or cube of side l0 (eq. 4)
        inertia = particles.masses * particles.spacings**2 / 6.0
        free = ~self.outside.held

        def real(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=kit.real, device=device)

        self._mass, self._inertia = real(particles.masses), real(inertia)
        self._inverse_mass = wp.array(free / particles.masses[:, None], dtype=kit.vec, device=device)
        self._inverse_inertia = real(np.where(self.outside.held_rotation, 0.0, 1.0 / inertia))
        self._reference = wp.array(particles.positions, dtype=kit.vec, device=device)
        self._values = wp.zeros((4, self._n), dtype=kit.real, device=device)
        self._chunks = wp.zeros((4, -(-self._n // CHUNK)), dtype=wp.float64, device=device)
        self._hold_still(particles, d)

    def start(self) -> None:
        """Evaluate the forces of the initial state, which the first step begins with."""
        self.outside.drive(self.state)
        if self.contacts:
            self.contacts.renew(self.state)
        self._forces()
        self._kick(0.0)
        self.outside.account(self.state, self._mass, 0.0)

    def step(self) -> None:
        """Advance by one time step."""
        state, dt, n = self.state, self._dt, self._n
        self._damp()
        inputs = [0, dt, self._inverse_mass, self._inverse_inertia, state.force, state.torque]
        outputs = [state.u, state.v, state.q, state.omega]
        wp.launch(self._motion.drift, n, inputs, outputs, device=self._device)
        if self.outside.moving:
            wp.launch(self._motion.tick, 1, [self.outside.steps], device=self._device)
            self.outside.drive(state)
        if self.contacts:
            self.contacts.locate(state)
        self._forces()
        self._kick(dt)
        self.outside.account(state, self._mass, dt)
        self._damp()

    def energy(self) -> Energy:
        """Energies of the present state."""
        state, values = self.state, self._values
        inputs = [self._gravity, self._reference, self._mass, self._inertia, state.u, state.v, state.omega]
        wp.launch(self._sums.particle_energies, self._n, inputs, [values[0], values[1]], device=self._device)
        self.model.launch_energy(state, values[2])
        if self.contacts:
            self.contacts.launch_energy(state, values[3])
        for k in range(4):
            sums = self._chunks[k]
            wp.launch(self._sums.chunk_sums, len(sums), [values[k]], [sums], device=self._device)
        kinetic, potential, elastic, contact = self._chunks.numpy().sum(axis=1)
        return Energy(
            kinetic=float(kinetic),
            elastic=float(elastic),
            contact=float(contact),
            potential=float(potential),
            work=self.outside.work(),
            dissipated=float(np.sum(state.dissipated.numpy().astype(float))),
        )

    def reactions(self) -> np.ndarray:
        """Force that the supports exert on each particle: m a - f on the held axes [N], shape [n, d]."""
        inertial = self._masses[:, None] * self.state.driven.numpy()
        return np.where(self.outside.held, inertial - self.state.force.numpy(), 0.0)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        return {**self.state.arrays(), **self.outside.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.state.assign(arrays)
        self.outside.assign(arrays)
        if self.contacts:
            self.contacts.renew(self.state)

    def _forces(self) -> None:
        self.model.launch_pressure(self.state, 0, self._n)
        self.model.launch_force(self.state, 0, self._n)
        if self.contacts:
            self.contacts.launch_force(self.state)
        self.outside.push(self.state, self._mass)

    def _kick(self, dt: float) -> None:
        state = self.state
        constants = [self._gravity, self._mass, self._inverse_mass, self._inverse_inertia]
        inputs = [0, dt, *constants, state.torque]
        outputs = [state.force, state.v, state.omega]
        wp.launch(self._motion.kick, self._n, inputs, outputs, device=self._device)

    def _damp(self) -> None:
        if not self._damping:
            return
        factor = float(np.exp(-0.5 * self._damping * self._dt))
        state = self.state
        inputs = [factor, self._mass, self._inertia, self._inverse_mass, self._inverse_inertia]
        outputs = [state.v, state.omega, state.dissipated]
        wp.launch(self._motion.damp, self._n, inputs, outputs, device=self._device)

    def _hold_still(self, particles: Particles, dimension: int) -> None:
        """Held particles start at rest; moving supports set their own velocity."""
        velocities = np.where(self.outside.held, 0.0, particles.velocities)
        spins = np.where(self.outside.held_rotation[:, None], 0.0, particles.angular_velocities)
        self.state.v.assign(velocities.astype(self.state.v.numpy().dtype))
        self.state.omega.assign(spins.astype(self.state.omega.numpy().dtype))

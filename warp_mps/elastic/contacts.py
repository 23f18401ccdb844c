"""Contact on a given set of particles: its grid, its candidate list and the launches that use them."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.core.neighbours import make_grid
from warp_mps.core.weights import REACH_TOLERANCE
from warp_mps.elastic.contact import CANDIDATES, SKIN, contact_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles import Particles
from warp_mps.scene import Scene


def needs_contact(scene: Scene, particles: Particles) -> bool:
    """Whether any two particles could ever come into contact."""
    several = len(np.unique(particles.groups)) > 1
    return scene.contact.between == "all" or (scene.contact.between == "bodies" and several)


class Contacts:
    """Contact between the particles of a scene."""

    def __init__(self, scene: Scene, particles: Particles, *, kit: Kit, device: Any) -> None:
        self._kernels, self._device = contact_kernels(kit), device
        n, d = particles.count, particles.dimension
        # of the smallest, or a coarse body would list more particles of a fine one than it has room for
        self._margin = SKIN * float(particles.spacings.min())
        self._reach = float(particles.spacings.max()) + self._margin
        self._within = int(scene.contact.between == "all")
        # walls are rigid, so that a pair has the body's stiffness, and are all neighbours: they do not touch each other
        youngs = [body.material.youngs_modulus for body in scene.bodies] + [np.inf] * len(scene.walls)
        youngs = np.array(youngs)[particles.bodies]
        radius = scene.elasticity.effective_radius * particles.spacings * REACH_TOLERANCE
        radius[particles.elastic :] = np.inf

        def real(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=kit.real, device=device)

        self._reference = wp.array(particles.positions, dtype=kit.vec, device=device)
        self._spacing = real(particles.spacings)
        self._stiffness = real(scene.contact.stiffness * youngs * particles.spacings ** (d - 2))
        self._radius = real(radius)
        self._group = wp.array(particles.groups, dtype=wp.int32, device=device)
        self._points = wp.zeros(n, dtype=kit.vec3, device=device)
        self._u_listed = wp.zeros(n, dtype=kit.vec, device=device)
        self._listed = wp.zeros((n, CANDIDATES[d]), dtype=wp.int32, device=device)
        self._count = wp.zeros(n, dtype=wp.int32, device=device)
        self._stale = wp.zeros(1, dtype=wp.int32, device=device)
        self._overflow = wp.zeros(1, dtype=wp.int32, device=device)
        extent = particles.positions.max(axis=0) - particles.positions.min(axis=0)
        self._grid = make_grid(extent, self._reach, kit=kit, device=device)
        self._grid.reserve(n)

    def renew(self, state: ElasticState) -> None:
        """List the candidates at the present positions, whether or not the list is stale; forget an overflow before."""
        self._overflow.zero_()
        self._stale.fill_(1)
        self.locate(state)

    def locate(self, state: ElasticState) -> None:
        """Renew the list of candidates if a particle has moved far enough since it was made."""
        inputs = [self._reference, self._margin, state.u, self._u_listed]
        wp.launch(self._kernels.locate, len(state.u), inputs, [self._points, self._stale], device=self._device)
        wp.capture_if(self._stale, self._list, state=state)

    def launch_force(self, state: ElasticState) -> None:
        """Add the contact forces."""
        inputs = [*self._constants(), state.u]
        wp.launch(self._kernels.force, len(state.u), inputs, [state.contact, state.force], device=self._device)

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Contact energy of every particle [J]."""
        inputs = [*self._constants(), state.u]
        wp.launch(self._kernels.energy, len(state.u), inputs, [energy_out], device=self._device)

    def overflowed(self) -> int | None:
        """A particle that has met more others than the list holds, if there was one."""
        particle = int(self._overflow.numpy()[0])
        return particle - 1 if particle else None

    def _constants(self) -> list[wp.array]:
        return [self._reference, self._spacing, self._stiffness, self._listed, self._count]

    def _list(self, state: ElasticState) -> None:
        self._grid.build(self._points, self._reach)
        search = [self._grid.id, self._reach, self._margin, self._spacing]
        inputs = [*search, self._reference, self._group, self._radius, self._within]
        outputs = [self._listed, self._count, self._u_listed, self._stale, self._overflow]
        n = len(state.u)
        wp.launch(self._kernels.candidates, n, [*inputs, self._points, state.u], outputs, device=self._device)

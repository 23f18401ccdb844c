"""Friction on a given set of particles: what grips what, and the launches that use it."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.contact.friction_kernels import friction_kernels
from warp_mps.elastic.contact.kernels import PARTICLES_PER_THREAD
from warp_mps.elastic.contact.search_kernels import FACES
from warp_mps.elastic.state import ElasticState


class Friction:
    """Friction between the particles of a contact.

    Args:
        count: Number of particles.
        hold: Stiffness of sticking faces per Young's modulus, shape [groups, groups].
        friction: Coefficients of friction, shape [groups, groups].
        types: Number types.
        device: Warp device.
    """

    def __init__(self, count: int, hold: np.ndarray, friction: np.ndarray, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device = friction_kernels(types), device
        self._per_thread = PARTICLES_PER_THREAD["cpu" if wp.get_device(device).is_cpu else "cuda"]
        self._threads = -(-count // self._per_thread)
        self._hold = wp.array(hold, dtype=types.real, device=device)
        self._friction = wp.array(friction, dtype=types.real, device=device)

        def zeros(shape: int | tuple[int, int], dtype: Any) -> wp.array:
            return wp.zeros(shape, dtype=dtype, device=device)

        # what evolves: which groups are gripped, their slips, and force and energy of the last step
        self._gripped, self._slip = zeros((count, FACES), wp.int32), zeros((count, FACES), types.vec)
        self._rubbed, self._stored_before = zeros(count, types.vec), zeros(count, types.real)
        self._stored = zeros(count, types.real)
        self._pull, self._mean = zeros((count, FACES), types.vec), zeros((count, FACES), types.real)
        self._u_before = zeros(count, types.vec)

    def initialize(self, state: ElasticState) -> None:
        """Begin at the present positions."""
        wp.copy(self._u_before, state.u)

    def launch(
        self,
        state: ElasticState,
        places: list[wp.array],
        stiffness: list[wp.array],
        candidates: list[wp.array],
        push: wp.array,
    ) -> None:
        """Add the friction of a step to its contact forces, once a step: slips grow by the step's move."""
        moved = [state.u, self._u_before]
        inputs = [self._per_thread, *places, *stiffness, self._hold, self._friction, *candidates, *moved, push]
        outputs = [self._gripped, self._slip, self._pull, self._mean, self._stored]
        wp.launch(self._kernels.grip, self._threads, inputs, outputs, device=self._device)
        inputs = [self._per_thread, *places, *candidates, state.u, self._pull, self._mean, self._stored]
        outputs = [self._u_before, self._stored_before, self._rubbed, state.contact, state.force, state.dissipated]
        wp.launch(self._kernels.rub, self._threads, inputs, outputs, device=self._device)

    def add_energy(self, energy: wp.array) -> None:
        """Add what sticking faces store [J]."""
        wp.launch(self._kernels.add, len(energy), [self._stored_before], [energy], device=self._device)

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [*self._evolving().values(), self._u_before]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        return {name: array.numpy().copy() for name, array in self._evolving().items()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Take over arrays that `arrays` gave."""
        for name, array in self._evolving().items():
            array.assign(arrays[name])

    def _evolving(self) -> dict[str, wp.array]:
        return {
            "gripped": self._gripped,
            "slip": self._slip,
            "rubbed": self._rubbed,
            "slip_energy": self._stored_before,
        }

"""Friction on a given set of particles: its constants, its slips, and the launches that use them."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.counters import require_within
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.contact.friction_kernels import friction_kernels
from warp_mps.elastic.contact.kernels import PARTICLES_PER_THREAD
from warp_mps.elastic.contact.search_kernels import FACES
from warp_mps.elastic.state import ElasticState


class Friction:
    """Friction between the particles of a contact.

    Args:
        count: Number of particles.
        spring_stiffness: Stiffness of sticking faces over Young's modulus [m^(d-2)], shape [groups, groups].
        friction: Coefficients of friction, shape [groups, groups].
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self, count: int, spring_stiffness: np.ndarray, friction: np.ndarray, *, types: NumericTypes, device: Any
    ) -> None:
        self._kernels, self._device = friction_kernels(types), device
        self._per_thread = PARTICLES_PER_THREAD["cpu" if wp.get_device(device).is_cpu else "cuda"]
        self._threads = -(-count // self._per_thread)
        self._spring_stiffness = wp.array(spring_stiffness, dtype=types.real, device=device)
        self._friction = wp.array(friction, dtype=types.real, device=device)

        def zeros(shape: int | tuple[int, int], dtype: Any) -> wp.array:
            return wp.zeros(shape, dtype=dtype, device=device)

        # state: the groups in friction with each particle, their slips, and force and energy of the last step
        self._slip_group, self._slip = zeros((count, FACES), wp.int32), zeros((count, FACES), types.vec)
        self._friction_before, self._stored_before = zeros(count, types.vec), zeros(count, types.real)
        self._stored = zeros(count, types.real)
        self._pull, self._mean = zeros((count, FACES), types.vec), zeros((count, FACES), types.real)
        self._u_before = zeros(count, types.vec)

    def initialize(self, state: ElasticState) -> None:
        """Measure slips from the present positions on."""
        wp.copy(self._u_before, state.u)

    def launch(
        self,
        state: ElasticState,
        places: list[wp.array],
        stiffness: list[wp.array],
        candidates: list[wp.array],
        slope: wp.array,
    ) -> None:
        """Add the friction of a step to its contact forces, once a step: slips grow by the step's move."""
        moved = [state.u, self._u_before]
        inputs = [
            self._per_thread,
            *places,
            *stiffness,
            self._spring_stiffness,
            self._friction,
            *candidates,
            *moved,
            slope,
        ]
        outputs = [self._slip_group, self._slip, self._pull, self._mean, self._stored]
        wp.launch(self._kernels.update_slip, self._threads, inputs, outputs, device=self._device)
        inputs = [self._per_thread, *places, *candidates, state.u, self._pull, self._mean, self._stored]
        outputs = [
            self._u_before,
            self._stored_before,
            self._friction_before,
            state.contact,
            state.force,
            state.dissipated,
        ]
        wp.launch(self._kernels.add_friction, self._threads, inputs, outputs, device=self._device)

    def add_energy(self, energy: wp.array) -> None:
        """Add the energy that the springs of sticking faces store [J]."""
        wp.launch(self._kernels.add_stored_energy, len(energy), [self._stored_before], [energy], device=self._device)

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [*self._evolving().values(), self._u_before]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        return {name: array.numpy().copy() for name, array in self._evolving().items()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: A slip belongs to a group that there is not.
        """
        require_within("gripped", arrays["gripped"], self._friction.shape[0])
        for name, array in self._evolving().items():
            array.assign(arrays[name])

    def _evolving(self) -> dict[str, wp.array]:
        return {
            "gripped": self._slip_group,
            "slip": self._slip,
            "rubbed": self._friction_before,
            "slip_energy": self._stored_before,
        }

"""The body forces of a scene on its elastic bodies: forces that depend on place and time, and their work."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.body_forces import BodyForces
from warp_mps.core.device import load_modules
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.boundary.body_force_kernels import METHOD, body_force_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


def make_body_forces(
    scene: Scene, particles: Particles, mass: wp.array, *, types: NumericTypes, device: Any
) -> "ElasticBodyForces | None":
    """The body forces on the elastic bodies of a scene, or None if none acts on them."""
    rows = np.array([_rows(force.acts_on, particles) for force in scene.body_forces])
    return ElasticBodyForces(scene, particles, rows, mass, types=types, device=device) if rows.any() else None


class ElasticBodyForces:
    """Body forces on n elastic particles.

    Attributes:
        force: At their last evaluation [N], vec [n].

    Args:
        scene: The case.
        particles: Its particles.
        rows: Whether each body force acts on each of the particles, shape [forces, n].
        mass: Masses [kg], real, of at least n particles.
        types: Number types.
        device: Warp device.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        rows: np.ndarray,
        mass: wp.array,
        *,
        types: NumericTypes,
        device: Any,
    ) -> None:
        self._count, self._device, self._mass = rows.shape[1], device, mass
        self._kernels = body_force_kernels(types)
        load_modules([types.module(METHOD)], device)
        self._forces = BodyForces(scene.body_forces, rows, types=types, device=device)
        self._reference = wp.array(particles.positions[: self._count], dtype=types.vec, device=device)
        self._x, self.force = (wp.zeros(self._count, dtype=types.vec, device=device) for _ in range(2))
        self._power, self._work = (wp.zeros(self._count, dtype=wp.float64, device=device) for _ in range(2))
        self._time = wp.zeros(1, dtype=wp.float64, device=device)

    @property
    def on_host(self) -> bool:
        """Whether any function is one of Python, which no graph can hold."""
        return self._forces.on_host

    def evaluate(self, state: ElasticState, time: float, ahead: float = 0.0) -> None:
        """Evaluate the Python functions, if any, at a time [s], at the places x + ahead v."""
        if self.on_host:
            x = self._reference.numpy() + state.u.numpy()[: self._count]
            self._forces.evaluate(x + ahead * state.v.numpy()[: self._count], time)

    def launch(self, state: ElasticState, steps: wp.array, dt: float, total: wp.array) -> None:
        """Launch the forces at the time of so many steps of dt [s], added to the total forces [N]."""
        self._launch(self._kernels.elapsed_time, [dt, steps], [self._time], count=1)
        self._add(state, 0.0, total)

    def apply(self, state: ElasticState, time: float, total: wp.array, *, ahead: float = 0.0) -> None:
        """Add the forces at a time [s], at the places x + ahead v, to the total forces [N]; not for a graph."""
        self.evaluate(state, time, ahead)
        self._time.fill_(time)
        self._add(state, ahead, total)

    def add_work(self, v: wp.array, dt: float) -> None:
        """Launch the work of a step of dt [s], or of none at the start, where dt is 0."""
        self._launch(self._kernels.add_work, [dt, self.force, v], [self._power, self._work])

    def work(self) -> float:
        """Work of explicit steps so far [J]; implicit ones count that of all loads together."""
        return float(np.sum(self._work.numpy()))

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [self.force, self._power, self._work]

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        return {name: array.numpy().copy() for name, array in self._named().items()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for name, array in self._named().items():
            array.assign(arrays[name])

    def _named(self) -> dict[str, wp.array]:
        return {"body_force": self.force, "body_force_power": self._power, "body_force_work": self._work}

    def _add(self, state: ElasticState, ahead: float, total: wp.array) -> None:
        self._launch(self._kernels.locate, [self._reference, ahead, state.u, state.v], [self._x])
        self._forces.launch(self._x, self._time)
        self._launch(self._kernels.weigh, [self._mass, self._forces.accelerations], [total, self.force])

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], count: int | None = None) -> None:
        wp.launch(kernel, self._count if count is None else count, inputs, outputs, device=self._device)


def _rows(names: tuple[str, ...], particles: Particles) -> np.ndarray:
    """Whether each elastic particle belongs to one of the named bodies (to any, without names), shape [n]."""
    acts = np.full(particles.elastic, not names)
    for name, (first, last) in zip(particles.names, particles.ranges, strict=True):
        if name in names:
            acts[first:last] = True
    return acts

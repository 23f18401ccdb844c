"""Rigid walls among the elastic particles: they move as prescribed, and act by contact alone."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene
from warp_mps.walls.kernels import wall_kernels
from warp_mps.walls.poses import Poses, moving_runs


class Walls:
    """The walls of a scene in the elastic state: its last particles, without mass, moving or at rest.

    Attributes:
        moving: Whether any wall moves.
    """

    def __init__(self, scene: Scene, particles: Particles, *, dt: float, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device, self._dt = wall_kernels(types), device, dt
        self._first, self._count = particles.elastic, particles.count - particles.elastic
        self._poses = Poses(scene, types=types, device=device)
        self._runs = moving_runs(scene, particles)
        self.moving = bool(self._runs)
        self._time = wp.zeros(1, dtype=wp.float64, device=device)
        self._of_wall = particles.walls[particles.elastic :]
        self._wall = wp.array(particles.walls, dtype=wp.int32, device=device)
        self._reference = wp.array(particles.positions, dtype=self._poses.vec64, device=device)
        self._move = wp.zeros(self._count, dtype=types.vec, device=device)
        self._work = wp.zeros(self._count, dtype=wp.float64, device=device)

    def move(self, state: ElasticState, steps: wp.array) -> None:
        """Move the walls to their poses at the time of the step."""
        if self.moving:
            self.locate(steps)
        for first, count in self._runs:
            inputs = [first, self._first, self._wall, self._reference, *self._poses.arrays(), state.contact]
            outputs = [state.u, state.v, state.driven, self._move, self._work]
            wp.launch(self._kernels.move_walls, count, inputs, outputs, device=self._device)

    def locate(self, steps: wp.array) -> None:
        """Evaluate the poses of the walls after a number of steps, without moving particles."""
        wp.launch(self._kernels.clock, 1, [steps, self._dt], [self._time], device=self._device)
        self._poses.evaluate(self._time)

    def clear_forces(self, state: ElasticState) -> None:
        """Set the forces on the walls to 0, before contact adds those of the step."""
        wp.launch(self._kernels.clear_forces, self._count, [self._first], [state.force], device=self._device)

    def add_work(self, state: ElasticState) -> None:
        """Add the second half of the work of a step."""
        for first, count in self._runs:
            inputs = [first, self._first, state.contact, self._move]
            wp.launch(self._kernels.wall_work, count, inputs, [self._work], device=self._device)

    def work(self) -> float:
        """Work of the walls on the bodies so far [J]."""
        return float(np.sum(self._work.numpy()))

    def turns(self) -> tuple[np.ndarray, np.ndarray]:
        """Rotation vectors [rad] and angular velocities [rad/s] of the wall particles."""
        rotations, velocities = self._poses.turns()
        return rotations[self._of_wall], velocities[self._of_wall]

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [self._work]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name; the poses of the walls follow from the time."""
        return {"wall_work": self._work.numpy().copy()}

    def assign(self, arrays: dict[str, np.ndarray], steps: wp.array) -> None:
        """Continue from arrays that `arrays` gave."""
        self._work.assign(arrays["wall_work"])
        self.locate(steps)

"""Prescribed motion of the walls that fluids are between."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.state import FluidState
from warp_mps.scene import Scene
from warp_mps.walls.poses import Poses, moving_runs


class WallMotion:
    """Places the particles of moving walls at a time.

    Args:
        scene: The case.
        model: Constants of the run.
        state: State of the fluid.
    """

    def __init__(self, scene: Scene, model: FluidModel, state: FluidState) -> None:
        particles, types, device = model.particles, model.types, model.device
        self._particles, self._state, self._walls = particles, state, model.walls
        self._poses = Poses(scene, types=types, device=device) if scene.walls else None
        self._runs = moving_runs(scene, particles)
        self._wall = wp.array(particles.walls, dtype=wp.int32, device=device)
        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        # velocities at the midpoint of a step, of no use
        self._unused = wp.zeros_like(state.u)
        self._reference = wp.array(particles.positions, dtype=vec64, device=device)

    def place(self, time: wp.array) -> None:
        """Launch positions, velocities and accelerations of moving walls at a time [s], float64 [1]."""
        self._place(time, self._state.u)

    def place_midway(self, middle: wp.array, end: wp.array) -> None:
        """Launch what the pressure needs at the midpoint of a step: positions and accelerations of moving walls there.

        The velocities are those at the end of the step, which those of the fluid are made to match.

        Args:
            middle: Time at the midpoint [s], float64 [1].
            end: Time at the end of the step [s], float64 [1].
        """
        self._place(end, self._state.u)
        self._place(middle, self._unused)

    def _place(self, time: wp.array, u: wp.array) -> None:
        if self._runs and self._poses:
            self._poses.evaluate(time)
            for first, count in self._runs:
                self._poses.place(first, count, self._wall, self._reference, self._state.x, u, self._state.a)

    def rotations(self) -> np.ndarray:
        """Rotation vectors of the walls, 0 for the fluid [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._turns(0)

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the walls, 0 for the fluid [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._turns(1)

    def _turns(self, derivative: int) -> np.ndarray:
        turns = np.zeros_like(self._particles.angular_velocities)
        if self._poses:
            turns[: self._walls] = self._poses.turns()[derivative][self._particles.walls[: self._walls]]
        return turns

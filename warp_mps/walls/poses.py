"""The poses of the walls of a scene on a device, and the motion of their particles."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.particles.particles import Particles
from warp_mps.scene import HarmonicMotion, HarmonicRotation, Scene, TableMotion, TableRotation, Wall
from warp_mps.scene.spline import clamped_slopes
from warp_mps.walls.kernels import METHOD, wall_kernels

Track = HarmonicMotion | TableMotion | HarmonicRotation | TableRotation | None


def declare_walls(types: NumericTypes) -> str:
    """Declare the kernels of a dimension and precision, and return the name of their module."""
    wall_kernels(types)
    return types.module(METHOD)


class Poses:
    """Displacements and rotations of the walls of a scene at one time, by their prescribed motions.

    After construction nothing reads the device or allocates: `evaluate` and `place` can be captured.

    Attributes:
        value: Displacement [m] in column 0 and angle [rad] in column 1, there the first component,
            float64 vectors [walls, 2].
        rate: Their first derivatives [m/s], [rad/s].
        second: Their second derivatives [m/s^2], [rad/s^2].
        pivot: Point of the undisplaced scene about which each wall rotates [m], float64 vectors [walls].
        axis: Unit axis of the rotation of each wall, float64 3-vectors [walls]; the normal in 2-D.

    Args:
        scene: The case.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, scene: Scene, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device, self._d = wall_kernels(types), device, types.dimension
        self.vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        self._shape = (len(scene.walls), 2)
        self._constants = self._tracks([(wall.motion, wall.rotation) for wall in scene.walls])
        self.pivot = wp.array([self._pivot(wall) for wall in scene.walls], dtype=self.vec64, device=device)
        self.axis = wp.array([self._axis(wall) for wall in scene.walls], dtype=wp.vec3d, device=device)
        self.value, self.rate, self.second = (wp.zeros(self._shape, dtype=self.vec64, device=device) for _ in range(3))

    def evaluate(self, time: wp.array) -> None:
        """Evaluate the poses.

        Args:
            time: The time [s], float64 [1] on the device.
        """
        inputs = [*self._constants, time]
        outputs = [self.value, self.rate, self.second]
        wp.launch(self._kernels.pose, self._shape, inputs, outputs, device=self._device)

    def place(
        self, first: int, count: int, wall: wp.array, reference: wp.array, x: wp.array, v: wp.array, a: wp.array
    ) -> None:
        """Move particles with their walls.

        Args:
            first: First of the particles.
            count: Number of them.
            wall: Index of the wall of each particle, int32 [n]; particles with a negative index are skipped.
            reference: Reference positions X [m], float64 vectors [n].
            x: Positions [m], vec [n].
            v: Velocities [m/s], vec [n].
            a: Accelerations [m/s^2], vec [n].
        """
        inputs = [first, wall, reference, *self.arrays()]
        wp.launch(self._kernels.place, count, inputs, [x, v, a], device=self._device)

    def arrays(self) -> list[wp.array]:
        """Arguments of kernels: pivots, axes, values and their two derivatives."""
        return [self.pivot, self.axis, self.value, self.rate, self.second]

    def turns(self) -> tuple[np.ndarray, np.ndarray]:
        """Rotation vectors [rad] and angular velocities [rad/s] of the walls, shape [walls, 1] or [walls, 3]."""
        axis = self.axis.numpy()[:, 2:] if self._d == 2 else self.axis.numpy()
        return self.value.numpy()[:, 1, :1] * axis, self.rate.numpy()[:, 1, :1] * axis

    def _tracks(self, motions: list[tuple[Track, Track]]) -> list[wp.array]:
        """Arguments of the `pose` kernel: each wall's displacement and angle, tables one after the other."""
        amplitude = np.zeros((*self._shape, self._d))
        frequency, phase = np.zeros(self._shape), np.zeros(self._shape)
        start = np.zeros((self._shape[0], 4), int)
        cubic = np.zeros(self._shape, int)
        tables: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        end = 0
        for w, k in np.ndindex(self._shape):
            track = motions[w][k]
            start[w, 2 * k : 2 * k + 2] = end
            if isinstance(track, HarmonicMotion | HarmonicRotation):
                amplitude[w, k, : np.size(track.amplitude)] = track.amplitude
                frequency[w, k], phase[w, k] = track.frequency, track.phase
            elif track is not None:
                tables.append(self._table(track))
                end += len(tables[-1][0])
                start[w, 2 * k + 1] = end
                cubic[w, k] = int(track.interpolation == "cubic")
        none = np.zeros((0, self._d))
        times = np.concatenate([times for times, _, _ in tables] or [none[:, 0]])
        rows = np.concatenate([rows for _, rows, _ in tables] or [none])
        slopes = np.concatenate([slopes for _, _, slopes in tables] or [none])

        def array(values: np.ndarray, kind: Any) -> wp.array:
            return wp.array(values, dtype=kind, device=self._device)

        return [
            array(amplitude, self.vec64), array(frequency, wp.float64), array(phase, wp.float64),
            array(start, wp.int32), array(times, wp.float64), array(rows, self.vec64), array(slopes, self.vec64),
            array(cubic, wp.int32),
        ]  # fmt: skip

    def _table(self, track: TableMotion | TableRotation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, rows and slopes of a table, the rows as vectors."""
        times = np.asarray(track.times, float)
        given = track.displacements if isinstance(track, TableMotion) else np.asarray(track.angles)[:, None]
        rows = np.zeros((len(times), self._d))
        rows[:, : np.shape(given)[1]] = given
        return times, rows, clamped_slopes(times, rows)

    def _pivot(self, wall: Wall) -> np.ndarray:
        return np.asarray(wall.rotation.pivot, float) if wall.rotation else np.zeros(self._d)

    def _axis(self, wall: Wall) -> np.ndarray:
        if self._d == 2 or not wall.rotation:
            return np.array([0.0, 0.0, 1.0])
        axis = np.asarray(wall.rotation.axis, float)
        return axis / np.linalg.norm(axis)


def moving_runs(scene: Scene, particles: Particles) -> list[tuple[int, int]]:
    """First particle and number of particles of the moving walls, those that follow each other as one."""
    runs: list[tuple[int, int]] = []
    for wall, (first, last) in zip(scene.walls, particles.ranges[particles.elastic_bodies :].tolist(), strict=False):
        if wall.moves:
            before = runs.pop() if runs and sum(runs[-1]) == first else (first, 0)
            runs.append((before[0], last - before[0]))
    return runs

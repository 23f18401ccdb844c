"""Poses of walls: the formula in NumPy, and velocities and accelerations against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tests.scenes import block, scene_of
from warp_mps.core.types import numeric_types
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import HarmonicMotion, HarmonicRotation, Scene, TableMotion, TableRotation, Wall
from warp_mps.shapes import Box
from warp_mps.walls.poses import Poses, moving_runs

AXIS = (1.0, -2.0, 0.5)
TIMES = np.array([0.0, 0.1, 0.25, 0.3, 0.55])
ROWS = np.array([(0.0, 0.0, 0.0), (0.1, -0.2, 0.05), (0.15, 0.1, 0.0), (0.1, 0.0, -0.1), (0.4, 0.3, 0.2)])
ANGLES = np.array([0.0, 1.0, -0.5, 0.2, 2.5])


def walls(dimension: int) -> tuple[Wall, ...]:
    """Walls of every kind of motion, and one at rest between them."""
    d = dimension
    sway = HarmonicMotion(amplitude=(0.03, -0.02, 0.01)[:d], frequency=3.0, phase=0.4)
    turn = HarmonicRotation(amplitude=0.8, frequency=2.0, phase=1.1, pivot=(0.3, 0.1, -0.2)[:d], axis=AXIS)
    track = TableMotion(times=TIMES, displacements=ROWS[:, :d])
    swing = TableRotation(times=TIMES + 0.02, angles=ANGLES, pivot=(-0.1, 0.2, 0.1)[:d], axis=AXIS)
    smooth = replace(track, interpolation="cubic")
    moves = (
        (sway, None), (None, turn), (None, None), (track, swing),
        (smooth, turn), (sway, replace(swing, interpolation="cubic")),
    )  # fmt: skip
    return tuple(
        Wall(name=f"wall{k}", shape=Box([0.02] * d, [5.0 + k] + [0.0] * (d - 1)), spacing=0.01, motion=m, rotation=r)
        for k, (m, r) in enumerate(moves)
    )


def scene(dimension: int) -> Scene:
    return scene_of(block(dimension), dimension=dimension, walls=walls(dimension))


def track_value(track: object, t: float) -> np.ndarray | float:
    """Displacement or angle of a motion."""
    if track is None:
        return 0.0
    if isinstance(track, HarmonicMotion | HarmonicRotation):
        angle = 2.0 * np.pi * track.frequency * t + track.phase
        return np.asarray(track.amplitude) * (np.sin(angle) - np.sin(track.phase))
    rows = track.displacements if isinstance(track, TableMotion) else track.angles  # type: ignore[attr-defined]
    times = track.times  # type: ignore[attr-defined]
    t = float(np.clip(t, times[0], times[-1]))
    if track.interpolation == "cubic":  # type: ignore[attr-defined]
        return CubicSpline(times, rows, bc_type="clamped")(t)
    columns = rows.reshape(len(times), -1).T
    return np.array([np.interp(t, times, column) for column in columns]).reshape(rows.shape[1:])


def formula(wall: Wall, positions: np.ndarray, t: float) -> np.ndarray:
    """Positions pivot + R(angle) (X - pivot) + displacement."""
    shift = track_value(wall.motion, t)
    if wall.rotation is None:
        return positions + shift
    d = positions.shape[1]
    axis = np.array(AXIS) if d == 3 else np.array([0.0, 0.0, 1.0])
    vector = float(track_value(wall.rotation, t)) * axis / np.linalg.norm(axis)
    matrix = Rotation.from_rotvec(vector).as_matrix()[:d, :d]
    return wall.rotation.pivot + (positions - wall.rotation.pivot) @ matrix.T + shift


class Placed:
    """The walls of a scene, placed on the CPU."""

    def __init__(self, dimension: int, precision: str = "float64") -> None:
        self.scene = scene(dimension)
        numbers = numeric_types(dimension, precision)
        self.particles = fill_scene(self.scene)
        self.poses = Poses(self.scene, types=numbers, device="cpu")
        self.out = [wp.zeros(self.particles.count, dtype=numbers.vec, device="cpu") for _ in range(3)]
        self.wall = wp.array(self.particles.walls, dtype=wp.int32, device="cpu")
        self.reference = wp.array(self.particles.positions, dtype=self.poses.vec64, device="cpu")

    def at(self, t: float) -> tuple[np.ndarray, ...]:
        """Positions, velocities and accelerations at a time."""
        self.poses.evaluate(wp.array([t], dtype=wp.float64, device="cpu"))
        self.poses.place(0, self.particles.count, self.wall, self.reference, *self.out)
        return tuple(array.numpy().astype(float) for array in self.out)


@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-14), ("float32", 1e-6)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_are_where_the_formula_has_them(dimension: int, precision: str, rounding: float) -> None:
    placed = Placed(dimension, precision)
    for t in (0.0, 0.013, 0.1, 0.27, 0.55, 0.56, 0.9):
        x, _, _ = placed.at(t)
        assert (x[: placed.particles.elastic] == 0.0).all()  # those of no wall are left alone
        for k, wall in enumerate(placed.scene.walls):
            mine = placed.particles.walls == k
            expected = formula(wall, placed.particles.positions[mine], t)
            np.testing.assert_allclose(x[mine], expected, atol=20.0 * rounding)


@pytest.mark.parametrize("dimension", [2, 3])
def test_velocities_and_accelerations_are_the_derivatives(dimension: int) -> None:
    """Central differences of second order at two steps: the error falls by four."""
    placed = Placed(dimension)
    for t in (0.013, 0.17, 0.41, 0.7):
        _, v, a = placed.at(t)
        errors = []
        for h in (2e-4, 1e-4):
            (x0, v0, _), (x1, v1, _) = placed.at(t - h), placed.at(t + h)
            scale = 1.0 + np.abs(v).max(), 1.0 + np.abs(a).max()
            errors.append([np.abs((x1 - x0) / (2 * h) - v).max(), np.abs((v1 - v0) / (2 * h) - a).max()])
            assert (np.array(errors[-1]) < 1e-3 * np.array(scale)).all()
        ratio = np.array(errors[0]) / np.array(errors[1])
        assert ((ratio > 3.5) & (ratio < 4.5)).all()


@pytest.mark.parametrize("t", [0.1, 0.25, 0.3])
def test_a_cubic_table_has_continuous_velocity_and_acceleration(t: float) -> None:
    placed = Placed(2)
    for k, continuous in ((3, False), (4, True)):
        mine = placed.particles.walls == k
        jumps = []
        for h in (1e-6, 1e-8):
            before, after = placed.at(t - h), placed.at(t + h)
            jumps.append([np.abs(b[mine] - a[mine]).max() for a, b in zip(before[1:], after[1:], strict=True)])
        falls = np.array(jumps[1]) < 0.02 * np.array(jumps[0])
        assert falls.all() == continuous


def test_a_cubic_table_is_at_rest_at_its_ends() -> None:
    placed = Placed(2)
    mine = placed.particles.walls == 5
    sway = placed.scene.walls[5].motion
    assert isinstance(sway, HarmonicMotion)
    for t in (0.02, 0.57):  # the ends of the table of angles
        _, v, _ = placed.at(t)
        speed = 2.0 * np.pi * 3.0 * np.cos(2.0 * np.pi * 3.0 * t + 0.4)
        np.testing.assert_allclose(
            v[mine], np.outer(np.ones(mine.sum()), speed * np.asarray(sway.amplitude)), atol=1e-14
        )


def test_turns_are_rotation_vectors() -> None:
    placed = Placed(3)
    placed.at(0.17)
    rotations, spins = placed.poses.turns()
    wall = placed.scene.walls[1]
    unit = np.array(AXIS) / np.linalg.norm(AXIS)
    np.testing.assert_allclose(rotations[1], track_value(wall.rotation, 0.17) * unit, rtol=1e-13)
    rate = 0.8 * 4.0 * np.pi * np.cos(4.0 * np.pi * 0.17 + 1.1)
    np.testing.assert_allclose(spins[1], rate * unit, rtol=1e-13)
    assert not rotations[[0, 2]].any()


def test_runs_of_moving_walls() -> None:
    given = scene(2)
    particles = fill_scene(given)
    ranges = particles.ranges[1:]
    runs = moving_runs(given, particles)
    assert runs == [
        (ranges[0, 0], ranges[1, 1] - ranges[0, 0]),
        (ranges[3, 0], ranges[5, 1] - ranges[3, 0]),
    ]
    assert (
        moving_runs(replace(given, walls=(given.walls[2],)), fill_scene(replace(given, walls=(given.walls[2],)))) == []
    )

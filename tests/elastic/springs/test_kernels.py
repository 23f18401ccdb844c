"""Forces, torques and pressures of the spring model: by hand, as gradients, and under rigid motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.core.rotors import rotors_of, turned
from tests.elastic.states import Held, hold, random_state, rigid_displacement
from tests.scenes import STEEL, block, cross, elasticities, random, scene_of
from warp_mps.scene import Elasticity, Material, Scene
from warp_mps.shapes import Box, Points

PLANES = [(2, "strain"), (2, "stress"), (3, "strain")]


def irregular(dimension: int, plane: str = "strain", elasticity: Elasticity = Elasticity(model="springs")) -> Scene:
    """Two bonded bodies of different materials, their particles off the lattice."""
    counts = (3, 3, 2)[:dimension]
    lines = [0.01 * np.arange(count) for count in counts]
    cells = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, dimension)
    jitter = 0.001 * random(len(cells), dimension, seed=7)
    left = block(dimension, name="left", shape=Points(cells + jitter), bonded_to=("right",))
    right = block(dimension, name="right", shape=Points(cells - jitter + 0.03 * np.eye(dimension)[0]), material=STEEL)
    right = replace(right, bonded_to=("left",))
    return scene_of(left, right, dimension=dimension, plane=plane, elasticity=elasticity)


def numerical_loads(held: Held, displacements: np.ndarray, rotors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minus the gradient of the energy by central differences, of every displacement and rotation."""
    n, d = displacements.shape
    forces, torques = np.zeros((n, d)), np.zeros((n, 2 * d - 3))
    for values, size in ((forces, 1e-7), (torques, 1e-5)):
        for place in np.ndindex(values.shape):
            step = np.zeros_like(values)
            step[place] = size
            ends = [
                held.put(displacements + sign * step, rotors).energy()
                if values is forces
                else held.put(displacements, turned(rotors, sign * step)).energy()
                for sign in (1.0, -1.0)
            ]
            values[place] = (ends[1] - ends[0]) / (2 * size)
    return forces, torques


@pytest.mark.parametrize("elasticity", elasticities(), ids=str)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_loads_are_minus_the_gradient_of_the_energy(dimension: int, plane: str, elasticity: Elasticity) -> None:
    held = hold(irregular(dimension, plane, elasticity))
    displacements, rotors = random_state(held.particles)
    expected = numerical_loads(held, displacements, rotors)
    held.put(displacements, rotors)
    for found, slope in zip(held.loads(), expected, strict=True):
        # differences of an energy E over a step h lose eps E / h, and h^2 of the third derivative
        np.testing.assert_allclose(found, slope, atol=1e-6 * np.abs(slope).max())


@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_single_precision_gives_the_same_loads(dimension: int, plane: str) -> None:
    scene = irregular(dimension, plane)
    double, single = hold(scene), hold(scene, "float32")
    displacements, rotors = random_state(double.particles)
    loads = [held.put(displacements, rotors).loads() for held in (double, single)]
    for exact, rounded in zip(*loads, strict=True):
        np.testing.assert_allclose(rounded, exact, atol=2e-6 * np.abs(exact).max())


def test_a_pair_by_hand() -> None:
    """Two particles 0.01 m apart along x, the right one moved by (a, b), both rotations held at 0, plane strain.

    The only pair has w = 2.1 - 1 = 1.1, and n is n0 of the lattice. With lambda = 4 MPa, 2 mu = 8 MPa:
    k = V0 (4 / n0) 8e6 w / l0^2 and p = -lambda (2 / n0) w s / l0, s the stretch.
    """
    material = Material(1000.0, 1e7, 0.25)
    lame, two_mu = 4e6, 8e6
    n0 = 4 * 1.1 + 4 * (2.1 / np.sqrt(2) - 1) + 4 * 0.05
    held = hold(
        scene_of(block(2, (2, 1), material=material), elasticity=Elasticity(model="springs", effective_radius=2.1))
    )
    a, b = 1e-3, 2e-3
    forces, torques = held.put(np.array([[0.0, 0.0], [a, b]])).loads()
    x = np.array([0.01 + a, b])
    length = np.linalg.norm(x)
    stretch = (a * x[0] + b * x[1]) / length
    k = 1e-4 * 4 / n0 * two_mu * 1.1 / 1e-4
    pressure = -lame * 2 / n0 * 1.1 * stretch / 0.01
    # d stretch / dx = x/r + (the part of u across x)/r
    slope = x / length + (np.array([a, b]) - stretch * x / length) / length
    force = k * np.array([a, b]) - 1e-4 * 2 / n0 * 1.1 / 0.01 * 2 * pressure * slope
    np.testing.assert_allclose(forces, [force, -force], rtol=1e-12)
    np.testing.assert_allclose(held.pressures(), [pressure, pressure], rtol=1e-12)
    # half of X x (k u + ...), the part of the force across X at the arm X
    torque = 0.01 * (k * b - 1e-4 * 2 / n0 * 1.1 / 0.01 * 2 * pressure * x[1] / length)
    np.testing.assert_allclose(torques, [[0.5 * torque]] * 2, rtol=1e-12)


@pytest.mark.parametrize("elasticity", elasticities(), ids=str)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_motion_gives_no_load(dimension: int, elasticity: Elasticity) -> None:
    held = hold(irregular(dimension, elasticity=elasticity))
    scale = np.abs(held.put(*random_state(held.particles)).loads()[0]).max()
    energy = held.energy()
    for angle in (0.0, 1e-6, 0.1, 2.0):
        rotation = angle * np.array([1.0] if dimension == 2 else [0.6, 0.0, 0.8])
        rotors = np.repeat(rotors_of(rotation[None]), held.particles.count, axis=0)
        forces, torques = held.put(rigid_displacement(held.particles, rotation, 0.5), rotors).loads()
        # a shift of 50 spacings costs a displacement, and so a strain, that many roundings
        np.testing.assert_allclose(forces, 0.0, atol=1e-12 * scale)
        np.testing.assert_allclose(torques, 0.0, atol=1e-14 * scale)
        assert held.energy() < 1e-22 * energy


@pytest.mark.parametrize("elasticity", elasticities(), ids=str)
@pytest.mark.parametrize("dimension", [2, 3])
def test_loads_add_up_to_nothing(dimension: int, elasticity: Elasticity) -> None:
    held = hold(irregular(dimension, elasticity=elasticity))
    displacements, rotors = random_state(held.particles, size=0.3)
    forces, torques = held.put(displacements, rotors).loads()
    positions = held.particles.positions + displacements
    moments = cross(positions, forces)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * np.abs(forces).sum())
    total = (moments + torques).sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-13 * np.abs(moments).sum())
    # they are no zeros by themselves
    assert np.abs(torques.sum(axis=0)).max() > 1e-3 * np.abs(moments).sum()


@pytest.mark.parametrize("normalization", ["lattice", "particle"])
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_pressure_of_a_uniform_dilation(dimension: int, plane: str, normalization: str) -> None:
    """Inside a body, u = e x gives div u = e d and p = -lambda e d, exactly on a lattice."""
    elasticity = Elasticity(model="springs", effective_radius=2.1, normalization=normalization)
    held = hold(scene_of(block(dimension, (7, 7, 7)), dimension=dimension, plane=plane, elasticity=elasticity))
    positions = held.particles.positions
    held.put(1e-3 * positions)
    lame = 0.3e7 / (1 - 0.09) if plane == "stress" else 0.3e7 / (1.3 * 0.4)
    inside = np.all(np.abs(positions) < 0.0101, axis=1)
    assert inside.sum() == 3**dimension
    np.testing.assert_allclose(held.pressures()[inside], -lame * 1e-3 * dimension, rtol=1e-11)
    forces, _ = held.loads()
    scale = np.abs(forces).max()
    middle = np.all(np.abs(positions) < 0.0051, axis=1)
    np.testing.assert_allclose(forces[middle], 0.0, atol=1e-12 * scale)


def test_bonded_bodies_of_one_material_are_one_body() -> None:
    whole = hold(scene_of(block(2, (6, 3))))
    halves = [
        block(2, name=name, shape=Box((0.03, 0.03), (x, 0.0)), bonded_to=other)
        for name, x, other in (("left", -0.015, ()), ("right", 0.015, ("left",)))
    ]
    joined = hold(scene_of(*halves))
    loads = []
    for held in (whole, joined):
        positions = held.particles.positions
        held.put(np.column_stack((0.1 * positions[:, 1], 5.0 * positions[:, 0] ** 2)))
        order = np.lexsort(positions.T.round(6))
        loads.append(held.loads()[0][order])
    np.testing.assert_allclose(loads[1], loads[0], atol=1e-12 * np.abs(loads[0]).max())


def test_bodies_that_are_not_bonded_do_not_hold_each_other() -> None:
    halves = [
        block(2, name=name, shape=Box((0.03, 0.03), (x, 0.0))) for name, x in (("left", -0.015), ("right", 0.015))
    ]
    held = hold(scene_of(*halves))
    apart = np.where(held.particles.bodies[:, None] == 0, 0.0, 1.0) * np.ones(2)
    assert (held.put(apart).loads()[0] == 0.0).all()

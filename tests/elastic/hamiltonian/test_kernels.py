"""Deformation gradients, forces, pressures and rotations of the Hamiltonian model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from tests.core.rotors import matrices_of, rotors_of
from tests.elastic.states import Strained, rigid_displacement, strain
from tests.scenes import HAMILTONIAN, RUBBER, SPRINGS, STEEL, block, cross, random, scene_of
from warp_mps.errors import InputError
from warp_mps.scene import LAWS, Body, Elasticity, Scene
from warp_mps.shapes import Box, Points, Sphere

PLANES = [(2, "strain"), (2, "stress"), (3, "strain")]
RADII = [1.5, 2.1]


def irregular(
    dimension: int, *, plane: str = "strain", law: str = LAWS[0], radius: float = 1.5, nu: float | None = None
) -> Scene:
    """Two bonded bodies of different materials, their particles off the lattice; `nu` is of the left one."""
    lines = [0.01 * np.arange(count) for count in (3, 3, 2)[:dimension]]
    cells = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, dimension)
    jitter = 0.001 * random(len(cells), dimension, seed=7)
    soft, hard = replace(RUBBER, law=law), replace(STEEL, law=law)
    soft = replace(soft, poissons_ratio=soft.poissons_ratio if nu is None else nu)
    left = block(dimension, name="left", shape=Points(cells + jitter), material=soft)
    shifted = cells - jitter + 0.03 * np.eye(dimension)[0]
    right = block(dimension, name="right", shape=Points(shifted), material=hard, bonded_to=("left",))
    elasticity = Elasticity(effective_radius=radius)
    return scene_of(left, right, dimension=dimension, plane=plane, elasticity=elasticity)


def rotation(dimension: int, angle: float) -> np.ndarray:
    """Rotation matrix by an angle [rad], about an oblique axis in 3-D."""
    axis = np.array([1.0]) if dimension == 2 else np.array([2.0, -1.0, 2.0]) / 3.0
    return matrices_of(rotors_of(angle * axis[None]))[0]


def strained_state(held: Strained, size: float = 0.3) -> np.ndarray:
    """Displacements by a stretch of `size`, random moves of a tenth of a spacing, and a large rotation of it all."""
    n, d = held.particles.positions.shape
    stretch = np.eye(d) + size * random(d, d, seed=2)
    moved = held.particles.positions @ stretch.T + 0.001 * random(n, d, seed=1)
    return moved @ rotation(d, 2.0).T - held.particles.positions + 0.1


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_of_linear_fields_are_exact(dimension: int, radius: float) -> None:
    """Everywhere: inside, at surfaces, in corners, and where the particles are irregular."""
    field = random(dimension, dimension, seed=4)
    for scene in (
        irregular(dimension, radius=radius),
        scene_of(block(dimension), dimension=dimension, elasticity=HAMILTONIAN),
        scene_of(block(dimension, shape=Sphere(0.04, [0.0] * dimension)), dimension=dimension, elasticity=HAMILTONIAN),
    ):
        held = strain(scene)
        held.put(held.particles.positions @ field.T + 0.5)
        # u_ij of neighbours is a hundredth of what is displaced
        np.testing.assert_allclose(held.gradients, np.broadcast_to(field, held.gradients.shape), atol=1e-13)


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_forces_are_minus_the_gradient_of_the_energy(dimension: int, plane: str, law: str, radius: float) -> None:
    held = strain(irregular(dimension, plane=plane, law=law, radius=radius))
    displacements = strained_state(held)
    expected, step = np.zeros_like(displacements), 1e-7
    for place in np.ndindex(expected.shape):
        change = np.zeros_like(displacements)
        change[place] = step
        ends = [held.put(displacements + sign * change).energy for sign in (1.0, -1.0)]
        expected[place] = (ends[1] - ends[0]) / (2 * step)
    forces = held.put(displacements).forces
    np.testing.assert_allclose(forces, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_forces_add_up_to_nothing(dimension: int, plane: str, law: str) -> None:
    held = strain(irregular(dimension, plane=plane, law=law))
    displacements = strained_state(held)
    forces = held.put(displacements).forces
    moments = cross(held.particles.positions + displacements, forces)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * np.abs(forces).sum())
    np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-13 * np.abs(moments).sum())


@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-13), ("float32", 1e-4)])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_motion_gives_no_force(dimension: int, law: str, precision: str, rounding: float) -> None:
    """By several turns about any axis, and with a shift by five spacings."""
    held = strain(irregular(dimension, law=law), precision)
    held.put(strained_state(held))
    scale, energy = np.abs(held.forces).max(), held.energy
    axes = np.ones((1, 1)) if dimension == 2 else Rotation.random(3, random_state=1).apply([0.0, 0.0, 1.0])
    for axis in axes:
        for angle in (0.0, 1e-6, 0.1, 2.0, np.pi, 20 * np.pi + 1.0):
            held.put(rigid_displacement(held.particles, angle * axis, 0.05))
            np.testing.assert_allclose(held.forces, 0.0, atol=rounding * scale)
            assert held.energy < rounding**1.8 * energy


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_rotation_turns_the_forces(dimension: int, plane: str, law: str) -> None:
    held = strain(irregular(dimension, plane=plane, law=law))
    displacements = strained_state(held)
    forces, energy = held.put(displacements).forces, held.energy
    turn = rotation(dimension, 1.2)
    positions = held.particles.positions
    held.put((positions + displacements) @ turn.T - positions)
    np.testing.assert_allclose(held.forces, forces @ turn.T, atol=1e-12 * np.abs(forces).max())
    assert held.energy == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_pressure_of_a_uniform_deformation(dimension: int, plane: str, law: str) -> None:
    """Inside and at the surface alike; the formulas are those of the laws, in NumPy."""
    material = replace(RUBBER, law=law)
    body = block(dimension, material=material)
    held = strain(scene_of(body, dimension=dimension, plane=plane, elasticity=HAMILTONIAN))
    f = rotation(dimension, 2.5) @ (np.eye(dimension) + 0.1 * random(dimension, dimension, seed=6))
    held.put(held.particles.positions @ (f - np.eye(dimension)).T)
    mu, lame = 1e7 / 2.6, 0.3e7 / (1.3 * 0.4)
    if law == "st_venant_kirchhoff":
        lame = 0.3e7 / 0.91 if plane == "stress" else lame
        e = 0.5 * (f.T @ f - np.eye(dimension))
        kirchhoff = f @ (2 * mu * e + lame * np.trace(e) * np.eye(dimension)) @ f.T
    else:
        log_j = np.log(np.linalg.det(f))
        for _ in range(200 if plane == "stress" else 0):  # mu (b^2 - 1) = -lambda ln(J b), by relaxation
            b = np.sqrt(1 - lame / mu * log_j)
            log_j += 0.2 * (np.log(np.linalg.det(f) * b) - log_j)
        kirchhoff = mu * (f @ f.T - np.eye(dimension)) + lame * log_j * np.eye(dimension)
    expected = -np.trace(kirchhoff) / np.linalg.det(f) / dimension
    np.testing.assert_allclose(held.model.pressures(), expected, rtol=1e-11)


@pytest.mark.parametrize("dimension", [2, 3])
def test_rotations_are_those_of_the_polar_decomposition(dimension: int) -> None:
    held = strain(scene_of(block(dimension), dimension=dimension, elasticity=HAMILTONIAN))
    stretch = np.eye(dimension) + 0.3 * random(dimension, dimension, seed=6)
    for angle in (0.0, 1e-9, 0.5, -2.0, np.pi - 1e-6, np.pi):
        f = rotation(dimension, angle) @ stretch
        held.put(held.particles.positions @ (f - np.eye(dimension)).T)
        found = matrices_of(rotors_of(held.model.rotations()))
        np.testing.assert_allclose(found, np.broadcast_to(polar(f)[0], found.shape), atol=1e-13)


@pytest.mark.parametrize("angle", [1e-9, 0.5, 3.0, np.pi])
def test_rotations_of_a_rigid_body(angle: float) -> None:
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    held = strain(scene_of(block(3), dimension=3, elasticity=HAMILTONIAN))
    found = held.put(rigid_displacement(held.particles, angle * axis)).model.rotations()
    # half a turn about an axis is half a turn about the opposite one
    found = np.where(found[:, :1] < 0.0, -found, found) if angle == np.pi else found
    np.testing.assert_allclose(found, np.broadcast_to(angle * axis, found.shape), atol=1e-13)


def test_bonded_bodies_of_one_material_are_one_body() -> None:
    whole = strain(scene_of(block(2, (6, 3)), elasticity=HAMILTONIAN))
    halves = [
        block(2, name=name, shape=Box((0.03, 0.03), (x, 0.0)), bonded_to=other)
        for name, x, other in (("left", -0.015, ()), ("right", 0.015, ("left",)))
    ]
    forces = []
    for held in (whole, strain(scene_of(*halves, elasticity=HAMILTONIAN))):
        positions = held.particles.positions
        held.put(np.column_stack((0.1 * positions[:, 1], 5.0 * positions[:, 0] ** 2)))
        forces.append(held.forces[np.lexsort(positions.T.round(6))])
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-12 * np.abs(forces[0]).max())


def test_bodies_that_are_not_bonded_do_not_hold_each_other() -> None:
    halves = [
        block(2, name=name, shape=Box((0.03, 0.03), (x, 0.0))) for name, x in (("left", -0.015), ("right", 0.015))
    ]
    held = strain(scene_of(*halves, elasticity=HAMILTONIAN))
    held.put(np.where(held.particles.bodies[:, None] == 0, 0.0, 1.0) * np.ones(2))
    assert (held.forces == 0.0).all()


def test_the_law_is_each_bodys_own() -> None:
    """Two bodies apart, of different laws, deform as each would alone."""
    laws = [replace(RUBBER, law=law) for law in LAWS]
    bodies = [
        block(2, name=f"b{k}", material=material, shape=Box((0.04, 0.03), (0.1 * k, 0.0)))
        for k, material in enumerate(laws)
    ]

    def pulled(*chosen: Body) -> list[np.ndarray]:
        held = strain(scene_of(*chosen, elasticity=HAMILTONIAN))
        held.put(0.3 * held.particles.positions)
        return [held.forces[held.particles.bodies == k] for k in range(len(chosen))]

    together, alone = pulled(*bodies), [pulled(body)[0] for body in bodies]
    for both, single in zip(together, alone, strict=True):
        np.testing.assert_allclose(both, single, atol=1e-12 * np.abs(single).max())
    assert np.abs(together[0] - together[1]).max() > 0.1 * np.abs(together[0]).max()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), PLANES)
def test_single_precision_gives_the_same_forces(dimension: int, plane: str, law: str) -> None:
    scene = irregular(dimension, plane=plane, law=law)
    double, single = strain(scene), strain(scene, "float32")
    forces = [held.put(strained_state(held) - 0.1).forces for held in (double, single)]
    np.testing.assert_allclose(forces[1], forces[0], atol=2e-5 * np.abs(forces[0]).max())


@pytest.mark.parametrize("cells", [(4, 1), (1, 1), (4, 4, 1), (4, 1, 1)])
@pytest.mark.parametrize("radius", RADII)
def test_a_body_of_one_layer_is_refused(cells: tuple[int, ...], radius: float) -> None:
    thick = block(len(cells), (3, 3, 3), name="thick")
    thin = block(len(cells), cells, name="sheet", shape=Box([0.01 * n for n in cells], [1.0] * len(cells)))
    elasticity = Elasticity(effective_radius=radius)
    with pytest.raises(InputError, match=r"body 'sheet'.*spacing.*one particle thick"):
        strain(scene_of(thick, thin, dimension=len(cells), elasticity=elasticity))


def test_springs_refuse_the_neo_hookean_law() -> None:
    body = block(2, material=replace(RUBBER, law="neo_hookean"))
    with pytest.raises(InputError, match="law: is 'neo_hookean'"):
        scene_of(body, elasticity=SPRINGS)

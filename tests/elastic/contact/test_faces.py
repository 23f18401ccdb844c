"""Contact of faces: the gradient of the law, planes that their lattices do not show, walls, corners."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scenes import HAMILTONIAN, RUBBER, block, cross, scene_of
from warp_mps.elastic.contact.law import law_constants
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, Material, Scene, Wall
from warp_mps.shapes import Box


def cluster(dimension: int, precision: str = "float64", **contact: object) -> Simulation:
    """Four small bodies pressed into each other, of two spacings, two of them bonded and one softer."""
    rest = [0.0] * (dimension - 2)
    size = (0.03, 0.03, 0.03)[:dimension]
    soft = Material(1000.0, 3e6, 0.3)
    bodies = (
        block(dimension, name="left", shape=Box(size, [-0.0139, 0.0, *rest])),
        block(dimension, name="right", shape=Box(size, [0.0139, 0.0021, *rest]), material=soft),
        Body(name="top", shape=Box(size, [0.004, 0.0295, *rest]), material=RUBBER, spacing=0.006),
        Body(
            name="bonded", shape=Box(size, [0.034, 0.0295, *rest]), material=RUBBER, spacing=0.006, bonded_to=("top",)
        ),
    )
    return Simulation(scene_of(*bodies, dimension=dimension, contact=Contact(**contact)), precision=precision)  # type: ignore[arg-type]


def stored(simulation: Simulation, x: np.ndarray) -> float:
    """The contact energy of the cluster at positions x, as `warp_mps.elastic.contact.law` writes it."""
    particles, scene = simulation.particles, simulation.scene
    youngs = np.array([body.material.youngs_modulus for body in scene.bodies])[particles.bodies]
    total = 0.0
    for i in range(particles.count):
        for group in set(particles.groups) - {particles.groups[i]}:
            others = particles.groups == group
            own, other = particles.spacings[i], particles.spacings[others][0]
            weight, scale = law_constants(particles.dimension, own, other)
            s = np.minimum(np.linalg.norm(x[others] - x[i], axis=1) / (2.0 * max(own, other)), 1.0)
            q = weight * np.sum((1.0 - s) ** 4 * (1.0 + 4.0 * s))
            modulus = scene.contact.stiffness * min(youngs[i], youngs[others].min())
            total += 0.5 * scale * modulus * max(q - 1.0, 0.0) ** 2
    return total


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_force_is_the_gradient_of_the_energy_of_the_law(dimension: int) -> None:
    simulation = cluster(dimension, stiffness=0.7)
    x = simulation.positions
    energy = stored(simulation, x)
    assert energy > 0.0
    assert simulation.energy.contact == pytest.approx(energy, rel=1e-12)
    forces = simulation.contact_forces
    largest = np.abs(forces).max()
    assert (np.abs(forces) > 1e-3 * largest).sum() > 20
    step = 1e-7
    for i, axis in np.argwhere(np.abs(forces) > 1e-3 * largest)[::7]:
        moved = np.zeros_like(x)
        moved[i, axis] = step
        slope = (stored(simulation, x + moved) - stored(simulation, x - moved)) / (2 * step)
        assert forces[i, axis] == pytest.approx(-slope, rel=1e-5, abs=1e-6 * largest)
    arms = x - x.mean(axis=0)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-13 * largest * len(x))
    np.testing.assert_allclose(cross(arms, forces).sum(axis=0), 0.0, atol=1e-13 * largest * len(x))


def test_the_force_in_single_precision() -> None:
    double, single = cluster(3), cluster(3, "float32")
    largest = np.abs(double.contact_forces).max()
    np.testing.assert_allclose(single.contact_forces, double.contact_forces, atol=2e-5 * largest)


def faces(dimension: int, gap: float, shift: float) -> tuple[np.ndarray, float]:
    """Pressure of a wide base on a block of 8 cells, so many spacings above it and aside, and the energy it stores."""
    base = block(dimension, (16, 3, 12), name="base")
    aside = [0.01 * shift] * (dimension - 1)
    wide = Box([0.08, 0.03, 0.04][:dimension], [aside[0], 0.03 + 0.01 * gap, *aside[1:]])
    simulation = Simulation(scene_of(base, block(dimension, name="upper", shape=wide), dimension=dimension))
    force = simulation.contact_forces[simulation.particles.bodies == 1].sum(axis=0)
    return force / (0.08 * 0.04 ** (dimension - 2)), simulation.energy.contact


@pytest.mark.parametrize("dimension", [2, 3])
def test_faces_touch_where_they_meet_however_their_lattices_lie(dimension: int) -> None:
    """No force before, E z/l behind, and no resistance to sliding; the edges of the block see a little less."""
    for shift in (0.0, 0.2, 0.35, 0.5):
        assert faces(dimension, 0.02, shift)[1] == 0.0
    for depth in (0.05, 0.15):
        pressures = np.array([faces(dimension, -depth, shift)[0] for shift in (0.0, 0.2, 0.35, 0.5)])
        normal = pressures[:, 1]
        assert np.mean(normal) == pytest.approx(depth * 1e7, rel=0.5)
        # the gap that would make the same difference is 2 % of a spacing, with a stiffness of E/l
        assert np.ptp(normal) < 0.02 * 1e7
        assert np.abs(np.delete(pressures, 1, axis=1)).max() < 0.02 * normal.min()


def test_a_body_in_a_corner_touches_both_walls_and_none_of_them_before() -> None:
    floor = Wall(name="floor", shape=Box((0.12, 0.03), (0.03, -0.015)), spacing=0.01)
    side = Wall(name="side", shape=Box((0.03, 0.06), (-0.015, 0.03)), spacing=0.01)
    for gap, touches in ((1e-4, False), (-5e-4, True)):
        corner = block(2, shape=Box((0.04, 0.03), (0.02 + gap, 0.015 + gap)))
        simulation = Simulation(scene_of(corner, walls=(floor, side)))
        force = simulation.contact_forces[simulation.particles.bodies == 0].sum(axis=0)
        assert (force > 0.0).all() == touches
        assert force.any() == touches


def test_walls_off_each_others_lattice_are_not_too_many_for_a_body_in_their_corner() -> None:
    l0 = 0.01

    def between(low: tuple[float, ...], high: tuple[float, ...]) -> Box:
        return Box(np.subtract(high, low) * l0, 0.5 * np.add(low, high) * l0)

    # 8.6 spacings hold nine rows, the lowest 0.8 spacings above the floor's uppermost
    corners = {"floor": ((-3, -3, -3), (8, 8, 0)), "x": ((-3, -3, 0), (0, 8, 8.6)), "y": ((-3, -3, 0), (8, 0, 8.6))}
    walls = tuple(Wall(name=name, shape=between(*ends), spacing=l0) for name, ends in corners.items())
    cube = Body(name="cube", shape=between((0, 0, 0), (6, 6, 6)), material=RUBBER, spacing=l0)
    simulation = Simulation(scene_of(cube, dimension=3, walls=walls))
    simulation.advance(1)
    assert simulation.solid.trouble() is None


def landed(shift: float) -> Simulation:
    """A block that falls on a rigid wall, whose lattice is shifted so far against the block's, and leaves it again."""
    floor = Wall(name="floor", shape=Box((0.16, 0.02), (0.005 * shift, -0.01)), spacing=0.005)
    block = Body(
        name="block",
        shape=Box((0.1, 0.1), (0.0, 0.0505)),
        material=Material(1000.0, 1e6, 0.3),
        spacing=0.005,
        velocity=(0.0, -1.0),
    )
    return Simulation(Scene(bodies=(block,), walls=(floor,), duration=0.1, elasticity=HAMILTONIAN))


def test_a_block_rebounds_from_a_wall_wherever_its_lattice_lies() -> None:
    """Spectral elements of order 4 give a restitution of 0.795 against a rigid plane."""
    restitutions = []
    for shift in (0.0, 0.5):
        simulation = landed(shift)
        start = simulation.energy.total
        while simulation.time < 0.0085:
            simulation.advance(32)
        assert not simulation.contact_forces.any()
        assert simulation.energy.total == pytest.approx(start, rel=1e-3)
        restitutions.append(simulation.velocities[simulation.particles.bodies == 0, 1].mean())
    assert restitutions[0] == pytest.approx(0.795, rel=0.03)
    assert restitutions[1] == pytest.approx(restitutions[0], rel=0.01)

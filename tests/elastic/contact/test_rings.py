"""Two rings that collide: the paper's section 3.2, with a larger time step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene
from warp_mps.shapes import Cylinder

SPACING, RADIUS, SPEED = 0.0083, 0.05, 2.0
POLYMER = Material(940.0, 2e6, 0.48)


def rings(radius: float) -> Scene:
    """128 particles: two rings, two particles thick, towards each other along x."""
    bodies = tuple(
        Body(
            name=name,
            shape=Cylinder(RADIUS, inner_radius=RADIUS - 2 * SPACING, center=(-side * 0.0555, 0.0)),
            material=POLYMER,
            spacing=SPACING,
            velocity=(side * SPEED, 0.0),
        )
        for name, side in (("left", 1.0), ("right", -1.0))
    )
    return Scene(
        bodies=bodies,
        duration=0.09,
        plane="stress",
        time_step=1e-5,
        elasticity=Elasticity(model="springs", effective_radius=radius),
    )


@pytest.mark.parametrize("radius", [1.5, 2.1])
def test_rings_collide_and_part_unbroken(radius: float) -> None:
    simulation = Simulation(rings(radius))
    particles = simulation.particles
    left, right = particles.bodies == 0, particles.bodies == 1
    assert left.sum() == right.sum() == 64
    mirror = mirror_images(particles.positions[left], particles.positions[right])
    start, touched, stretch = simulation.energy.total, [], 0.0
    while simulation.step < simulation.total_steps:
        simulation.advance(50)
        momentum = (particles.masses[:, None] * simulation.velocities).sum(axis=0)
        np.testing.assert_allclose(momentum, 0.0, atol=1e-12 * particles.masses.sum() * SPEED)
        assert simulation.energy.total == pytest.approx(start, rel=0.01)
        x = simulation.positions
        np.testing.assert_allclose(x[right][mirror] * (-1.0, 1.0), x[left], atol=1e-9 * RADIUS)
        stretch = max(stretch, largest_stretch(simulation))
        touched.append(bool(simulation.contact_forces.any()))
    drift = simulation.energy.total / start - 1.0
    print(f"r_e = {radius} l0: energy {drift:+.1e}, largest stretch {stretch:.2f}, touched {0.5 * sum(touched):.1f} ms")
    assert any(touched)
    assert not any(touched[-20:])
    assert stretch < 2.0
    # they fly apart, and keep the rest of their energy as vibration
    assert simulation.velocities[left, 0].mean() < -0.3 * SPEED


def mirror_images(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """For each particle of the left ring, its mirror image in the right one."""
    distances, index = cKDTree(right).query(left * (-1.0, 1.0))
    assert distances.max() < 1e-12
    return index


def largest_stretch(simulation: Simulation) -> float:
    """The largest distance of two neighbours of the lattice, in units of what it was."""
    reference = simulation.particles.positions
    i, j = cKDTree(reference).query_pairs(1.5 * SPACING, output_type="ndarray").T
    same = simulation.particles.bodies[i] == simulation.particles.bodies[j]
    i, j = i[same], j[same]
    before = np.linalg.norm(reference[i] - reference[j], axis=1)
    return float((np.linalg.norm(simulation.positions[i] - simulation.positions[j], axis=1) / before).max())

"""Small scenes that several tests share."""

from __future__ import annotations

import numpy as np

from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene
from warp_mps.shapes import Box

RUBBER = Material(1000.0, 1e7, 0.3)
STEEL = Material(3000.0, 5e7, 0.1)
SPRINGS = Elasticity(model="springs")
HAMILTONIAN = Elasticity()
LENGTH, THICKNESS = 0.16, 0.02


def beam(layers: int, *, nodes: bool = False, **scene: object) -> Scene:
    """The beam of the paper's section 3.3, from x = 0 to its length, free at both ends.

    Args:
        layers: Particles through the thickness.
        nodes: Whether a column of particles lies on each end section.
        scene: Fields of the scene.
    """
    shape = Box(size=(LENGTH, THICKNESS), center=(0.5 * LENGTH, 0.0))
    body = Body(name="beam", shape=shape, material=RUBBER, spacing=THICKNESS / layers, node_axes=(0,) if nodes else ())
    return Scene(**{"bodies": (body,), "duration": 1.0, "plane": "stress", "elasticity": SPRINGS, **scene})  # type: ignore[arg-type]


def ends(reach: float = 1e-4) -> tuple[Box, Box]:
    """The two end sections of the beam.

    Args:
        reach: How far the boxes reach into the beam [m].
    """
    size = (2.0 * reach, 2.0 * THICKNESS)
    return Box(size=size, center=(0.0, 0.0)), Box(size=size, center=(LENGTH, 0.0))


def corners(layers: int) -> tuple[Box, Box]:
    """Boxes about the two particles at the bottom corners of the beam."""
    spacing = THICKNESS / layers
    middle = 0.5 * (spacing - THICKNESS)
    return tuple(Box(size=(spacing, spacing), center=(x, middle)) for x in (0.5 * spacing, LENGTH - 0.5 * spacing))  # type: ignore[return-value]


def bar(layers: int, **scene: object) -> Scene:
    """A 3-D bar of 0.5 x 0.05 x 0.05 m, free at both ends."""
    body = Body(
        name="bar", shape=Box(size=(0.5, 0.05, 0.05)), material=Material(1000.0, 1e5, 0.3), spacing=0.05 / layers
    )
    return Scene(**{"bodies": (body,), "duration": 1.0, "dimension": 3, "elasticity": SPRINGS, **scene})  # type: ignore[arg-type]


def block(dimension: int, cells: tuple[int, ...] = (4, 3, 2), *, material: Material = RUBBER, **fields: object) -> Body:
    """A block of a few particles, spacing 1 cm, centred on the origin unless a shape is given."""
    size = [0.01 * number for number in cells[:dimension]]
    return Body(**{"name": "block", "shape": Box(size=size), "material": material, "spacing": 0.01, **fields})  # type: ignore[arg-type]


def scene_of(*bodies: Body, dimension: int = 2, duration: float = 0.1, **scene: object) -> Scene:
    """A scene of some bodies."""
    fields = {"bodies": bodies, "dimension": dimension, "duration": duration, "elasticity": SPRINGS, **scene}
    return Scene(**fields)  # type: ignore[arg-type]


def elasticities() -> list[Elasticity]:
    """Choices of the model that tests go through."""
    return [
        Elasticity(model="springs", effective_radius=radius, normalization=normalization)
        for radius in (1.5, 2.1)
        for normalization in ("lattice", "particle")
    ]


def random(*shape: int, seed: int = 0) -> np.ndarray:
    """Numbers between -1 and 1."""
    return np.random.default_rng(seed).uniform(-1.0, 1.0, shape)


def angular_momentum(simulation: Simulation) -> np.ndarray:
    """Angular momentum about the origin, of the particles' paths and of their own rotation, shape [1] or [3]."""
    particles = simulation.particles
    moments = cross(simulation.positions, simulation.velocities) * particles.masses[:, None]
    inertia = particles.masses * particles.spacings**2 / 6.0
    return (moments + inertia[:, None] * simulation.angular_velocities).sum(axis=0)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products, shape [n, 1] in 2-D and [n, 3] in 3-D."""
    if a.shape[1] == 3:
        return np.cross(a, b)
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])[:, None]


def short_run(steps: int) -> Simulation:
    """A run of so many steps."""
    return Simulation(scene_of(block(2, velocity=(1.0, 0.0)), time_step=1e-6, duration=steps * 1e-6))

"""A run that never ran: scenes, particles and moments made up for the tests of the observers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.scene import Body, Material, Probe, Scene, Support
from warp_mps.shapes import Box

RUBBER = Material(1000.0, 1e6, 0.3)
REST = Energy(kinetic=0.0, elastic=0.0, contact=0.0, potential=0.0, work=0.0, dissipated=0.0)


def blocks(dimension: int = 2, *, probes: tuple[Probe, ...] = (), **scene: object) -> Scene:
    """Two blocks of 4 particles a side, 0.1 m apart, particle spacing 0.1 m; the left face of the first is held."""
    edge, zero = [0.4] * dimension, [0.0] * (dimension - 1)
    bodies = tuple(
        Body(name=name, shape=Box(size=edge, center=[x, *zero]), material=RUBBER, spacing=0.1)
        for name, x in (("left", 0.0), ("right", 0.5))
    )
    held = Support(name="wall", region=Box(size=[0.1] + [1.0] * (dimension - 1), center=[-0.2, *zero]))
    return Scene(bodies=bodies, duration=1.0, dimension=dimension, supports=(held,), probes=probes, **scene)  # type: ignore[arg-type]


@dataclass(kw_only=True)
class FakeView:
    """A moment, at rest in the reference configuration where nothing else is said."""

    scene: Scene
    particles: Particles
    time: float = 0.0
    step: int = 0
    total_steps: int = 100
    substeps: int = 1
    energy: Energy = REST
    energy_of_bodies: Energy | None = None
    displacements: np.ndarray = field(init=False)
    velocities: np.ndarray = field(init=False)
    rotations: np.ndarray = field(init=False)
    angular_velocities: np.ndarray = field(init=False)
    contact_forces: np.ndarray = field(init=False)
    reactions: np.ndarray = field(init=False)
    pressures: np.ndarray = field(init=False)
    volumes: np.ndarray = field(init=False)
    stresses: np.ndarray = field(init=False)
    strains: np.ndarray = field(init=False)
    von_mises: np.ndarray = field(init=False)
    strain_energy_densities: np.ndarray = field(init=False)
    elastic_forces: np.ndarray = field(init=False)
    internal_forces: np.ndarray = field(init=False)
    elastic_torques: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        count, dimension = self.particles.positions.shape
        for name in ("displacements", "velocities", "contact_forces", "reactions", "elastic_forces", "internal_forces"):
            setattr(self, name, np.zeros((count, dimension)))
        self.elastic_torques = np.zeros((count, 2 * dimension - 3))
        self.stresses, self.strains = np.zeros((2, count, 3, 3))
        self.von_mises, self.strain_energy_densities = np.zeros((2, count))
        self.rotations = np.zeros((count, 2 * dimension - 3))
        self.angular_velocities = np.zeros((count, 2 * dimension - 3))
        self.pressures, self.volumes = np.zeros((2, count))

    @property
    def steps_done(self) -> int:
        """Time steps, of which a step of the run takes some."""
        return self.substeps * self.step

    @property
    def positions(self) -> np.ndarray:
        """Positions [m]."""
        return self.particles.positions + self.displacements

    def state_arrays(self) -> dict[str, np.ndarray]:
        """A state."""
        return {"displacements": self.displacements.copy(), "velocities": self.velocities.copy()}


def view_of(scene: Scene, **values: object) -> FakeView:
    """A moment of a scene at rest."""
    return FakeView(scene=scene, particles=fill_scene(scene), **values)  # type: ignore[arg-type]

"""Parts of the elastic bodies of a scene on a device: constants, state of the particles, model, boundary, contact."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.boundary.body_forces import make_body_forces
from warp_mps.elastic.boundary.conditions import BoundaryConditions
from warp_mps.elastic.contact.model import Contacts, needs_contact
from warp_mps.elastic.contact.walls import Walls
from warp_mps.elastic.damping.model import make_viscosity
from warp_mps.elastic.model_choice import make_model
from warp_mps.elastic.output.inversions import Inversions
from warp_mps.elastic.state import ElasticState, initial_state
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class SolidParts:
    """Constants, state and parts of the elastic bodies of a scene and of the walls that they touch.

    Walls come last among the particles: models and motion run over the e particles before them, contact over all n.
    A part that the scene lacks is None.

    Attributes:
        particles:    The particles.
        types:        Number types.
        device:       Warp device.
        dt:           Time step [s].
        count:        Number e of elastic particles.
        damping:      Mass-proportional damping [1/s].
        gravity:      Acceleration of gravity [m/s^2],              vec
        masses:       Masses, 0 of walls [kg],                      float64 array, shape [n]
        mass:         The same on the device [kg],                  real [n]
        inverse_mass: Inverse masses, 0 along held axes [1/kg],     vec [n]
        state:        Displacements, velocities and forces.
        boundary:     Supports and loads.
        model:        The elastic model.
        inversions:   What is turned inside out.
        viscosity:    Kelvin-Voigt damping of the materials.
        walls:        The walls.
        contacts:     Contact, with its friction.
        body_forces:  Forces per mass that depend on place and time.
        external:     Forces beside those of the scene [N],         vec [n]

    Args:
        scene: The case.
        particles: Its particles.
        dt: Time step [s].
        types: Number types.
        device: Warp device.
        loaded: Whether there are external forces.
    """

    def __init__(
        self, scene: Scene, particles: Particles, *, dt: float, types: NumericTypes, device: Any, loaded: bool = False
    ) -> None:
        self.particles, self.types, self.device, self.dt = particles, types, device, dt
        self.count, self.damping = particles.elastic, scene.damping
        self.gravity = types.vec(*scene.gravity) if len(scene.gravity) else types.vec()
        self.state: ElasticState = initial_state(particles, types=types, device=device)
        self.boundary = BoundaryConditions(scene, particles, dt=dt, types=types, device=device)
        held_rotation = self.boundary.held_rotation[: self.count]
        elastic = particles.elastic_part()
        self.model = make_model(scene, elastic, held_rotation, types=types, device=device)
        self.inversions = Inversions(scene, elastic, self.model, types=types, device=device)
        self.viscosity = make_viscosity(scene, elastic, self.model, types=types, device=device)
        self.walls = Walls(scene, particles, dt=dt, types=types, device=device) if scene.walls else None
        self.contacts = (
            Contacts(scene, particles, types=types, device=device) if needs_contact(scene, particles) else None
        )
        # a wall moves as prescribed, whatever forces act on it: it has no inertia, no weight and no energy
        self.masses = np.where(np.arange(particles.count) < self.count, particles.masses, 0.0)
        self.mass = wp.array(self.masses, dtype=types.real, device=device)
        inverse_mass = ~self.boundary.held / particles.masses[:, None]
        inverse_mass[self.count :] = 0.0
        self.inverse_mass = wp.array(inverse_mass, dtype=types.vec, device=device)
        self.body_forces = make_body_forces(scene, particles, self.mass, types=types, device=device)
        self.external: wp.array | None = wp.zeros(particles.count, dtype=types.vec, device=device) if loaded else None
        # held particles start at rest; moving supports set their own velocity
        velocities = np.where(self.boundary.held, 0.0, particles.velocities)
        self.state.v.assign(velocities.astype(self.state.v.numpy().dtype))

    @property
    def does_work(self) -> bool:
        """Whether anything depends on time or does work: moving supports, loads, moving walls or body forces."""
        return self.boundary.moving or bool(self.walls and self.walls.moving) or self.body_forces is not None

    def evaluate_model(self) -> None:
        """Launch the elastic forces of the model at the present displacements."""
        for _, launch in self.model.passes:
            launch(self.state, 0, self.count)

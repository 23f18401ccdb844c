"""The elastic bodies of a scene on a device: one step of them, and what can be asked of them."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warp_mps.core.neighbours import METHOD as NEIGHBOURS
from warp_mps.core.neighbours import neighbour_kernels
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.boundary.body_forces import make_body_forces
from warp_mps.elastic.boundary.boundary_kernels import METHOD, boundary_kernels
from warp_mps.elastic.boundary.conditions import BoundaryConditions
from warp_mps.elastic.contact.friction_kernels import friction_kernels
from warp_mps.elastic.contact.kernels import contact_kernels
from warp_mps.elastic.contact.model import Contacts, needs_contact
from warp_mps.elastic.contact.search_kernels import search_kernels
from warp_mps.elastic.contact.walls import Walls
from warp_mps.elastic.damping.kernels import viscous_kernels
from warp_mps.elastic.damping.model import make_viscosity
from warp_mps.elastic.explicit.kernels import motion_kernels
from warp_mps.elastic.hamiltonian.kernels import hamiltonian_kernels
from warp_mps.elastic.model_choice import make_model
from warp_mps.elastic.output.energies import CHUNK, energy_kernels
from warp_mps.elastic.output.stresses import StressFields, stress_kernels
from warp_mps.elastic.springs.kernels import spring_kernels
from warp_mps.elastic.springs.rotation_kernels import rotation_kernels
from warp_mps.elastic.state import ElasticState, initial_state
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.scene import Scene

KERNELS = (
    *(spring_kernels, rotation_kernels, hamiltonian_kernels),
    *(motion_kernels, boundary_kernels, search_kernels, contact_kernels, energy_kernels, stress_kernels),
    *(viscous_kernels, friction_kernels),
)


class Phase(NamedTuple):
    """A part of a step.

    Attributes:
        name: What it does.
        launch: Launches it over `count` particles from `first` on; over all of them where it does not split.
        splits: Whether threads can share its particles.
        follows: Whether it needs nothing of other particles that the phase before it writes, so that a thread can go
            on to it without waiting for the others.
        on_host: Whether it runs on the host, so that no graph can hold it.
    """

    name: str
    launch: Callable[[int, int], None]
    splits: bool = False
    follows: bool = False
    on_host: bool = False


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare every kernel of a types, so that each module is compiled once, and return the modules' names."""
    for declare in KERNELS:
        declare(types)
    # the reference neighbours are searched in double precision whatever the run's
    double = replace(types, precision="float64")
    neighbour_kernels(double)
    return [types.module(METHOD), double.module(NEIGHBOURS)]


class Solid:
    """The elastic bodies of a scene and the walls that they touch: constants, state, and the launches of a step.

    Walls come last among the particles: the models and the motion run over those before them, contact over all.

    A step is the same Python whether it is run eagerly or captured: it reads nothing back and allocates nothing.

    Attributes:
        external: Forces on the particles beside those of the scene [N], vec [n]; None if there never are any.

    Args:
        scene: The case.
        particles: Its particles.
        dt: Time step [s].
        types: Number types.
        device: Warp device.
        loaded: Whether there are external forces.
        retardation_time: Of a numerical viscosity proportional to the stiffness, whatever the model [s]; its force is
            that of the step before.
    """

    external: wp.array | None

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        dt: float,
        types: NumericTypes,
        device: Any,
        loaded: bool = False,
        retardation_time: float = 0.0,
    ) -> None:
        self._types, self._device, self._dt = types, device, dt
        self._n = particles.elastic
        self._motion, self._sums = motion_kernels(types), energy_kernels(types)
        self.state: ElasticState = initial_state(particles, types=types, device=device)
        self.boundary = BoundaryConditions(scene, particles, dt=dt, types=types, device=device)
        held_rotation = self.boundary.held_rotation[: self._n]
        self.model = make_model(scene, particles.elastic_part(), held_rotation, types=types, device=device)
        self.viscosity = make_viscosity(scene, particles.elastic_part(), self.model, types=types, device=device)
        self.walls = Walls(scene, particles, dt=dt, types=types, device=device) if scene.walls else None
        self.contacts = (
            Contacts(scene, particles, types=types, device=device) if needs_contact(scene, particles) else None
        )
        # a wall is moved whatever acts on it: it has no inertia, no weight and no energy
        self._masses = np.where(np.arange(particles.count) < self._n, particles.masses, 0.0)
        self._damping, self._particles = scene.damping, particles
        self._gravity = types.vec(*scene.gravity) if len(scene.gravity) else types.vec()
        self._mass = wp.array(self._masses, dtype=types.real, device=device)
        inverse_mass = ~self.boundary.held / particles.masses[:, None]
        inverse_mass[self._n :] = 0.0
        self.body_forces = make_body_forces(scene, particles, self._mass, types=types, device=device)
        self._moving = self.boundary.moving or bool(self.walls and self.walls.moving) or self.body_forces is not None
        self._inverse_mass = wp.array(inverse_mass, dtype=types.vec, device=device)
        self._values = wp.zeros((4, particles.count), dtype=types.real, device=device)
        self._chunks = wp.zeros((4, -(-particles.count // CHUNK)), dtype=wp.float64, device=device)
        self._hold_still(particles)
        self._retardation = retardation_time / dt
        retarded = self._n if retardation_time else 0
        # elastic and viscous force of the last step
        self._retarded = [wp.zeros(retarded, dtype=types.vec, device=device) for _ in range(2)]
        self.external = wp.zeros(particles.count, dtype=types.vec, device=device) if loaded else None
        self.phases = self._make_phases()

    def start(self) -> None:
        """Evaluate the forces of the initial state, which the first step begins with."""
        self._place()
        if self.contacts:
            self.contacts.initialize(self.state)
        for _, launch in self.model.passes:
            launch(self.state, 0, self._n)
        if self.viscosity:
            self.viscosity.launch_stress(self.state, 0.0, 0, self._n)
            self.viscosity.launch_force(self.state, 0, self._n)
        if self._retardation:
            wp.copy(self._retarded[0], self.state.force, count=self._n)
        if self.contacts:
            self._touch(self.contacts)
        self.boundary.push(self.state.force, self._mass)
        if self.body_forces:
            self.body_forces.apply(self.state, 0.0, self.state.force)
        self._kick(0.0, 0, self._n)
        self._account(0.0)

    def step(self) -> None:
        """Advance by one time step."""
        self.launch(self.phases)

    def launch(self, phases: Sequence[Phase]) -> None:
        """Launch phases of a step over all particles."""
        for phase in phases:
            phase.launch(0, self._n)

    def sections(self) -> list[list[Phase]]:
        """The phases of a step in groups: threads must wait for each other between two groups."""
        groups: list[list[Phase]] = []
        for phase in self.phases:
            if groups and (phase.follows or not phase.splits) and groups[-1][-1].splits == phase.splits:
                groups[-1].append(phase)
            else:
                groups.append([phase])
        return groups

    def _make_phases(self) -> list[Phase]:
        """The phases of a step, in order; what a scene does not have, it does not pay for."""
        rotation, state, contacts, viscosity = self.model.rotation, self.state, self.contacts, self.viscosity
        phases = [Phase("drift", self._drift, splits=True)]
        if rotation:
            phases.append(
                Phase("rotation drift", functools.partial(rotation.drift, self._dt), splits=True, follows=True)
            )
        if self._moving:
            phases.append(Phase("drive", lambda *_: self._drive()))
        if contacts:
            phases.append(Phase("contact search", lambda *_: contacts.locate(state)))
        passes = [Phase(name, functools.partial(launch, state), splits=True) for name, launch in self.model.passes]
        if viscosity:
            # the first needs no more than the stresses of the particle itself, the second what the forces waited for
            launches = {
                "viscous stress": functools.partial(viscosity.launch_stress, state, self._dt),
                "viscous force": functools.partial(viscosity.launch_force, state),
            }
            viscous = [Phase(name, launch, splits=True, follows=True) for name, launch in launches.items()]
            passes = [phase for pair in zip(passes, viscous, strict=True) for phase in pair]
        phases += passes
        if self._retardation:
            phases.append(Phase("retard", self._retard, splits=True, follows=True))
        if contacts:
            phases.append(Phase("contact", lambda *_: self._touch(contacts)))
        if self.boundary.moving:
            phases.append(Phase("push", lambda *_: self.boundary.push(state.force, self._mass)))
        if self.external is not None:
            phases.append(Phase("external", lambda *_: self._add_external()))
        phases += self._body_force_phases()
        phases.append(Phase("kick", functools.partial(self._kick, self._dt), splits=True, follows=True))
        if rotation:
            phases.append(Phase("rotation kick", functools.partial(rotation.kick, self._dt), splits=True, follows=True))
        damp = [Phase("damp", lambda *_: self._damp())] if self._damping else []
        phases = [*damp, *phases, *damp]
        if self._moving:
            # after the damping, for a step's work is that of the velocities at its two ends
            phases.append(Phase("work", lambda *_: self._account(self._dt)))
        return phases

    def _body_force_phases(self) -> list[Phase]:
        """Body forces at the new places, Python functions first."""
        if not (forces := self.body_forces):
            return []
        state, steps, dt = self.state, self.boundary.steps, self._dt

        def evaluate(*_: int) -> None:
            forces.evaluate(state, float(steps.numpy()[0]) * dt)

        on_host = [Phase("body force on the host", evaluate, on_host=True)] if forces.on_host else []
        return [*on_host, Phase("body force", lambda *_: forces.launch(state, steps, dt, state.force))]

    def energy(self) -> Energy:
        """Energies of the present state."""
        state, values = self.state, self._values
        inputs = [self._gravity, self._mass, state.u, state.v]
        wp.launch(self._sums.particle_energies, self._n, inputs, [values[0], values[1]], device=self._device)
        if self.model.rotation:
            self.model.rotation.add_kinetic(values[0])
        self.model.launch_energy(state, values[2])
        if self.contacts:
            self.contacts.launch_energy(state, values[3])
        for k in range(4):
            sums = self._chunks[k]
            wp.launch(self._sums.chunk_sums, len(sums), [values[k]], [sums], device=self._device)
        kinetic, potential, elastic, contact = self._chunks.numpy().sum(axis=1)
        return Energy(
            kinetic=float(kinetic),
            elastic=float(elastic),
            contact=float(contact),
            potential=float(potential),
            work=self.work(),
            dissipated=float(np.sum(state.dissipated.numpy().astype(float))),
        )

    def work(self) -> float:
        """Work done from outside so far [J]."""
        parts = (self.boundary, self.walls, self.body_forces)
        return float(sum(part.work() for part in parts if part))

    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self.state.u.numpy().astype(float)

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self.state.v.numpy().astype(float)

    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, d]."""
        return self.state.contact.numpy().astype(float)

    def number_densities(self) -> np.ndarray:
        """1, for nothing here is a fluid [-], shape [n]."""
        return np.ones(len(self.state.u))

    def volumes(self) -> np.ndarray:
        """0, for nothing here is a fluid [m^d], shape [n]."""
        return np.zeros(len(self.state.u))

    def trouble(self) -> str | None:
        """Why the run cannot go on, if it cannot: a contact lacks room."""
        if not self.contacts or (particle := self.contacts.overflowed()) is None:
            return None
        return (
            f"{self._particles.describe(particle)} meets more particles of other bodies than a contact can hold: the "
            "bodies are crushed into each other; stiffen the contact"
        )

    def reactions(self) -> np.ndarray:
        """Force that the supports exert on each particle: m a - f on the held axes [N], shape [n, d]."""
        inertial = self._masses[:, None] * self.state.driven.numpy()
        return np.where(self.boundary.held, inertial - self.state.force.numpy(), 0.0)

    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces: the total force less weight and loads [N], shape [n, d]."""
        weight = np.outer(self._masses, [float(g) for g in self._gravity])
        loads = wp.zeros_like(self.state.force)
        self.boundary.push(loads, self._mass)
        if self.external is not None:
            wp.launch(self._motion.add, self._n, [self.external], [loads], device=self._device)
        if self.body_forces:
            wp.launch(self._motion.add, self._n, [self.body_forces.force], [loads], device=self._device)
        return self.state.force.numpy().astype(float) - weight - loads.numpy()

    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        rotation = self.model.rotation
        torques = (
            rotation.torque.numpy().astype(float) if rotation else np.zeros((self._n, 2 * self._types.dimension - 3))
        )
        return self._with_walls(torques)

    def stress_fields(self) -> StressFields:
        """Stresses and strains of the present state."""
        return StressFields(*map(self._with_walls, self.model.stress_fields(self.state)))

    def energy_densities(self) -> np.ndarray:
        """Strain energy of each particle per reference volume [J/m^3], shape [n]."""
        return self._with_walls(self.model.energy_densities(self.state))

    def pressures(self) -> np.ndarray:
        """Pressures at the last evaluation of the forces [Pa], shape [n]."""
        return self._with_walls(self.model.pressures())

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._with_walls(self.model.rotations(), self.walls.turns()[0] if self.walls else None)

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        rotation = self.model.rotation
        omega = rotation.omega.numpy().astype(float) if rotation else np.zeros((self._n, 2 * self._types.dimension - 3))
        return self._with_walls(omega, self.walls.turns()[1] if self.walls else None)

    def evolving(self) -> list[wp.array]:
        """Device arrays of everything that evolves: a step goes on from their contents."""
        parts: tuple[Any, ...] = (self.state, self.boundary, self.model.rotation, self.viscosity, self.walls)
        parts += (self.contacts, self.body_forces)
        return [*(array for part in parts if part for array in part.evolving()), *self._retarded]

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        rotation = self.model.rotation.arrays() if self.model.rotation else {}
        viscous = self.viscosity.arrays() if self.viscosity else {}
        walls = self.walls.arrays() if self.walls else {}
        contact = self.contacts.arrays() if self.contacts else {}
        forces = self.body_forces.arrays() if self.body_forces else {}
        retarded = {"retarded": np.stack([array.numpy() for array in self._retarded])} if self._retardation else {}
        return {
            **self.state.arrays(),
            **rotation,
            **viscous,
            **self.boundary.arrays(),
            **walls,
            **contact,
            **forces,
            **retarded,
        }

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.state.assign(arrays)
        self.boundary.assign(arrays)
        if self.model.rotation:
            self.model.rotation.assign(arrays)
        if self.viscosity:
            self.viscosity.assign(arrays)
        if self.body_forces:
            self.body_forces.assign(arrays)
        if self._retardation:
            for array, values in zip(self._retarded, arrays["retarded"], strict=True):
                array.assign(values)
        if self.walls:
            self.walls.assign(arrays, self.boundary.steps)
        # what a step makes anew, but a look at this moment needs already
        self.model.passes[0][1](self.state, 0, self._n)
        if self.contacts:
            self.contacts.assign(arrays)
            self.contacts.initialize(self.state)

    def _with_walls(self, elastic: np.ndarray, walls: np.ndarray | None = None) -> np.ndarray:
        """Values of the elastic particles, followed by those of the walls, which are 0 if not given."""
        if not self.walls:
            return elastic
        return np.concatenate(
            (elastic, np.zeros((len(self._masses) - self._n, *elastic.shape[1:])) if walls is None else walls)
        )

    def _drift(self, first: int, count: int) -> None:
        inputs = [first, self._dt, self._inverse_mass, self.state.force]
        wp.launch(self._motion.drift, count, inputs, [self.state.u, self.state.v], device=self._device)

    def _drive(self) -> None:
        wp.launch(self._motion.tick, 1, [self.boundary.steps], device=self._device)
        self._place()

    def _place(self) -> None:
        """Place what moves as prescribed: supported particles and walls."""
        self.boundary.drive(self.state, self._mass)
        if self.walls:
            self.walls.drive(self.state, self.boundary.steps)

    def _touch(self, contacts: Contacts) -> None:
        """Add the contact forces."""
        if self.walls:
            self.walls.clear(self.state)
        contacts.launch_force(self.state)

    def _account(self, dt: float) -> None:
        """Add the work of a step from outside."""
        self.boundary.account(self.state, self._mass, dt)
        if self.body_forces:
            self.body_forces.account(self.state.v, dt)
        if self.walls:
            self.walls.account(self.state)

    def _kick(self, dt: float, first: int, count: int) -> None:
        inputs = [first, dt, self._gravity, self._mass, self._inverse_mass]
        wp.launch(self._motion.kick, count, inputs, [self.state.force, self.state.v], device=self._device)

    def _retard(self, first: int, count: int) -> None:
        inputs = [first, self._dt, self._retardation, self.state.v]
        outputs = [*self._retarded, self.state.force, self.state.dissipated]
        wp.launch(self._motion.retard, count, inputs, outputs, device=self._device)

    def _add_external(self) -> None:
        wp.launch(self._motion.add, self._n, [self.external], [self.state.force], device=self._device)

    def _damp(self) -> None:
        factor = float(np.exp(-0.5 * self._damping * self._dt))
        state = self.state
        inputs = [factor, self._mass, self._inverse_mass]
        wp.launch(self._motion.damp, self._n, inputs, [state.v, state.dissipated], device=self._device)
        if self.model.rotation:
            self.model.rotation.damp(factor, state.dissipated)

    def _hold_still(self, particles: Particles) -> None:
        """Held particles start at rest; moving supports set their own velocity."""
        velocities = np.where(self.boundary.held, 0.0, particles.velocities)
        self.state.v.assign(velocities.astype(self.state.v.numpy().dtype))

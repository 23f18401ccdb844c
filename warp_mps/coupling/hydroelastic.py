"""Fluids and elastic bodies in strong coupling, as a simulation sees them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.integrator_choice import substep, takes_implicit_steps
from warp_mps.coupling.interface import Markers
from warp_mps.coupling.interface_kernels import interface_kernels
from warp_mps.coupling.robin_kernels import METHOD, robin_kernels
from warp_mps.coupling.step import CoupledStep
from warp_mps.coupling.structures import ImplicitStructure, Structure, SubsteppedStructure
from warp_mps.elastic.implicit.solid import ImplicitSolid
from warp_mps.elastic.output.stresses import StressFields
from warp_mps.errors import InputError
from warp_mps.fluid.fluids import Fluids
from warp_mps.fluid.time_loop import TimeLoop
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.scene import BodyForce, Scene
from warp_mps.scene.validation.rules import place

# relative residual of the bodies' linear systems: every pass starts close to their solutions
LINEAR_TOLERANCE = 1e-3


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare the kernels of the coupling, and return the names of their modules."""
    robin_kernels(types)
    interface_kernels(types)
    return [types.module(METHOD)]


class Hydroelastic:
    """The elastic bodies, the walls and the fluids of a scene: n particles, in the order of the scene.

    It is a `warp_mps.run.system.PacedSystem`, which documents its methods.

    Attributes:
        particles: The particles, in the order of the scene.
        fluids: The fluids, between its walls and the markers.
        markers: The markers of the bodies.
        step: The coupled step of both.
        structure: The bodies over a step of the fluid.
        solid: The bodies, and the walls that they may touch.
        implicit: Whether the bodies take implicit steps.

    Args:
        scene: The case.
        particles: Its particles.
        interval: Time between two samples [s].
        types: Number types.
        device: Warp device.
        graphs: Whether steps are replayed as graphs.

    Raises:
        InputError: The domain of the scene does not hold its fluids, or supports and loads do not fit its particles.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        interval: float,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
    ) -> None:
        self.particles = particles
        self.implicit = takes_implicit_steps(scene)
        markers = Markers(particles, scene.fluids[0].spacing, types=types, device=device)
        self.structure = self._make_structure(scene, particles, interval, types, device, graphs)
        self.solid = self.structure.solid
        self.fluids = Fluids(scene, markers.particles, types=types, device=device, graphs=graphs)
        self.step = CoupledStep(self.fluids, markers, self.structure)
        self.markers = markers
        self._loop = TimeLoop(self.fluids.step, find_failure=self.step.find_failure, take_step=self.step.take)
        self._source = place(scene.fluids[0], "fluid")

    def _make_structure(
        self, scene: Scene, particles: Particles, interval: float, types: NumericTypes, device: Any, graphs: bool
    ) -> Structure:
        dry: dict[str, Any] = {"fluids": (), "probes": (), "measurements": ()}
        dry["body_forces"] = tuple(_on_bodies(scene))
        options: dict[str, Any] = {"types": types, "device": device, "graphs": graphs}
        if self.implicit:
            alone = replace(scene, walls=(), integrator="implicit", time_step=interval, **dry)
            part = particles.elastic_part()
            solid = ImplicitSolid(alone, part, dt=interval, linear_tolerance=LINEAR_TOLERANCE, **options)
            return ImplicitStructure(solid)
        dt, tau = substep(scene, particles, interval)
        alone = replace(scene, integrator="explicit", time_step=dt, **dry)
        return SubsteppedStructure(alone, particles.dry_part(), dt=dt, retardation_time=tau, **options)

    def start(self) -> None:
        """Evaluate what the first step begins with.

        Raises:
            InputError: The fluids have no free surface.
        """
        self.solid.start()
        self.step.place_markers()
        self.fluids.start()
        # a closed fluid finds its volume, which no particles hold exactly, in the bodies
        if self.fluids.step.is_closed():
            reason = "leaves no free surface between walls and elastic bodies: give the water some room"
            raise InputError(self._source, "shape", reason)

    def advance(self, time: float) -> int:
        """Advance to a time [s], and return the number of steps of the fluid.

        Raises:
            RunError: A step of the bodies was not solved, the passes diverged, or a fluid particle ran away.
        """
        return self._loop.advance(time)

    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self._with_bodies(self.fluids.displacements(), self.solid.displacements())

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._with_bodies(self.fluids.velocities(), self.solid.velocities())

    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._with_bodies(self.fluids.rotations(), self.solid.rotations())

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._with_bodies(self.fluids.angular_velocities(), self.solid.angular_velocities())

    def pressures(self) -> np.ndarray:
        """Pressures: of the material in bodies, of the fluid beside them on walls [Pa], shape [n]."""
        return self._with_bodies(self.fluids.pressures(), self.solid.pressures())

    def number_densities(self) -> np.ndarray:
        """Number densities of fluids in units of a full lattice's, else 1 [-], shape [n]."""
        return self._with_bodies(self.fluids.number_densities(), self.solid.number_densities())

    def volumes(self) -> np.ndarray:
        """Volumes that particles of fluids take up, else 0 [m^d], shape [n]."""
        return self._with_bodies(self.fluids.volumes(), self.solid.volumes())

    def stress_fields(self) -> StressFields:
        """Stresses and strains."""
        wet, dry = self.fluids.stress_fields(), self.solid.stress_fields()
        return StressFields(*map(self._with_bodies, wet, dry))

    def energy_densities(self) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""
        return self._with_bodies(self.fluids.energy_densities(), self.solid.energy_densities())

    def contact_forces(self) -> np.ndarray:
        """Forces of contact now, and mean forces of the fluid over the last interval [N], shape [n, d]."""
        wet = self.fluids.contact_forces()
        forces = self._with_bodies(wet, self._distributed(wet[: self.markers.count]))
        touching = self.solid.contact_forces()
        forces[: len(touching)] += touching
        return forces

    def internal_forces(self) -> np.ndarray:
        """Forces of the particles on each other [N], shape [n, d]."""
        wet = self.fluids.internal_forces()
        forces = self._with_bodies(wet, self._distributed(wet[: self.markers.count]))
        elastic = self.solid.internal_forces()
        forces[: len(elastic)] += elastic
        return forces

    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._with_bodies(self.fluids.elastic_torques(), self.solid.elastic_torques())

    def reactions(self) -> np.ndarray:
        """Forces that supports exert on the particles [N], shape [n, d]."""
        return self._with_bodies(self.fluids.reactions(), self.solid.reactions())

    def energy(self) -> Energy:
        """Energies of fluid and bodies; the work is that of walls, supports and loads."""
        wet, dry, count = self.fluids.energy(), self.solid.energy(), self.markers.count
        # the work of fluid and bodies on each other is internal
        exchanged = float(self.fluids.state.work.numpy()[:count].sum())
        pressed, _, held = (float(work.numpy().sum()) for work in self.step.works)
        # implicit steps count the work of pressures as external; a support returns what it takes up
        inner = held + (pressed if self.implicit else 0.0)
        return Energy(
            kinetic=wet.kinetic + dry.kinetic,
            elastic=dry.elastic,
            contact=dry.contact,
            potential=wet.potential + dry.potential,
            work=wet.work - exchanged + dry.work - inner,
            dissipated=wet.dissipated + dry.dissipated,
        )

    def energy_of_bodies(self) -> Energy:
        """Energies of the bodies alone; the work is that of water, walls, supports and loads on them."""
        dry = self.solid.energy()
        pressed, collided, _ = (float(work.numpy().sum()) for work in self.step.works)
        # implicit steps count the work of pressures as external; supports take up collisions on the axes that they hold
        return replace(dry, work=dry.work + collided + (0.0 if self.implicit else pressed))

    def trouble(self) -> str | None:
        """Why the run cannot go on, if it cannot."""
        return self.fluids.trouble() or self.solid.trouble()

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of the solvers and of the passes."""
        work = {"work_on_bodies": float(sum(work.numpy().sum() for work in self.step.works))}
        coupling = {**self.step.passes.statistics.record(), **work}
        solver = self.solid.record() if isinstance(self.solid, ImplicitSolid) else {}
        return {**self.fluids.record(), **solver, "coupling": coupling}

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        wet = {f"water_{name}": array for name, array in {**self.fluids.arrays(), **self.step.arrays()}.items()}
        return {**wet, **{f"bodies_{name}": array for name, array in self.structure.arrays().items()}}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""

        def own(prefix: str) -> dict[str, np.ndarray]:
            return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}

        self.structure.assign(own("bodies_"))
        wet = own("water_")
        self.fluids.assign(wet)
        self.step.assign(wet)

    def _with_bodies(self, wet: np.ndarray, dry: np.ndarray) -> np.ndarray:
        """Values of the elastic particles from the bodies, and of walls and fluid particles from the fluids."""
        return np.concatenate((dry[: self.particles.elastic], wet[self.markers.count :]))

    def _distributed(self, values: np.ndarray) -> np.ndarray:
        """Values of the markers distributed evenly to their particles."""
        return self.markers.distribute(values)


def _on_bodies(scene: Scene) -> Iterator[BodyForce]:
    """The body forces of a scene as they act on its elastic bodies alone."""
    bodies = {body.name for body in scene.bodies}
    for force in scene.body_forces:
        names = tuple(name for name in force.acts_on if name in bodies)
        if names or not force.acts_on:
            yield replace(force, acts_on=names)

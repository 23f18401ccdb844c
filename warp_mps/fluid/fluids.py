"""The fluids of a scene between its walls, as a simulation sees them."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_mps.core.linear.conjugate_gradient import Statistics
from warp_mps.core.linear.conjugate_gradient import declare_kernels as declare_solver
from warp_mps.core.multigrid.preconditioner import declare_kernels as declare_multigrid
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.output.stresses import StressFields
from warp_mps.fluid import METHOD
from warp_mps.fluid.failures import FluidFailures
from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.model import fluid_model
from warp_mps.fluid.readings import FluidReadings
from warp_mps.fluid.step import FluidStep
from warp_mps.fluid.time_loop import TimeLoop
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.scene import Scene
from warp_mps.walls.poses import declare_walls


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare every kernel that fluids need, and return the names of their modules."""
    fluid_kernels(types)
    return [types.module(METHOD), *declare_solver(types), *declare_multigrid(types), declare_walls(types)]


class Fluids:
    """The fluids of a scene and the walls that hold them: constants, state, step, readings and failures together.

    It is a `warp_mps.run.system.PacedSystem`, which documents its methods.

    Attributes:
        model: Constants of the run.
        state: State of the fluid.
        step: The phases of a step.
        readings: Quantities of the particles, and energies.
        failures: Detection of failures.

    Args:
        scene: The case.
        particles: Its particles; walls come first, fluids last.
        types: Number types.
        device: Warp device.
        graphs: Whether steps are replayed as graphs.

    Raises:
        InputError: The domain of the scene does not hold its fluids.
    """

    def __init__(
        self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any, graphs: bool = True
    ) -> None:
        self.model = fluid_model(scene, particles, types=types, device=device)
        self.step = FluidStep(scene, self.model, graphs=graphs)
        self.state = self.step.state
        self.readings = FluidReadings(self.step)
        self.failures = FluidFailures(self.step)
        self._loop = TimeLoop(self.step, find_failure=self.failures.after_step)

    def start(self) -> None:
        """Place the walls, and find the neighbours and body forces of the initial state."""
        self.step.wall_motion.place(self.state.time)
        if self.step.body_forces:
            self.step.time_step.longest = min(self.step.time_step.longest, self.step.body_forces.start())
        self.step.renew_neighbours()

    def advance(self, time: float) -> int:
        """Advance to a time [s], and return the number of steps; see `warp_mps.fluid.time_loop.TimeLoop.advance`."""
        return self._loop.advance(time)

    @property
    def time(self) -> float:
        """Time that the fluids have come to [s]."""
        return self.state.now

    def statistics(self) -> Statistics:
        """Statistics of the pressure solves so far."""
        return self.step.pressure.solver.read_statistics()

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        forces = self.step.body_forces.arrays() if self.step.body_forces else {}
        counted = {f"{name}_statistics": solver.statistics.numpy().copy() for name, solver in self.step.solvers.items()}
        return {**self.state.arrays(), **forces, **counted, "failures": self.failures.state()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        self.step.assign(arrays)
        for name, solver in self.step.solvers.items():
            solver.assign(arrays[f"{name}_statistics"])
        self.failures.assign(arrays["failures"])

    def trouble(self) -> str | None:
        """Why the run cannot go on, if it cannot."""
        return self.failures.trouble()

    def record(self) -> dict[str, dict[str, float]]:
        """Particles lost, and statistics of the pressure solves."""
        return self.readings.record()

    def displacements(self) -> np.ndarray:
        """Displacements [m], shape [n, d]."""
        return self.readings.displacements()

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self.readings.velocities()

    def rotations(self) -> np.ndarray:
        """Rotation vectors of the walls [rad], shape [n, 1] or [n, 3]."""
        return self.readings.rotations()

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the walls [rad/s], shape [n, 1] or [n, 3]."""
        return self.readings.angular_velocities()

    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""
        return self.readings.pressures()

    def number_densities(self) -> np.ndarray:
        """Number densities in units of a full lattice's [-], shape [n]."""
        return self.readings.number_densities()

    def volumes(self) -> np.ndarray:
        """Volumes of the fluid's particles [m^d], shape [n]."""
        return self.readings.volumes()

    def stress_fields(self) -> StressFields:
        """Stresses -p I [Pa], and no strains."""
        return self.readings.stress_fields()

    def energy_densities(self) -> np.ndarray:
        """No strain energy [J/m^3], shape [n]."""
        return np.zeros(self.model.particles.count)

    def contact_forces(self) -> np.ndarray:
        """Forces of the fluid on walls [N], shape [n, d]."""
        return self.readings.contact_forces()

    def internal_forces(self) -> np.ndarray:
        """Forces of the fluid and its walls on each other [N], shape [n, d]."""
        return self.readings.internal_forces()

    def elastic_torques(self) -> np.ndarray:
        """No torques [N m], shape [n, 1] or [n, 3]."""
        return np.zeros_like(self.model.particles.angular_velocities)

    def reactions(self) -> np.ndarray:
        """No reactions, for nothing is supported [N], shape [n, d]."""
        return np.zeros((self.model.particles.count, self.model.types.dimension))

    def energy(self) -> Energy:
        """Energies of the fluid [J], in 2-D [J/m]."""
        return self.readings.energy()

    def energy_of_bodies(self) -> None:
        """None: there are no bodies."""

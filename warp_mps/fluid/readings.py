"""What can be asked of the fluids of a scene, in the order of its particles."""

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Statistics
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.output.stresses import StressFields
from warp_mps.fluid.lists import NeighbourLists
from warp_mps.fluid.operators import Operators
from warp_mps.fluid.state import FluidState
from warp_mps.fluid.viscous import ImplicitViscosity
from warp_mps.fluid.volumes import volume_kernels
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.walls.poses import Poses


class FluidReadings:
    """The readings of `warp_mps.fluid.fluids.Fluids`, which owns what they look at."""

    state: FluidState
    operators: Operators
    lists: NeighbourLists
    _particles: Particles
    _walls: int
    _clip: int
    _m: int
    _d: int
    _density: float
    _volume: float
    _gravity: Any
    _gravity_host: np.ndarray
    _kernels: tuple[Any, Any, Any]
    _solver: ConjugateGradient
    _implicit: ImplicitViscosity | None
    _poses: Poses | None
    _velocities_before: np.ndarray
    _interval: float
    _longest: float
    _courant: float
    _spacing: float
    _device: Any
    _kit: NumericTypes

    def positions(self) -> np.ndarray:
        """Positions [m], shape [n, d]."""
        return self._all(self.state.x)

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._all(self.state.u)

    def pressures(self) -> np.ndarray:
        """Pressures, on walls those of the fluid beside them [Pa], shape [n]."""
        state, ops = self.state, self.operators
        walls = wp.zeros(max(self._walls, 1), dtype=wp.float64, device=self._device)
        inputs = [self._walls, self._clip, self.lists.period, ops.radius, self._density, self._gravity]
        inputs += [*self._listed(), state.x, state.a, state.p]
        self._launch(self._kernels[1].wall_pressure, self._walls, inputs, [walls])
        return np.concatenate((walls.numpy()[: self._walls], self._ordered(state.p.numpy())))

    def number_densities(self) -> np.ndarray:
        """Number densities in units of a full lattice's, 1 on walls [-], shape [n]."""
        fluid = self._ordered(self.state.n.numpy()) / self.operators.number_density
        return np.concatenate((np.ones(self._walls), fluid))

    def volumes(self) -> np.ndarray:
        """Volumes that the fluid's particles take up, 0 on walls [m^d], shape [n]; see `warp_mps.fluid.volumes`."""
        state, ops = self.state, self.operators
        shares = wp.zeros(self._m, dtype=state.n.dtype, device=self._device)
        inputs = [self._walls, self.lists.period, ops.radius, self._spacing, ops.number_density, ops.smooth_density]
        inputs += [float(ops.neighbours), *self._listed(), state.x, state.lost]
        self._launch(volume_kernels(self._kit).take_up, self._m, inputs, [shares])
        return np.concatenate((np.zeros(self._walls), self._volume * self._ordered(shares.numpy())))

    def contact_forces(self) -> np.ndarray:
        """Force of the fluid on the walls' particles, its mean over the last interval [N], shape [n, d]."""
        forces = np.zeros((self._particles.count, self._d))
        forces[: self._walls] = self.state.forces.numpy()[: self._walls]
        return forces

    def displacements(self) -> np.ndarray:
        """Displacements from the initial positions [m], shape [n, d]."""
        return self.positions() - self._particles.positions

    def rotations(self) -> np.ndarray:
        """Rotation vectors of the walls, 0 for the fluid [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._turns(0)

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the walls, 0 for the fluid [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._turns(1)

    def stress_fields(self) -> StressFields:
        """Stresses of the fluid, -p I without the viscous part, and no strains."""
        stresses = -self.pressures()[:, None, None] * np.eye(3)
        return StressFields(stresses, np.zeros_like(stresses))

    def energy_densities(self) -> np.ndarray:
        """No strain energy [J/m^3], shape [n]."""
        return np.zeros(self._particles.count)

    def internal_forces(self) -> np.ndarray:
        """What the fluid and its walls exert on each other, its mean over the last interval [N], shape [n, d]."""
        forces = self.contact_forces()
        if not np.isfinite(self._interval):  # nothing is known before the first interval
            return forces
        change = (self.velocities() - self._velocities_before)[self._walls :] / self._interval
        kept = 1.0 - self._ordered(self.state.lost.numpy()[self._walls :])
        forces[self._walls :] = (self._density * self._volume * kept)[:, None] * (change - self._gravity_host)
        return forces

    def elastic_torques(self) -> np.ndarray:
        """None [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return np.zeros_like(self._particles.angular_velocities)

    def reactions(self) -> np.ndarray:
        """None, for nothing is supported [N], shape [n, d]."""
        return np.zeros((self._particles.count, self._d))

    @property
    def time(self) -> float:
        """Time that the fluids have come to [s]."""
        return float(self.state.time.numpy()[0])

    def lost(self) -> int:
        """Number of particles that have left the domain."""
        return int(self.state.lost.numpy().sum())

    def energy(self) -> Energy:
        """Energies of the fluid."""
        mass = self._density * self._volume
        x, u = self.positions()[self._walls :], self.velocities()[self._walls :]
        fallen = (x - self._particles.positions[self._walls :]) @ self._gravity_host
        work = float(self.state.work.numpy().sum())
        kinetic = 0.5 * mass * float(np.sum(u**2))
        # a particle that goes round a period has fallen by all of it
        potential = -mass * float(np.sum(fallen) + self.state.fallen.numpy().sum())
        return Energy(kinetic=kinetic, elastic=0.0, contact=0.0, potential=potential, work=work, dissipated=0.0)

    @property
    def solvers(self) -> dict[str, ConjugateGradient]:
        """The solvers of a step, by what they find."""
        viscous = {"velocities": self._implicit.solver} if self._implicit else {}
        return {"pressures": self._solver, **viscous}

    def statistics(self) -> Statistics:
        """What the pressure solve has done so far."""
        return self._solver.read_statistics()

    def record(self) -> dict[str, dict[str, float]]:
        """Particles lost, and what the pressure solves did, for run.json."""
        done = self.statistics()
        return {
            "fluid": {
                "lost": self.lost(),
                "pressure_iterations": done.iterations / max(done.solves, 1),
                "most_pressure_iterations": done.most_iterations,
                "worst_pressure_residual": done.worst_residual,
                "unsolved": self._unsolved_solves(),
            }
        }

    def _unsolved_solves(self) -> int:
        return sum(solver.count_unsolved() for solver in self.solvers.values())

    def _turns(self, derivative: int) -> np.ndarray:
        turns = np.zeros_like(self._particles.angular_velocities)
        if self._poses:
            turns[: self._walls] = self._poses.turns()[derivative][self._particles.walls[: self._walls]]
        return turns

    def _ordered(self, values: np.ndarray) -> np.ndarray:
        """Values of the fluid particles, in the order of the particles, as float64."""
        ordered = np.empty(values.shape, float)
        ordered[self.state.order.numpy()] = values
        return ordered

    def _all(self, array: wp.array) -> np.ndarray:
        """Values of all particles, in their order."""
        values = array.numpy()
        return np.concatenate((values[: self._walls].astype(float), self._ordered(values[self._walls :])))

    def _listed(self) -> list[wp.array]:
        return [self.lists.listed, self.lists.count]

    def _launch(self, kernel: Any, n: int, inputs: list[Any], outputs: list[Any]) -> None:
        if n:
            wp.launch(kernel, n, inputs, outputs, device=self._device)

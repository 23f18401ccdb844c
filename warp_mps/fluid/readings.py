"""Readings of fluids: quantities of their particles, and energies."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.elastic.output.stresses import StressFields
from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.step import FluidStep
from warp_mps.results.energy import Energy


class FluidReadings:
    """Quantities of fluids and their walls as float64 host arrays, in the order of the scene: n particles, walls first.

    Args:
        step: The step of the fluids.
    """

    def __init__(self, step: FluidStep) -> None:
        self._step, self._model, self._state = step, step.model, step.state
        self._kernels = fluid_kernels(step.model.types)

    def positions(self) -> np.ndarray:
        """Positions [m], shape [n, d]."""
        return self._state.in_scene_order(self._state.x)

    def displacements(self) -> np.ndarray:
        """Displacements from the initial positions [m], shape [n, d]."""
        return self.positions() - self._model.particles.positions

    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._state.in_scene_order(self._state.u)

    def pressures(self) -> np.ndarray:
        """Pressures, on walls those of the fluid beside them [Pa], shape [n]."""
        fluid = self._state.fluid_in_scene_order(self._state.p.numpy())
        return np.concatenate((self._step.forces.wall_pressures(), fluid))

    def number_densities(self) -> np.ndarray:
        """Number densities in units of a full lattice's, 1 on walls [-], shape [n]."""
        n = self._state.fluid_in_scene_order(self._state.n.numpy())
        return np.concatenate((np.ones(self._model.walls), n / self._model.operators.number_density))

    def volumes(self) -> np.ndarray:
        """Volumes that the fluid's particles take up, 0 on walls [m^d], shape [n]; see `warp_mps.fluid.volumes`."""
        model, state, lists = self._model, self._state, self._step.neighbours
        shares = wp.zeros(model.count, dtype=state.n.dtype, device=model.device)
        inputs = [model.constants, lists.table, state.x, state.lost]
        model.launch(self._kernels.volume_ratio, model.count, inputs, [shares])
        return np.concatenate((np.zeros(model.walls), model.volume * state.fluid_in_scene_order(shares.numpy())))

    def contact_forces(self) -> np.ndarray:
        """Force of the fluid on the walls' particles, its mean over the last interval [N], shape [n, d]."""
        forces, w = np.zeros((self._model.particles.count, self._model.types.dimension)), self._model.walls
        forces[:w] = self._state.forces.numpy()[:w]
        return forces

    def internal_forces(self) -> np.ndarray:
        """Forces of the fluid and its walls on each other, mean over the last interval [N], shape [n, d]."""
        forces, model, state, w = self.contact_forces(), self._model, self._state, self._model.walls
        if not np.isfinite(state.interval):  # nothing is known before the first interval
            return forces
        change = (self.velocities() - state.u_before)[w:] / state.interval
        kept = 1.0 - state.fluid_in_scene_order(state.lost.numpy()[w:])
        given = model.gravity + (self._step.body_forces.mean_acceleration if self._step.body_forces else 0.0)
        forces[w:] = (model.mass * kept)[:, None] * (change - given)
        return forces

    def rotations(self) -> np.ndarray:
        """Rotation vectors of the walls, 0 for the fluid [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._step.wall_motion.rotations()

    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the walls, 0 for the fluid [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._step.wall_motion.angular_velocities()

    def stress_fields(self) -> StressFields:
        """Stresses of the fluid, -p I without the viscous part, and no strains."""
        stresses = -self.pressures()[:, None, None] * np.eye(3)
        return StressFields(stresses, np.zeros_like(stresses))

    def energy(self) -> Energy:
        """Energies of the fluid."""
        model, state, w = self._model, self._state, self._model.walls
        x, u = self.positions()[w:], self.velocities()[w:]
        fallen = (x - model.particles.positions[w:]) @ model.gravity
        work = float(state.work.numpy().sum()) + (self._step.body_forces.work() if self._step.body_forces else 0.0)
        kinetic = 0.5 * model.mass * float(np.sum(u**2))
        # a particle that is wrapped by a period has fallen by all of it
        potential = -model.mass * float(np.sum(fallen) + state.fallen.numpy().sum())
        return Energy(kinetic=kinetic, elastic=0.0, contact=0.0, potential=potential, work=work, dissipated=0.0)

    def lost(self) -> int:
        """Number of particles that have left the domain."""
        return int(self._state.lost.numpy().sum())

    def record(self) -> dict[str, dict[str, float]]:
        """Particles lost, and statistics of the pressure solves, for run.json."""
        done = self._step.pressure.solver.read_statistics()
        return {
            "fluid": {
                "lost": self.lost(),
                "pressure_iterations": done.iterations / max(done.solves, 1),
                "most_pressure_iterations": done.most_iterations,
                "worst_pressure_residual": done.worst_residual,
                "unsolved": self._step.count_unsolved(),
            }
        }

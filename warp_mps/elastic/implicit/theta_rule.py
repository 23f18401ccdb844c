"""The theta rule: a step of elastic bodies that is stable at any length.

With the forces at t + theta dt, where u_theta = u_0 + theta (u_1 - u_0),

    m (v_1 - v_0) = dt [f(u_theta) - damping m v_theta],   u_1 - u_0 = dt v_theta,   v_theta = v_0 + theta (v_1 - v_0)

so that u_theta is the minimum of an energy with the inertia a = (1 + damping theta dt)/(theta dt)^2 about
c = u_0 + theta dt v_0/(1 + damping theta dt), and the end of the step follows. theta = 1/2 is the midpoint rule, which
keeps energy except at large strains, and damps nothing; theta = 1 is backward Euler. An oscillation of angular
frequency omega is damped with the ratio (theta - 1/2) omega dt while omega dt is small. Where it is far too fast for
the step, ((1 - theta)/theta)^2 of its energy is left after it. Loads are those of both ends of a step, weighted with
1 - theta and theta.

References:
    Hairer, Lubich and Wanner, Geometric Numerical Integration, 2nd ed., sections II.1 and VI.4 (midpoint rule).
    Wood, W. L., Practical Time-stepping Schemes, Oxford 1990, chapter 2 (theta rule).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.replay import Replay
from warp_mps.core.snapshot import Snapshot
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.newton import Newton
from warp_mps.elastic.implicit.step_kernels import step_kernels
from warp_mps.elastic.parts import SolidParts
from warp_mps.errors import RunError

# theta of the rule that dissipates nothing in the deformation
MIDPOINT = 0.5


class ThetaStep:
    """A step of the theta rule, with the state that only it needs.

    Attributes:
        newton:   The solver of a step.
        external: Forces beside those of the scene, constant over a step [N],   vec [n]
        elastic:  Elastic forces at the end of the last step [N],               vec [n]
        work:     Work done from outside so far [J],                            float64 [n]

    Args:
        parts: The parts of the bodies; their `external` becomes that of the step.
        theta: Theta [-].
        graphs: Whether launches are replayed as graphs.
        linear_tolerance: Tolerance of the linear systems, relative to their right-hand sides.
    """

    def __init__(self, parts: SolidParts, theta: float, *, graphs: bool, linear_tolerance: float) -> None:
        assert isinstance(parts.model, HamiltonianModel)
        types, device, state, held = parts.types, parts.device, parts.state, parts.boundary.held
        self._parts, self._state, self._model, self._theta = parts, state, parts.model, theta
        self._kernels, self._replay = step_kernels(types), Replay(device=device, graphs=graphs)
        options: dict[str, Any] = {"types": types, "device": device, "graphs": graphs}
        options["linear_tolerance"] = linear_tolerance
        self.newton = Newton(parts.model, parts.particles, state, parts.mass, held, **options)
        self._free = wp.array(~held, dtype=types.vec, device=device)
        self._length = wp.zeros(1, dtype=wp.float64, device=device)
        self._time = self._saved_time = 0.0
        vectors = [wp.zeros(parts.count, dtype=types.vec, device=device) for _ in range(10)]
        self.external, self.elastic, self._load, self._load_before, self._given = vectors[:5]
        self._u_before, self._elastic_between, self._end, self._end_velocity, self._mean_velocity = vectors[5:]
        parts.external = self.external
        self.work = wp.zeros(parts.count, dtype=wp.float64, device=device)
        # elastic energies at the end of the last step and of this one [J]
        self._energy, self._energy_after = (wp.zeros(parts.count, dtype=types.real, device=device) for _ in range(2))
        evolving = [state.u, state.v, state.force, state.driven, state.dissipated, parts.inversions.inverted]
        self._snapshot = Snapshot([*evolving, self._load, self.elastic, self.work, self._energy])

    def start(self) -> None:
        """Evaluate the forces of the initial state, with which the first step begins."""
        parts, state = self._parts, self._state
        parts.boundary.supports_at(state.u, state.v, state.driven, parts.mass, 0.0)
        parts.boundary.add_loads(self._load, parts.mass, 0.0)
        if parts.body_forces:
            parts.body_forces.apply(state, 0.0, self._load)
        wp.copy(self._mean_velocity, state.v)
        self._complete()
        self._model.launch_energy(state, self._energy)

    def advance(self, time: float, tolerance: float | None, share: float) -> None:
        """Advance to a time [s] by one step, solved to a residual relative to its forces; see `Newton.solve`.

        Raises:
            RunError: The step's equation was not solved; the state is the one before.
        """
        parts, state, boundary = self._parts, self._state, self._parts.boundary
        self._length.fill_(time - self._time)
        for kept, now in ((self._end, state.u), (self._end_velocity, state.v), (self._load_before, self._load)):
            wp.copy(kept, now)
        boundary.supports_at(self._end, self._end_velocity, state.driven, parts.mass, time)
        self._find_load(time, ahead=time - self._time)
        self._replay("begin", self._assemble)
        options: dict[str, Any] = {"guess": self._guess, "tolerance": tolerance, "share": share}
        if not self.newton.solve(jumps=boundary.supports_move, measure=True, **options):
            wp.copy(state.u, self._u_before)
            wp.copy(self._load, self._load_before)
            parts.inversions.recall()
            self._complete()
            raise RunError(self._not_solved(time))
        self._replay("end", self._finish)
        if parts.body_forces:
            # at the places where the next step begins, not at those where this one was expected to end
            self._find_load(time)
        self._time = time

    def save(self) -> None:
        """Keep the present state on the device."""
        self._snapshot.save()
        self._saved_time = self._time

    def restore(self) -> None:
        """Return to the state that was kept; see `warp_mps.elastic.implicit.solid.ImplicitSolid.restore`."""
        self._snapshot.restore()
        self._time = self._saved_time

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        copies = {name: array.numpy().copy() for name, array in self._named().items()}
        return {**copies, **self.newton.arrays(), "implicit_time": np.array(self._time)}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for name, array in self._named().items():
            array.assign(arrays[name])
        self._time = float(arrays["implicit_time"])
        self.newton.assign(arrays)

    def _named(self) -> dict[str, wp.array]:
        """Everything that evolves, by its name in a checkpoint."""
        return {
            "load": self._load,
            "elastic": self.elastic,
            "implicit_work": self.work,
            "elastic_energy": self._energy,
            "pace": self._mean_velocity,
        }

    def _not_solved(self, time: float) -> str:
        worst = self._parts.particles.describe(self.newton.worst_particle())
        why = self.newton.describe_rounding() or "shorten the time step, or the bodies are crushed"
        return (
            f"the step from {self._time:.6g} to {time:.6g} s was not solved: {why}; {worst} was furthest from a "
            "solution"
        )

    def _find_load(self, time: float, *, ahead: float = 0.0) -> None:
        """Loads and body forces at a time [s]; Python's body forces at the places x + ahead v."""
        parts = self._parts
        self._load.zero_()
        parts.boundary.add_loads(self._load, parts.mass, time)
        if parts.body_forces:
            parts.body_forces.apply(self._state, time, self._load, ahead=ahead)

    def _assemble(self) -> None:
        """The equation of the step."""
        parts, state, newton = self._parts, self._state, self.newton
        wp.copy(self._elastic_between, self.elastic)
        parts.inversions.keep()
        inputs = [self._theta, parts.damping, self._length, parts.gravity, parts.mass, state.u, state.v, self._end]
        inputs += [self._load_before, self._load, self.external]
        outputs = [newton.inertia, self._u_before, newton.center, newton.target, self._given, newton.applied]
        self._launch(self._kernels.assemble_step, inputs, outputs)

    def _guess(self) -> None:
        """Initial guess: the mean velocity of the last step, or of the last time that this one was taken."""
        inputs = [self._theta, self._length, self._free, self._u_before, self._mean_velocity]
        self._launch(self._kernels.initial_guess, inputs, [self._state.u])

    def _finish(self) -> None:
        """The end of the step, its forces, and its energy balance."""
        state, newton, mass = self._state, self.newton, self._parts.mass
        inputs = [self._theta, self._parts.damping, self._length, self._free, mass, self._u_before]
        inputs += [self._end, self._end_velocity, state.force, self._given, newton.applied]
        self._launch(self._kernels.extrapolate, inputs, [state.u, state.v, self.work, state.dissipated])
        self._parts.inversions.recall()
        wp.copy(self._elastic_between, state.force)
        self._complete()
        if self._theta > MIDPOINT:
            self._model.launch_energy(state, self._energy_after)
            inputs = [self._u_before, state.u, self._elastic_between, self._energy_after]
            self._launch(self._kernels.add_dissipation, inputs, [self._energy, state.dissipated])
        self._launch(self._kernels.mean_velocity, [self._length, self._u_before, state.u], [self._mean_velocity])

    def _complete(self) -> None:
        """The forces of the present state."""
        self._parts.evaluate_model()
        inputs = [self._parts.gravity, self._parts.mass, self._load, self.external]
        self._launch(self._kernels.total_force, inputs, [self.elastic, self._state.force])

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._parts.count, inputs, outputs, device=self._parts.device)

"""The theta rule: elastic bodies that move by implicit steps, stable at any length of a step.

With the forces at t + theta dt, where u_theta = u_0 + theta (u_1 - u_0),

    m (v_1 - v_0) = dt [f(u_theta) - damping m v_theta],   u_1 - u_0 = dt v_theta,   v_theta = v_0 + theta (v_1 - v_0)

so that u_theta is the minimum of an energy with the inertia a = (1 + damping theta dt)/(theta dt)^2 about
c = u_0 + theta dt v_0/(1 + damping theta dt), and the end of the step follows. theta = 1/2 is the midpoint rule, which
keeps energy, but for large strains, and damps nothing; theta = 1 is backward Euler. An oscillation of angular frequency
omega is damped with the ratio (theta - 1/2) omega dt while omega dt is small, and where it is far too fast for a step,
((1 - theta)/theta)^2 of its energy is left after it. Loads are those of both ends of a step, weighted with 1 - theta
and theta; body forces at the end are those at u_0 + dt v_0.

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
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.explicit.solid import Solid
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.newton import LINEAR_TOLERANCE, Newton
from warp_mps.elastic.implicit.statistics import solver_record
from warp_mps.elastic.implicit.step_kernels import step_kernels
from warp_mps.errors import RunError
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class ImplicitSolid(Solid):
    """The elastic bodies of a scene, advanced by the theta rule.

    A coupling calls `save`, sets `external`, calls `advance`, looks at `state.u` and `state.v`, and calls `restore` to
    try another force; all of it stays on the device.

    Attributes:
        external: Forces on the particles beside those of the scene, constant over a step [N], vec [n].
        newton: The solver of a step.

    Args:
        scene: The case.
        particles: Its particles.
        dt: Time step of the run [s]; `advance` takes any.
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
        linear_tolerance: Of the linear systems of a step, relative to their right-hand sides.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        dt: float,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
        linear_tolerance: float = LINEAR_TOLERANCE,
    ) -> None:
        super().__init__(scene, particles, dt=dt, types=types, device=device)
        assert isinstance(self.model, HamiltonianModel)
        state, held, n = self.state, self.boundary.held, self._n
        self._kernels, self._theta = step_kernels(types), scene.theta
        self._run = Replay(device=device, graphs=graphs)
        options: dict[str, Any] = {"types": types, "device": device, "graphs": graphs}
        self.newton = Newton(
            self.model, particles, state, self._mass, held, linear_tolerance=linear_tolerance, **options
        )
        self._free = wp.array(~held, dtype=types.vec, device=device)
        self._length = wp.zeros(1, dtype=wp.float64, device=device)
        self._time = 0.0
        vectors = [wp.zeros(n, dtype=types.vec, device=device) for _ in range(10)]
        self.external, self._load, self._load_before, self._pushed, self._elastic = vectors[:5]
        self._u_before, self._elastic_before, self._end, self._end_speed, self._pace = vectors[5:]
        self._work = wp.zeros(n, dtype=wp.float64, device=device)
        evolving = [state.u, state.v, state.force, state.driven, state.dissipated]
        evolving += [self._load, self._elastic, self._work]
        self._snapshot = Snapshot(evolving)
        self._saved_time = 0.0

    def start(self) -> None:
        """Evaluate the forces of the initial state, which the first step begins with."""
        state = self.state
        self.boundary.place(state.u, state.v, state.driven, self._mass, 0.0)
        self.boundary.push(self._load, self._mass, 0.0)
        if self.body_forces:
            self.body_forces.apply(state, 0.0, self._load)
        wp.copy(self._pace, state.v)
        self._complete()

    def advance(self, time: float, *, tolerance: float | None = None) -> None:
        """Advance to a time [s] by one step.

        Args:
            time: The time [s].
            tolerance: Residual of the step relative to its forces, if not the default.

        Raises:
            RunError: The step's equation was not solved; the state is the one before.
        """
        state = self.state
        self._length.fill_(time - self._time)
        for kept, now in ((self._end, state.u), (self._end_speed, state.v), (self._load_before, self._load)):
            wp.copy(kept, now)
        self.boundary.place(self._end, self._end_speed, state.driven, self._mass, time)
        self._load.zero_()
        self.boundary.push(self._load, self._mass, time)
        if self.body_forces:
            self.body_forces.apply(state, time, self._load, ahead=time - self._time)
        self._run("begin", self._begin)
        if not self.newton.solve(jumps=self.boundary.driven, measure=True, guess=self._foresee, tolerance=tolerance):
            wp.copy(state.u, self._u_before)
            wp.copy(self._load, self._load_before)
            self._complete()
            worst = self._particles.describe(self.newton.worst_particle())
            raise RunError(
                f"the step from {self._time:.6g} to {time:.6g} s was not solved: shorten the time step, or the bodies "
                f"are crushed; {worst} was furthest from a solution"
            )
        self._run("end", self._finish)
        if self.body_forces:  # where the next step begins, not where this one was expected to end
            self._load.zero_()
            self.boundary.push(self._load, self._mass, time)
            self.body_forces.apply(state, time, self._load)
        self._time = time

    def save(self) -> None:
        """Keep the present state on the device."""
        self._snapshot.save()
        self._saved_time = self._time

    def restore(self) -> None:
        """Go back to the state that was kept.

        `external` stays as it is, and so does what the solver learned: the step begins its search where the last one
        led. A step that is taken again agrees with itself to the solver's tolerance, not to the bit.
        """
        self._snapshot.restore()
        self._time = self._saved_time

    def internal_forces(self) -> np.ndarray:
        """Elastic forces [N], shape [n, d]."""
        return self._elastic.numpy().astype(float)

    def work(self) -> float:
        """Work done from outside so far [J]."""
        return float(np.sum(self._work.numpy()))

    def record(self) -> dict[str, dict[str, float]]:
        """What the solvers did, for run.json."""
        return {"implicit": solver_record(self.newton)}

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        own = {"load": self._load, "elastic": self._elastic, "implicit_work": self._work, "pace": self._pace}
        copies = {name: array.numpy().copy() for name, array in own.items()}
        solver = self.newton.preconditioner.arrays()
        return {**super().arrays(), **copies, **solver, "implicit_time": np.array(self._time)}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        super().assign(arrays)
        own = {"load": self._load, "elastic": self._elastic, "implicit_work": self._work, "pace": self._pace}
        for name, array in own.items():
            array.assign(arrays[name])
        self._time = float(arrays["implicit_time"])
        self.newton.preconditioner.assign(arrays)

    def _begin(self) -> None:
        """What the step has to solve."""
        state, newton = self.state, self.newton
        wp.copy(self._elastic_before, self._elastic)
        inputs = [self._theta, self._damping, self._length, self._gravity, self._mass, state.u, state.v, self._end]
        inputs += [self._load_before, self._load, self.external]
        outputs = [newton.inertia, self._u_before, newton.center, newton.target, self._pushed, newton.applied]
        self._launch(self._kernels.begin, inputs, outputs)

    def _foresee(self) -> None:
        """Go on as in the last step, or the last time that this one was taken."""
        inputs = [self._theta, self._length, self._free, self._u_before, self._pace]
        self._launch(self._kernels.foresee, inputs, [self.state.u])

    def _finish(self) -> None:
        """The end of the step, its forces, and its account."""
        state, newton = self.state, self.newton
        inputs = [self._theta, self._damping, self._length, self._free, self._mass, self._u_before]
        inputs += [self._end, self._end_speed, state.force, self._pushed, newton.applied]
        self._launch(self._kernels.extrapolate, inputs, [state.u, state.v, self._work, state.dissipated])
        self._complete()
        inputs = [self._theta, self._u_before, self._elastic_before, state.u, self._elastic]
        self._launch(self._kernels.account, inputs, [state.dissipated])
        self._launch(self._kernels.keep_pace, [self._length, self._u_before, state.u], [self._pace])

    def _complete(self) -> None:
        """The forces of the present state."""
        for _, launch in self.model.passes:
            launch(self.state, 0, self._n)
        inputs = [self._gravity, self._mass, self._load, self.external]
        self._launch(self._kernels.complete, inputs, [self._elastic, self.state.force])

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._n, inputs, outputs, device=self._device)

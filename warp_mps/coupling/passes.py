"""Fixed-point passes of a step between fluid and elastic bodies; see `warp_mps.coupling.step`."""

from __future__ import annotations

import functools
import math

import numpy as np
import warp as wp

from warp_mps.coupling.interface import Markers
from warp_mps.coupling.iqn_ils import InterfaceQuasiNewton
from warp_mps.coupling.robin import RobinTerm
from warp_mps.coupling.statistics import CouplingStatistics
from warp_mps.coupling.structures import Structure
from warp_mps.errors import RunError
from warp_mps.fluid.failures import MOST_UNSOLVED
from warp_mps.fluid.fluids import Fluids
from warp_mps.scene.validation.coupling import LEAST_DENSITY

# change of the forces on the markers in a pass, relative to them, at which the passes have converged
TOLERANCE = 1e-3
MOST_PASSES = 20
# earlier steps whose passes the quasi-Newton method reuses
REUSED_STEPS = 16
# times the forces at the start of a step that those of a pass may be before a step that fails is put down to them
RUNAWAY = 10.0


class FixedPointPasses:
    """Finds the forces on e markers that are those of the pressures which the bodies' motion under them causes.

    Attributes:
        robin: Robin term of the pressure Poisson equation.
        statistics: Statistics of the passes.
        force: Forces on the markers that the bodies take the step under [N], vec64 [e].
        pressure_force: Forces on the markers of the last pressures [N], vec64 [e].
        guess: First iterate of the next step: forces on the markers, and the linearization point of the Robin term [N],
            shape [2, e, d].
        replay: Replays the launches of a part of a pass under its name.

    Args:
        fluids: The fluids, whose first wall particles are the markers.
        markers: The markers.
        structure: The bodies.
        mobility: Mobility of the markers [1/kg], real [e].
    """

    def __init__(self, fluids: Fluids, markers: Markers, structure: Structure, mobility: wp.array) -> None:
        self._fluid, self._failures, self._markers, self._structure = fluids.step, fluids.failures, markers, structure
        types, device, e = fluids.model.types, fluids.model.device, markers.count
        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        self.force, self.pressure_force = (wp.zeros(e, dtype=vec64, device=device) for _ in range(2))
        self.robin = RobinTerm(fluids.step, e, mobility)
        self.statistics = CouplingStatistics()
        self.guess = np.zeros((2, e, types.dimension))
        self.replay = fluids.step.replay
        self._density = fluids.model.density
        self._quasi_newton = InterfaceQuasiNewton(REUSED_STEPS)
        # change of the forces in the last pass, shape [e, d]
        self._change = np.zeros((e, types.dimension))
        self._v_before = wp.zeros_like(structure.solid.state.v)
        # forces are impulses in a time of 1 s, the work of which is not used
        self._one, self._work = (
            wp.ones(1, dtype=wp.float64, device=device),
            wp.zeros(e, dtype=wp.float64, device=device),
        )

    def begin(self) -> None:
        """Launch what the passes of a step start from: the velocities of the bodies, and the assembled equation."""
        wp.copy(self._v_before, self._structure.solid.state.v)
        self.robin.begin()

    def iterate(self, end: float) -> int:
        """Do the passes of a step, take it under the last forces, and return the number of passes.

        Args:
            end: Time at the end of the step [s].

        Raises:
            RunError: The forces are not finite, or a step of the bodies was not solved.
        """
        forces: np.ndarray = self.guess
        for count in range(1, MOST_PASSES + 1):
            self._try_forces(forces, end, count)
            if count == 1:
                self.replay("solve pressure", self._solve_pressure)
            else:
                self.replay("solve pressure again", functools.partial(self._solve_pressure, same=True))
            found = np.stack((self.pressure_force.numpy(), self.robin.forces.numpy().astype(float)))
            scale = float(np.linalg.norm(found))
            if not math.isfinite(scale):
                raise RunError(self._describe_divergence())
            residual = float(np.linalg.norm(found - forces)) / scale if scale > 0.0 else 0.0
            self._quasi_newton.add(forces.ravel(), found.ravel())
            if residual <= TOLERANCE:
                break
            if count < MOST_PASSES:
                forces = self._quasi_newton.next_iterate().reshape(forces.shape)
        self._change = found[0] - forces[0]
        self._quasi_newton.end_step()
        self.statistics.add(count, residual, converged=residual <= TOLERANCE)
        # the bodies take the step under exactly the forces of the last pressures
        self._advance_structure(found, end)
        self.guess = found
        return count

    def accelerations_under(self, forces: np.ndarray, end: float) -> np.ndarray:
        """Accelerations of the markers over the step under forces on them [m/s^2], shape [e, d].

        Args:
            forces: Forces on the markers [N], shape [e, d].
            end: Time at the end of the step [s].
        """
        self._advance_structure(np.stack((forces, forces)), end, trial=True)
        self._find_accelerations()
        return self._fluid.state.a.numpy()[: self._markers.count].astype(float)

    def forget(self) -> None:
        """Drop what the quasi-Newton method has learnt: the Robin term is another one."""
        self._quasi_newton.forget()

    def find_failure(self, left: int) -> str | None:
        """Why no further step makes sense, if none does; see `FluidFailures.after_step`."""
        steps = self.statistics.diverged
        if steps < MOST_UNSOLVED:
            return self._failures.after_step(left)
        return (
            f"the coupling of water and bodies did not converge in {steps} steps in a row: the forces on the bodies "
            f"still change by {self.statistics.last_residual:.3g} of themselves, and most at "
            f"{self._describe_marker(self._change)}"
        )

    def _describe_marker(self, forces: np.ndarray) -> str:
        """The marker with the largest of some forces, shape [e, d], and its remedy if its body is too light."""
        k = int(np.argmax(np.linalg.norm(forces, axis=1)))
        ratio = float(self._markers.densities[k] / self._density)
        described = self._failures.describe(k)
        if ratio >= LEAST_DENSITY:
            return described
        return f"{described}, whose body is {ratio:.2g} times as dense as the water: take {LEAST_DENSITY:g} or more"

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        learnt = {"learnt": self._quasi_newton.memory, "learnt_sizes": self._quasi_newton.sizes}
        return {"guess": self.guess, **learnt, "passes_statistics": self.statistics.state()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: What has been learnt is not of these markers, or a counter is none.
        """
        learnt, wanted = arrays["learnt"].shape, (2, self.guess.size)
        if learnt[0] and learnt[1:] != wanted:
            raise ValueError(f"learnt is of shape {learnt}, must be of shape {(learnt[0], *wanted)}")
        self.statistics.assign(arrays["passes_statistics"])
        self.guess = arrays["guess"].copy()
        self._quasi_newton.assign(arrays["learnt"], arrays["learnt_sizes"])

    def _try_forces(self, forces: np.ndarray, end: float, count: int) -> None:
        """Take the bodies' step of a pass; if it fails under forces that grow without bound, that is the cause.

        Raises:
            RunError: The step was not solved.
        """
        try:
            self._advance_structure(forces, end, trial=True)
        except RunError as error:
            now, usual = float(np.linalg.norm(forces[0])), float(np.linalg.norm(self.guess[0]))
            if now <= RUNAWAY * usual:
                raise
            reason = f"in pass {count} the forces on the bodies are {now:.3g} N, {usual:.3g} N at the start"
            worst = self._describe_marker(forces[0])
            raise RunError(
                f"at t = {self._fluid.state.now:.6g} s: the coupling of water and bodies diverges: {reason}, and most "
                f"at {worst}"
            ) from error

    def _advance_structure(self, forces: np.ndarray, end: float, *, trial: bool = False) -> None:
        """Take the bodies' step under forces on the markers, and set the linearization point, shape [2, e, d]."""
        self.force.assign(forces[0])
        self.robin.linearization.assign(forces[1])
        self._markers.transfer_forces(self.force, self._structure.external)
        self._structure.advance(end, trial=trial)

    def _solve_pressure(self, *, same: bool = False) -> None:
        """Launch the pressures for the bodies' motion, and their forces on the markers.

        Args:
            same: Whether the matrix is that of the last solve.
        """
        fluid = self._fluid
        self._find_accelerations()
        self.robin.set_rhs()
        fluid.pressure.solve_with(self.robin.multiply, same=same)
        self.robin.find_forces(fluid.state.p)
        if fluid.body_forces:
            fluid.body_forces.subtract_from_walls(self._markers.count)
        self.pressure_force.zero_()
        fluid.forces.find_slopes()
        fluid.forces.add_wall_impulse(self._markers.count, self._one, self.pressure_force, self._work)

    def _find_accelerations(self) -> None:
        """Launch the accelerations of the markers over the bodies' step."""
        fluid, solid = self._fluid, self._structure.solid.state
        self._markers.find_accelerations(fluid.time_step.dt, self._v_before, solid, fluid.state.a)

    def _describe_divergence(self) -> str:
        """A marker whose position is not finite, or the fastest particle."""
        state = self._fluid.state
        wrong = np.flatnonzero(~np.isfinite(state.x.numpy()[: self._markers.count]).all(axis=1))
        what = self._failures.describe_fastest()
        if len(wrong):
            what = f"the position of {self._failures.name(wrong[0])} is not finite"
        return f"at t = {state.now:.6g} s: {what}: the forces between water and bodies are not finite"

"""A strongly coupled step of fluid and elastic bodies (partitioned: each is solved by its own method).

A step predicts the fluid and the positions of the markers, and assembles the pressure Poisson equation as if the markers
kept their velocities. It then finds the forces F on the markers that are those of the pressures which the bodies' motion
under F causes, by fixed-point passes

    F -> the bodies over the step -> the markers' accelerations a -> pressures -> F'

An incompressible fluid adds its mass to that of a light body, and these passes alone diverge, however short the step
(Causin, Gerbeau and Nobile 2005). Two things make them converge in about two passes: a Robin term in the equation, which
approximates the response of the markers (`warp_mps.coupling.robin`), and an interface quasi-Newton method, which learns
the rest (`warp_mps.coupling.iqn_ils`). The iterated unknown is F together with the linearization point of the Robin
term.

The pressure keeps the density with the bodies' velocity at the END of the step. The time integration of the bodies must
damp modes that it cannot resolve, as the theta rule does, or these velocities oscillate.

References:
    Causin, P., Gerbeau, J.-F. and Nobile, F., Comput. Methods Appl. Mech. Engrg. 194 (2005) 4506.
    Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87 (2009) 793.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import warp as wp

from warp_mps.coupling.added_mass import Mobility
from warp_mps.coupling.interface import Markers
from warp_mps.coupling.iqn_ils import InterfaceQuasiNewton
from warp_mps.coupling.robin import RobinTerm
from warp_mps.coupling.statistics import CouplingStatistics
from warp_mps.coupling.structures import Structure
from warp_mps.errors import RunError
from warp_mps.fluid.failures import LARGEST_SPEED, MOST_UNSOLVED
from warp_mps.fluid.fluids import Fluids

# change of the forces on the markers in a pass, relative to them, at which the passes have converged
TOLERANCE = 1e-3
MOST_PASSES = 20
# earlier steps whose passes the quasi-Newton method reuses
REUSED_STEPS = 16
# how much longer than the CFL condition allows a step may be that is a single sub-step of the bodies
LARGEST_STRETCH = 5.0


class CoupledStep:
    """The step of fluids between walls and e markers of elastic bodies, with the bodies' steps inside.

    Attributes:
        mobility: Mobility of the markers, for the Robin term.
        robin: Robin term of the pressure Poisson equation.
        statistics: Statistics of the passes.
        works: Works on the bodies so far [J], in 2-D [J/m], float64 [e] each: of pressures, of collisions on free
            axes, and of collisions on axes that a support holds.
        force: Forces on the markers that the bodies feel [N], vec64 [e].
        pressure_force: Forces on the markers that the last pressures make [N], vec64 [e].
        replay: Replays the launches of a part of the step under its name.

    Args:
        fluids: The fluids, whose first wall particles are the markers.
        markers: The markers.
        structure: The bodies.
    """

    def __init__(self, fluids: Fluids, markers: Markers, structure: Structure) -> None:
        self._fluid, self._failures, self._markers, self._structure = fluids.step, fluids.failures, markers, structure
        types, device, e = fluids.model.types, fluids.model.device, markers.count
        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        self.force, self.pressure_force, self._impulse_before = (
            wp.zeros(e, dtype=vec64, device=device) for _ in range(3)
        )
        self.works = [wp.zeros(e, dtype=wp.float64, device=device) for _ in range(3)]
        n = len(structure.solid.state.u)
        self._v_before, self._u_before = (wp.zeros(n, dtype=types.vec, device=device) for _ in range(2))
        self._zero, self._one = (
            wp.zeros(1, dtype=wp.float64, device=device),
            wp.ones(1, dtype=wp.float64, device=device),
        )
        self._unused_work = wp.zeros(e, dtype=wp.float64, device=device)
        free = ~structure.solid.boundary.held[: markers.elastic]
        self._free = wp.array(free, dtype=types.vec, device=device)
        self._quasi_newton = InterfaceQuasiNewton(REUSED_STEPS)
        self.mobility = Mobility(markers, types=types, device=device)
        self.robin = RobinTerm(self._fluid, e, self.mobility.array)
        # the first guess of a step, and the last change in it: forces, and the linearization point
        self._guess, self._change = np.zeros((2, e, types.dimension)), np.zeros((e, types.dimension))
        self.statistics = CouplingStatistics()
        self.replay = self._fluid.replay

    def take(self) -> None:
        """Take one step towards the target time of the fluid."""
        self.replay("set time step", self._fluid.set_time_step)
        end = self.fit_time_step()
        self.replay("predict", self.predict)
        self._structure.save()
        if self.mobility.is_due(float(self._fluid.time_step.dt.numpy()[0])):
            self.measure_mobility(end)
        self.replay("robin diagonal", self.robin.add_to_diagonal)
        forces = self._iterate(end)
        # the bodies take the step under exactly the forces of the last pressures
        self._advance_structure(forces, end)
        self.replay("correct", self.correct)
        self._guess = forces

    def fit_time_step(self) -> float:
        """Make the time step one that the bodies can take, and return the time at its end [s].

        Raises:
            RunError: A particle is infinitely fast, or too fast for the bodies' steps.
        """
        time_step, now = self._fluid.time_step, self._fluid.state.now
        target, longest = float(time_step.target.numpy()[0]), float(time_step.dt.numpy()[0])
        dt, left = self._structure.fit_time_step(longest, target - now) if longest > 0.0 else (math.inf, 0)
        if dt > LARGEST_SPEED * longest:
            raise RunError(f"at t = {now:.6g} s: {self._failures.describe_fastest()}: time step underflow")
        if dt > LARGEST_STRETCH * longest:
            reason = f"the bodies' explicit steps of {dt:.3g} s are too long for it; shorten the time step of the scene"
            raise RunError(f"at t = {now:.6g} s: {self._failures.describe_fastest()}: {reason}")
        return time_step.replace(dt, left)

    def predict(self) -> None:
        """Launch the prediction, and the assembly of the equation for markers that keep their velocities."""
        fluid, solid, e = self._fluid, self._structure.solid.state, self._markers.count
        wp.copy(self._impulse_before, fluid.state.impulse, count=e)
        wp.copy(self._v_before, solid.v)
        wp.copy(self._u_before, solid.u)
        fluid.state.a[:e].zero_()
        fluid.apply_viscosity()
        fluid.predict()
        self._transfer_motion(fluid.time_step.dt)
        fluid.update_neighbours()
        fluid.assemble()
        self.robin.begin()

    def measure_mobility(self, end: float) -> None:
        """Measure the mobility of the bodies, under a uniform pressure and pressures that grow along an axis.

        Args:
            end: Time at the end of the step [s].
        """
        state, w = self._fluid.state, self._fluid.model.walls
        x = state.x.numpy()[w:].astype(float)
        inside = state.lost.numpy()[w:] == 0
        x = np.where(inside[:, None], x - x[inside].mean(axis=0), 0.0)
        patterns = [self.robin.forces_of(values) for values in (np.ones(len(x)), *x.T)]
        self.mobility.measure(lambda forces: self._accelerations_under(forces, end), patterns, self._guess[0])
        self._quasi_newton.forget()

    def correct(self) -> None:
        """Launch the corrector and collisions, with the bodies at their new positions, and end the step."""
        fluid, structure = self._fluid, self._structure
        fluid.correct()
        self._transfer_motion(self._zero)
        fluid.collide()
        fluid.advance_clock()
        self._markers.apply_collisions(
            structure.solid.state,
            self.works,
            free=self._free,
            dt=fluid.time_step.dt,
            impulses=(self._impulse_before, fluid.state.impulse),
            external=structure.external,
            u_before=self._u_before,
        )
        self._transfer_motion(self._zero)

    def place_markers(self) -> None:
        """Launch the positions and velocities of the markers, as the bodies are now."""
        self._transfer_motion(self._zero)

    def find_failure(self, left: int) -> str | None:
        """Why no further step makes sense, if none does; see `FluidFailures.after_step`."""
        steps = self.statistics.diverged
        if steps < MOST_UNSOLVED:
            return self._failures.after_step(left)
        k = int(np.argmax(np.linalg.norm(self._change, axis=1)))
        return (
            f"the coupling of water and bodies did not converge in {steps} steps in a row: the forces on the bodies still "
            f"change by {self.statistics.last_residual:.3g} of themselves, and most at {self._failures.describe(k)}"
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        own = {"works": np.stack([work.numpy() for work in self.works]), "guess": self._guess}
        learnt = {"learnt": self._quasi_newton.memory, "learnt_sizes": self._quasi_newton.sizes}
        return {**own, **learnt, **self.mobility.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for work, values in zip(self.works, arrays["works"], strict=True):
            work.assign(values)
        self._guess = arrays["guess"].copy()
        self._quasi_newton.assign(arrays["learnt"], arrays["learnt_sizes"])
        self.mobility.assign(arrays)

    def _iterate(self, end: float) -> np.ndarray:
        """Forces on the markers that agree with the pressures, and the linearization point, shape [2, e, d].

        Raises:
            RunError: The forces are not finite.
        """
        forces: np.ndarray = self._guess
        for count in range(1, MOST_PASSES + 1):
            self._advance_structure(forces, end, trial=True)
            if count == 1:
                self.replay("solve pressure", self._solve_pressure)
            else:
                self.replay("solve pressure again", functools.partial(self._solve_pressure, same=True))
            found = np.stack((self.pressure_force.numpy(), self.robin.forces.numpy().astype(float)))
            scale = float(np.linalg.norm(found))
            if not math.isfinite(scale):
                reason = "the forces between water and bodies are not finite"
                raise RunError(f"at t = {self._fluid.state.now:.6g} s: {self._describe_divergence()}: {reason}")
            residual = float(np.linalg.norm(found - forces)) / scale if scale > 0.0 else 0.0
            self._quasi_newton.add(forces.ravel(), found.ravel())
            if residual <= TOLERANCE:
                break
            if count < MOST_PASSES:
                forces = self._quasi_newton.next_iterate().reshape(forces.shape)
        self._change = found[0] - forces[0]
        self._quasi_newton.end_step()
        self.mobility.note_passes(count)
        self.statistics.add(count, residual, converged=residual <= TOLERANCE)
        return found

    def _describe_divergence(self) -> str:
        """A marker whose position is not finite, or the fastest particle."""
        x = self._fluid.state.x.numpy()[: self._markers.count]
        wrong = np.flatnonzero(~np.isfinite(x).all(axis=1))
        if len(wrong):
            return f"the position of {self._failures.name(wrong[0])} is not finite"
        return self._failures.describe_fastest()

    def _advance_structure(self, forces: np.ndarray, end: float, *, trial: bool = False) -> None:
        """Take the bodies' step under forces on the markers."""
        self.force.assign(forces[0])
        self.robin.linearization.assign(forces[1])
        self._markers.transfer_forces(self.force, self._structure.external)
        self._structure.advance(end, trial=trial)

    def _accelerations_under(self, forces: np.ndarray, end: float) -> np.ndarray:
        """Accelerations of the markers over the step under forces on them [m/s^2], shape [e, d]."""
        self._advance_structure(np.stack((forces, forces)), end, trial=True)
        self._find_accelerations()
        return self._fluid.state.a.numpy()[: self._markers.count].astype(float)

    def _solve_pressure(self, *, same: bool = False) -> None:
        """Launch the pressures for the bodies' motion, and the forces that they make.

        Args:
            same: Whether the matrix is that of the last solve.
        """
        fluid = self._fluid
        self._find_accelerations()
        self.robin.set_rhs()
        fluid.pressure.solve_with(self.robin.multiply, same=same)
        self.robin.find_forces(fluid.state.p)
        self.pressure_force.zero_()
        fluid.forces.find_slopes()
        fluid.forces.push_walls(self._markers.count, self._one, self.pressure_force, self._unused_work)

    def _find_accelerations(self) -> None:
        fluid = self._fluid
        self._markers.find_accelerations(fluid.time_step.dt, self._v_before, self._structure.solid.state, fluid.state.a)

    def _transfer_motion(self, ahead: wp.array) -> None:
        state = self._fluid.state
        self._markers.transfer_motion(self._structure.solid.state, ahead, state.x, state.u)

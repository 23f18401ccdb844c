"""A strongly coupled step of fluid and elastic bodies (partitioned: each is solved by its own method).

A step predicts the fluid and the positions of the markers, and assembles the pressure Poisson equation as if the
markers kept their velocities. It then finds the forces F on the markers that are those of the pressures which the
bodies' motion under F causes, by fixed-point passes (`warp_mps.coupling.passes`)

    F -> the bodies over the step -> the markers' accelerations a -> pressures -> F'

An incompressible fluid adds its mass to that of a light body, and these passes alone diverge, however short the step
(Causin, Gerbeau and Nobile 2005). Two things make them converge in about two passes: a Robin term in the equation,
which approximates the response of the markers (`warp_mps.coupling.robin`), and an interface quasi-Newton method, which
learns the rest (`warp_mps.coupling.iqn_ils`). The iterated unknown is F together with the linearization point of the
Robin term.

The pressure keeps the density with the bodies' velocity at the END of the step. The time integration of the bodies must
damp modes that it cannot resolve, as the theta rule does, or these velocities oscillate.

References:
    Causin, P., Gerbeau, J.-F. and Nobile, F., Comput. Methods Appl. Mech. Engrg. 194 (2005) 4506.
    Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87 (2009) 793.
"""

from __future__ import annotations

import math

import numpy as np
import warp as wp

from warp_mps.coupling.added_mass import Mobility
from warp_mps.coupling.interface import Markers
from warp_mps.coupling.passes import FixedPointPasses
from warp_mps.coupling.structures import Structure
from warp_mps.errors import RunError
from warp_mps.fluid.failures import LARGEST_SPEED
from warp_mps.fluid.fluids import Fluids

# how much longer than the CFL condition allows a step may be that is a single sub-step of the bodies
LARGEST_STRETCH = 5.0


class CoupledStep:
    """The step of fluids between walls and e markers of elastic bodies, with the bodies' steps inside.

    Attributes:
        mobility: Mobility of the markers, for the Robin term.
        passes: Fixed-point passes of the step.
        works: Works on the bodies so far [J], in 2-D [J/m], float64 [e] each: of pressures, of collisions on free
            axes, and of collisions on axes that a support holds.

    Args:
        fluids: The fluids, whose first wall particles are the markers.
        markers: The markers.
        structure: The bodies.
    """

    def __init__(self, fluids: Fluids, markers: Markers, structure: Structure) -> None:
        self._fluid, self._failures, self._markers, self._structure = fluids.step, fluids.failures, markers, structure
        types, device, e = fluids.model.types, fluids.model.device, markers.count
        self.mobility = Mobility(markers, types=types, device=device)
        self.passes = FixedPointPasses(fluids, markers, structure, self.mobility.array)
        self.works = [wp.zeros(e, dtype=wp.float64, device=device) for _ in range(3)]
        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        self._impulse_before = wp.zeros(e, dtype=vec64, device=device)
        self._u_before = wp.zeros_like(structure.solid.state.u)
        free = ~structure.solid.boundary.held[: markers.elastic]
        self._free = wp.array(free, dtype=types.vec, device=device)
        self._zero = wp.zeros(1, dtype=wp.float64, device=device)

    def take(self) -> None:
        """Take one step towards the target time of the fluid."""
        replay = self.passes.replay
        replay("set time step", self._fluid.set_time_step)
        end = self.fit_time_step()
        self._fluid.evaluate_body_forces()
        replay("predict", self.predict)
        self._structure.save()
        if self.mobility.is_due(float(self._fluid.time_step.dt.numpy()[0])):
            self.measure_mobility(end)
        replay("robin diagonal", self.passes.robin.add_to_diagonal)
        self.mobility.note_passes(self.passes.iterate(end))
        replay("correct", self.correct)

    def fit_time_step(self) -> float:
        """Make the time step one that the bodies can take, and return the time at its end [s].

        Raises:
            RunError: A particle is infinitely fast, or too fast for the bodies' steps.
        """
        time_step, now = self._fluid.time_step, self._fluid.state.now
        target, longest = float(time_step.target.numpy()[0]), float(time_step.dt.numpy()[0])
        dt, left = self._structure.fit_time_step(longest, target - now) if longest > 0.0 else (math.inf, 0)
        if dt > LARGEST_SPEED * longest:
            reason = "time step underflow; slow the motion down, or shorten the time step of the scene (mps:timeStep)"
            raise RunError(f"at t = {now:.6g} s: {self._failures.describe_fastest()}: {reason}")
        if dt > LARGEST_STRETCH * longest:
            reason = f"the bodies' explicit steps of {dt:.3g} s are too long for it; shorten the time step of the scene"
            raise RunError(f"at t = {now:.6g} s: {self._failures.describe_fastest()}: {reason}")
        return time_step.replace(dt, left)

    def predict(self) -> None:
        """Launch the prediction, and the assembly of the equation for markers that keep their velocities."""
        fluid, e = self._fluid, self._markers.count
        wp.copy(self._impulse_before, fluid.state.impulse, count=e)
        wp.copy(self._u_before, self._structure.solid.state.u)
        fluid.state.a[:e].zero_()
        fluid.apply_viscosity()
        fluid.predict()
        self._place_markers(fluid.time_step.dt)
        fluid.update_neighbours()
        fluid.assemble()
        self.passes.begin()

    def measure_mobility(self, end: float) -> None:
        """Measure the mobility of the bodies, under a uniform pressure and pressures that grow along an axis.

        Args:
            end: Time at the end of the step [s].
        """
        state, w, passes = self._fluid.state, self._fluid.model.walls, self.passes
        x = state.x.numpy()[w:].astype(float)
        inside = state.lost.numpy()[w:] == 0
        x = np.where(inside[:, None], x - x[inside].mean(axis=0), 0.0)
        patterns = [passes.robin.forces_of(values) for values in (np.ones(len(x)), *x.T)]
        self.mobility.measure(lambda forces: passes.accelerations_under(forces, end), patterns, passes.guess[0])
        passes.forget()

    def correct(self) -> None:
        """Launch the corrector and collisions, with the bodies at their new positions, and end the step."""
        fluid, structure = self._fluid, self._structure
        fluid.correct()
        self.place_markers()
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
        self.place_markers()

    def place_markers(self) -> None:
        """Launch the positions and velocities of the markers, as the bodies are now."""
        self._place_markers(self._zero)

    def find_failure(self, left: int) -> str | None:
        """Why no further step makes sense, if none does; see `FluidFailures.after_step`."""
        return self.passes.find_failure(left)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        works = np.stack([work.numpy() for work in self.works])
        return {"works": works, **self.passes.arrays(), **self.mobility.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        for work, values in zip(self.works, arrays["works"], strict=True):
            work.assign(values)
        self.passes.assign(arrays)
        self.mobility.assign(arrays)

    def _place_markers(self, ahead: wp.array) -> None:
        """Launch the positions and velocities of the markers a time ahead [s], float64 [1]."""
        state = self._fluid.state
        self._markers.transfer_motion(self._structure.solid.state, ahead, state.x, state.u)

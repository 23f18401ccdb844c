"""The water of a scene whose elastic bodies feel it: its step, with the bodies' steps inside.

A step predicts the water and the places of the markers, and assembles the pressure Poisson equation as if the markers
kept their velocities. It then looks for the forces F on the markers that agree with the pressures that the bodies' own
motion makes under them:

    F -> the bodies over the step -> the markers' accelerations a -> pressures -> F'

An incompressible fluid moves with a light body as if it were a part of it, and this iteration alone diverges, however
short the step (the added mass; Causin, Gerbeau and Nobile 2005). Two things make it converge in some two passes: the
equation knows about how the markers will answer (`warp_mps.coupling.exchange`), and a quasi-Newton method learns the
rest (`warp_mps.coupling.quasi_newton`). What goes round is F and the force that the equation's answer was taken about.

The pressure is that which keeps the density with the bodies' velocity at the END of the step; the bodies' own rule must
damp what it cannot resolve, as the theta rule does, or these velocities ring.

References:
    Causin, P., Gerbeau, J.-F. and Nobile, F., Comput. Methods Appl. Mech. Engrg. 194 (2005) 4506.
    Degroote, J., Bathe, K.-J. and Vierendeels, J., Computers & Structures 87 (2009) 793.
"""

import functools
import math
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.core.types import NumericTypes
from warp_mps.coupling.exchange import coupling_kernels
from warp_mps.coupling.markers import Markers
from warp_mps.coupling.mobility import Mobility
from warp_mps.coupling.quasi_newton import QuasiNewton
from warp_mps.coupling.record import ExchangeStatistics
from warp_mps.coupling.structures import Structure
from warp_mps.errors import InputError, RunError
from warp_mps.fluid.failures import LARGEST_SPEED, MOST_UNSOLVED
from warp_mps.fluid.fluids import Fluids
from warp_mps.scene import Scene
from warp_mps.scene.validation.rules import place

# the forces on the markers agree when they change by no more than this part of themselves
TOLERANCE = 1e-3
MOST_PASSES = 20
# steps whose passes the quasi-Newton method remembers
REMEMBERED = 16
# how much longer a step may be than the fastest particle asks for, where it is one of the bodies' already
FASTEST = 5.0


class WetFluids(Fluids):
    """The fluids of a scene, between its walls and the markers of its elastic bodies.

    Attributes:
        exchange: What the iterations did so far.
        works: Works on the bodies so far [J], in 2-D [J/m], float64 [markers] each: of pressures, of collisions on free
            axes, and of collisions on axes that a support holds.

    Args:
        scene: The case.
        markers: The markers.
        structure: The bodies.
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.

    Raises:
        InputError: The domain of the scene does not hold its fluids.
    """

    def __init__(
        self,
        scene: Scene,
        markers: Markers,
        structure: Structure,
        *,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
    ) -> None:
        super().__init__(scene, markers.particles, types=types, device=device, graphs=graphs)
        self._markers, self._structure, e, m = markers, structure, markers.count, self._m
        self._coupling, self._source = coupling_kernels(types), place(scene.fluids[0], "fluid")

        def zeros(length: int, kind: Any) -> wp.array:
            return wp.zeros(length, dtype=kind, device=device)

        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
        self._wet, self._own, self._base = zeros(m, wp.int32), zeros(m, types.real), zeros(m, wp.float64)
        # on the markers: forces that the bodies feel, those that the pressures make, and what the equation answers to
        self._force, self._pressed, self._spare = zeros(e, vec64), zeros(e, vec64), zeros(e, wp.float64)
        self._about, self._approximate, self._answer = zeros(e, types.vec), zeros(e, types.vec), zeros(e, types.vec)
        self._before = zeros(e, vec64)
        self.works = [zeros(e, wp.float64) for _ in range(3)]
        n = len(structure.solid.state.u)
        self._v_before, self._u_before = zeros(n, types.vec), zeros(n, types.vec)
        self._zero, self._one = zeros(1, wp.float64), wp.ones(1, dtype=wp.float64, device=device)
        self._fresh = wp.ones(CONTROLS, dtype=wp.int32, device=device)
        self._open, self._tried = zeros(1, wp.int32), zeros(m, wp.float64)
        free = ~structure.solid.outside.held[: markers.elastic]
        self._free = wp.array(free, dtype=types.vec, device=device)
        self._newton = QuasiNewton(REMEMBERED)
        self.mobility = Mobility(markers, types=types, device=device)
        self._guess = np.zeros((2, e, types.dimension))
        self.exchange = ExchangeStatistics()

    def start(self) -> None:
        """Find the neighbours of the initial state.

        Raises:
            InputError: The fluids have no free surface.
        """
        self._show(self._zero)
        super().start()
        self._refuse_closed()

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        own = {"works": np.stack([work.numpy() for work in self.works]), "guess": self._guess}
        learnt = {"learnt": self._newton.memory, "learnt_sizes": self._newton.sizes}
        return {**super().arrays(), **own, **learnt, **self.mobility.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        super().assign(arrays)
        for work, values in zip(self.works, arrays["works"], strict=True):
            work.assign(values)
        self._guess = arrays["guess"].copy()
        self._newton.assign(arrays["learnt"], arrays["learnt_sizes"])
        self.mobility.assign(arrays)

    def _refuse_closed(self) -> None:
        """Refuse water without a free surface: it finds its volume, which no particles hold exactly, in the bodies."""
        if self.is_closed():
            reason = "leaves no free surface between walls and elastic bodies: give the water some room"
            raise InputError(self._source, "shape", reason)

    def failure(self, left: int) -> str | None:
        """Why no further step makes sense, if none does."""
        steps = self.exchange.at_odds
        if steps < MOST_UNSOLVED:
            return super().failure(left)
        k = int(np.argmax(np.linalg.norm(self._change, axis=1)))
        return (
            f"water and bodies were at odds in {steps} steps in a row: the forces on the bodies still change by "
            f"{self.exchange.last_residual:.3g} of themselves, and most at {self._which(k)} at {self._where(k)}"
        )

    def _take_step(self) -> None:
        """Take one step towards the target time, water and bodies."""
        self._replay("plan", self._plan)
        time = self._fit()
        self._replay("begin", self._begin)
        self._structure.save()
        if self.mobility.due(float(self._dt.numpy()[0])):
            self._probe(time)
        self._replay("stiffen", self._stiffen)
        forces = self._agree(time)
        # the bodies feel exactly what the water does
        self._take(forces, time)
        self._replay("end", self._end)
        self._guess = forces

    def _fit(self) -> float:
        """Make the step one that the bodies can take, and return the time at its end [s].

        Raises:
            RunError: A particle is infinitely fast, or too fast for the bodies' steps.
        """
        now, target = float(self.state.time.numpy()[0]), float(self._target.numpy()[0])
        wish = float(self._dt.numpy()[0])
        dt, left = self._structure.fit(wish, target - now) if wish > 0.0 else (math.inf, 0)
        if dt > LARGEST_SPEED * wish:
            raise RunError(f"at t = {now:.6g} s: {self.fastest()}: time stands still")
        if dt > FASTEST * wish:
            reason = f"the bodies' explicit steps of {dt:.3g} s are too long for it; shorten the time step of the scene"
            raise RunError(f"at t = {now:.6g} s: {self.fastest()}: {reason}")
        self._way.assign(self._way.numpy() * (dt / wish))
        self._dt.assign([dt])
        self._left.assign([left])
        end = target if left == 1 else now + dt
        self._time_after.assign([end])
        return end

    def _begin(self) -> None:
        """The prediction, and the equation for markers that keep their velocities."""
        state, e = self.state, self._markers.count
        wp.copy(self._before, state.impulse, count=e)
        solid = self._structure.solid.state
        wp.copy(self._v_before, solid.v)
        wp.copy(self._u_before, solid.u)
        state.a[:e].zero_()
        self._slow()
        self._move()
        self._show(self._dt)
        self.lists.update(state.x, state.lost)
        self._assemble()
        wp.copy(self._base, self._rhs)
        inputs = [self._walls, e, *self._listed()]
        self._launch(self._coupling.find_wet, self._m, inputs, [self._wet])

    def _stiffen(self) -> None:
        """Let the equation know how the markers answer."""
        e = self._markers.count
        inputs = [self._walls, e, *self._geometry(), self._density, self._volume, *self._listed(), self._wet]
        inputs += [self.mobility.array, self.state.x, self._tilt]
        self._launch(self._coupling.stiffen, self._m, inputs, [self._matrix.diagonal, self._own])

    def _agree(self, time: float) -> np.ndarray:
        """Forces on the markers that agree with the pressures, and those that the equation answered to.

        Raises:
            RunError: The forces are not finite.
        """
        forces: np.ndarray = self._guess
        for count in range(1, MOST_PASSES + 1):
            self._take(forces, time, trial=True)
            if count == 1:
                self._replay("project", self._project)
            else:
                self._replay("project again", functools.partial(self._project, same=True))
            found = np.stack((self._pressed.numpy(), self._approximate.numpy().astype(float)))
            scale = float(np.linalg.norm(found))
            if not math.isfinite(scale):
                reason = "the forces between water and bodies are no numbers any more"
                raise RunError(f"at t = {self.time:.6g} s: {self._astray()}: {reason}")
            residual = float(np.linalg.norm(found - forces)) / scale if scale > 0.0 else 0.0
            self._newton.add(forces.ravel(), found.ravel())
            if residual <= TOLERANCE:
                break
            if count < MOST_PASSES:
                forces = self._newton.propose().reshape(forces.shape)
        self._change = found[0] - forces[0]
        self._newton.end_step()
        self.mobility.heed(count)
        self.exchange.add(count, residual, agreed=residual <= TOLERANCE)
        return found

    def _astray(self) -> str:
        """A marker whose place is no number, or the fastest particle."""
        wrong = np.flatnonzero(~np.isfinite(self.state.x.numpy()[: self._markers.count]).all(axis=1))
        return f"the position of {self._which(wrong[0])} is not finite" if len(wrong) else self.fastest()

    def _take(self, forces: np.ndarray, time: float, *, trial: bool = False) -> None:
        """Take the bodies' step under forces on the markers."""
        self._force.assign(forces[0])
        self._about.assign(forces[1])
        self._markers.share(self._force, self._structure.external)
        self._structure.advance(time, trial=trial)

    def _probe(self, time: float) -> None:
        """Measure how the bodies answer to a uniform pressure more, and to one that grows along an axis."""
        x = self.state.x.numpy()[self._walls :].astype(float)
        inside = self.state.lost.numpy()[self._walls :] == 0
        x = np.where(inside[:, None], x - x[inside].mean(axis=0), 0.0)
        patterns = [self._forces_of(values) for values in (np.ones(len(x)), *x.T)]
        self.mobility.measure(lambda forces: self._answer_to(forces, time), patterns, self._guess[0])
        self._newton.forget()

    def _forces_of(self, pressures: np.ndarray) -> np.ndarray:
        """Approximate forces of pressures on the markers, shape [markers, d]."""
        self._tried.assign(pressures)
        self._respond(self._fresh, self._tried, self._tried, self._approximate)
        return self._approximate.numpy().astype(float)

    def _answer_to(self, forces: np.ndarray, time: float) -> np.ndarray:
        self._take(np.stack((forces, forces)), time, trial=True)
        self._markers.accelerate(self._dt, self._v_before, self._structure.solid.state, self.state.a)
        return self.state.a.numpy()[: self._markers.count].astype(float)

    def _project(self, *, same: bool = False) -> None:
        """Pressures for the bodies' motion, and the forces that they make; of the same equation as last time or not."""
        state, e, solid = self.state, self._markers.count, self._structure.solid.state
        self._markers.accelerate(self._dt, self._v_before, solid, state.a)
        wp.copy(self._rhs, self._base)
        self._launch(self._coupling.answer, e, [self.mobility.array, self._about, state.a], [self._answer])
        head = [self._walls, e, *self._geometry(), self._density, *self._listed(), self._wet]
        self._launch(self._coupling.couple, self._m, [*head, state.x, self._tilt, self._answer], [self._rhs])
        self._solver.solve(self._matrix._replace(singular=None), self._rhs, state.p, rest=self._rest, same=same)
        self._lift(self._open)
        self._respond(self._fresh, state.p, state.p, self._approximate)
        self._pressed.zero_()
        self._find_slopes()
        self._push_walls(e, self._one, [self._pressed, self._spare])

    def _rest(self, control: wp.array, p: wp.array, direction: wp.array, q: wp.array) -> None:
        """Off the diagonal, what the markers' answer adds to the product with the matrix."""
        self._respond(control, p, direction, self._answer)
        inputs = [self._walls, self._markers.count, *self._geometry(), self._density, *self._listed(), self._wet]
        inputs += [self._own, self.mobility.array, control, self.state.x, self._tilt, self._answer, p, direction]
        self._launch(self._coupling.couple_product, self._m, inputs, [q])

    def _respond(self, control: wp.array, p: wp.array, direction: wp.array, out: wp.array) -> None:
        inputs = [self._walls, *self._geometry(), self._volume, *self._listed(), control, self.state.x, self._tilt]
        inputs += [p, direction]
        self._launch(self._coupling.respond, self._markers.count, inputs, [out])

    def _end(self) -> None:
        """The corrector, with the bodies where they have come to."""
        state, structure = self.state, self._structure
        self._push()
        self._show(self._zero)
        self._collide()
        self._finish()
        solid = structure.solid.state
        inputs = [self._dt, self._before, state.impulse, structure.external, self._u_before, solid.u]
        self._markers.receive(self._free, inputs, [solid.v, *self.works])
        self._show(self._zero)

    def _show(self, ahead: wp.array) -> None:
        self._markers.show(self._structure.solid.state, ahead, self.state.x, self.state.u)

    def _geometry(self) -> list[Any]:
        ops = self.operators
        return [self.lists.period, ops.radius, self._spacing, ops.laplacian]

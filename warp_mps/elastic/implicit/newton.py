"""Newton's method for the equilibrium of elastic particles, and for a step of time in its form.

It is an inexact Newton method: the linear systems are solved on the device by preconditioned conjugate gradients, to a
fraction of the residual. The line search on the host is Armijo backtracking of the potential. The host also inverts the
coarse level of the two-level preconditioner, whenever that is rebuilt.

References:
    Dembo, R. S., Eisenstat, S. C. and Steihaug, T., SIAM J. Numer. Anal. 19 (1982) 400 (inexact Newton).
    Nocedal, J. and Wright, S. J., Numerical Optimization, 2nd ed., section 3.1 (Armijo backtracking).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import ChunkSums, ConjugateGradient
from warp_mps.core.replay import Replay
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit import newton_kernels as names
from warp_mps.elastic.implicit.newton_kernels import newton_kernels
from warp_mps.elastic.implicit.rounding import STALLED, Evaluation, describe_rounding
from warp_mps.elastic.implicit.statistics import NewtonStatistics
from warp_mps.elastic.implicit.tangent_operator import Tangent
from warp_mps.elastic.implicit.two_level import TwoLevelPreconditioner
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles

# residual of the forces, relative to its scale
TOLERANCES = {"float64": 1e-8, "float32": 1e-4}
# tolerance of the linear systems, relative to their right-hand sides
LINEAR_TOLERANCE = 1e-4
MOST_ITERATIONS = 60
MOST_HALVINGS = 30
# sufficient decrease of the potential over its first-order decrease (Armijo), and the rounding of the potential
ARMIJO = 1e-4
ROUNDING = {"float64": 1e-13, "float32": 1e-5}


class Newton:
    """Finds the displacements of the free axes where the residual of `warp_mps.elastic.implicit.newton_kernels` is 0.

    Attributes:
        applied: Forces that do not depend on the displacements [N], vec [n].
        target: Displacements u of the held axes [m], vec [n]; free axes are ignored.
        center: c [m], vec [n].
        inertia: a [1/s^2], float64, shape [1].
        solver: The linear solver.
        tangent: The operator.
        preconditioner: The preconditioner of the linear solver.
        statistics: Statistics so far.
        tolerance: Norm of the residual to reach, relative to the forces.

    Args:
        model: The model.
        particles: Its particles.
        state: Its state, of as many particles as the model has; `u` and `force` (the elastic one) are changed.
        mass: Masses [kg], shape [n].
        held: Whether each axis of each particle is held, shape [n, d].
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
        tolerance: Norm of the residual to reach, relative to the forces; by default that of `TOLERANCES`.
        linear_tolerance: Tolerance of the linear systems, relative to their right-hand sides.
    """

    def __init__(
        self,
        model: HamiltonianModel,
        particles: Particles,
        state: ElasticState,
        mass: wp.array,
        held: np.ndarray,
        *,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
        tolerance: float | None = None,
        linear_tolerance: float = LINEAR_TOLERANCE,
    ) -> None:
        self._kernels, self._device = newton_kernels(types), device
        self._run = Replay(device=device, graphs=graphs)
        self._model, self._state, self._mass = model, state, mass
        n, self._n = held.size, len(held)
        self.tolerance, self._rounding = tolerance or TOLERANCES[types.precision], ROUNDING[types.precision]
        self._single = types.precision == "float32"
        self.applied, self.target, self.center, self._kept = (
            wp.zeros(self._n, dtype=types.vec, device=device) for _ in range(4)
        )
        self.inertia = wp.zeros(1, dtype=wp.float64, device=device)
        self.tangent = Tangent(model, state.u, mass, held, self.inertia, types=types, device=device)
        self.preconditioner = TwoLevelPreconditioner(
            self.tangent, model, particles, state, held, self.inertia, types=types, device=device, graphs=graphs
        )
        self._free = wp.array(~held, dtype=types.vec, device=device)
        self._energy = wp.zeros(self._n, dtype=types.real, device=device)
        flat = [wp.zeros(n, dtype=wp.float64, device=device) for _ in range(7)]
        self._residual, self._scale, self._rounded, self._right, self._pushed, self._jump, self._change = flat
        self._potential = wp.zeros(self._n, dtype=wp.float64, device=device)
        self._ones = wp.array(np.ones(self._n), dtype=wp.float64, device=device)
        self._stiffness = self._stiffness_at_rest(types)
        self._step = wp.zeros(1, dtype=wp.float64, device=device)
        self._numbers = wp.zeros(names.NUMBERS, dtype=wp.float64, device=device)
        self._sums = [ChunkSums(length, types=types, device=device) for length in (n, self._n)]
        self.solver = ConjugateGradient(
            n,
            types=types,
            device=device,
            tolerance=linear_tolerance,
            max_iterations=max(1000, 4 * n),
            preconditioner=self.preconditioner,
        )
        self.statistics = NewtonStatistics()
        self._last, self._farthest = (Evaluation(0.0, 0.0, 0.0, 0.0, 0.0), 0.0), 0.0

    def _stiffness_at_rest(self, types: NumericTypes) -> wp.array:
        """Magnitudes of the diagonal blocks of the tangent, without inertia [N/m], mat64 [n]; the model is at rest."""
        self.tangent.prepare(None, self._ones)
        mat64 = wp.types.matrix(shape=(types.dimension, types.dimension), dtype=wp.float64)
        return wp.array(np.abs(self.tangent.block.numpy()), dtype=mat64, device=self._device)

    def solve(
        self,
        *,
        jumps: bool,
        measure: bool = False,
        guess: Callable[[], None] | None = None,
        tolerance: float | None = None,
        share: float = math.inf,
    ) -> bool:
        """Find the equilibrium from the present displacements on.

        Args:
            jumps: Whether held axes are not yet at their target.
            measure: Whether the residual is also measured by the initial one.
            guess: Launches an initial guess, which is taken if its residual is smaller.
            tolerance: Tolerance of this solve, if not the default.
            share: Largest residual, as a share of the forces that act; the initial residual is much larger than these
                where a stiff body turns fast.

        Returns:
            Whether it was found; if not, the displacements are those of the last iteration.
        """
        tolerance = tolerance or self.tolerance
        now = self._evaluation("evaluate", self._evaluate)
        first = now.residual if measure else 0.0
        if guess:
            now = self._try_guess(now, guess)
        iterations, stalled = 0, False
        while math.isfinite(now.residual):
            wanted = min(tolerance * max(now.scale, first), share * (now.scale or math.inf))
            if not jumps and now.residual <= (max(wanted, now.floor(first)) if stalled else wanted):
                return self._count(iterations, now, first, found=True)
            if iterations == MOST_ITERATIONS:
                break
            iterations += 1
            self._find_direction()
            done = self._search(now, jumps=jumps)
            if done is None:
                now, stalled = self._return(), True
                if jumps or now.residual > now.floor(first):
                    break
                continue
            stalled = done[0].residual > STALLED * now.residual
            now, whole = done
            jumps = jumps and not whole
        return self._count(iterations, now, first, found=False)

    def _try_guess(self, now: Evaluation, guess: Callable[[], None]) -> Evaluation:
        """Take an initial guess if its residual is smaller."""
        wp.copy(self._kept, self._state.u)
        self._run("guess", guess)
        there = self._evaluation("evaluate", self._evaluate)
        return there if there.residual < now.residual else self._return()

    def _return(self) -> Evaluation:
        """Return to the displacements that were kept, and evaluate there."""
        wp.copy(self._state.u, self._kept)
        return self._evaluation("evaluate", self._evaluate)

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what the solvers have learnt and counted, by name, for a checkpoint."""
        counted = {"newton_statistics": self.statistics.state(), "linear_statistics": self.solver.statistics.numpy()}
        return {**self.preconditioner.arrays(), **{name: array.copy() for name, array in counted.items()}}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        self.preconditioner.assign(arrays)
        self.statistics.assign(arrays["newton_statistics"])
        self.solver.assign(arrays["linear_statistics"])

    def worst_particle(self) -> int:
        """The particle with the largest residual in the last iteration; NaN counts as the largest."""
        return int(np.argmax(np.abs(self._residual.numpy()).reshape(self._n, -1).max(axis=1)))

    def describe_rounding(self) -> str | None:
        """Cause and remedy if it is rounding that has kept the last solve from its tolerance, else None."""
        return describe_rounding(*self._last, self._farthest, single=self._single)

    def _count(self, iterations: int, last: Evaluation, first: float, *, found: bool) -> bool:
        done = self.statistics
        done.solves += 1
        done.iterations += iterations
        done.most_iterations = max(done.most_iterations, iterations)
        done.worst_residual = max(done.worst_residual, last.residual / (max(last.scale, first) or 1.0))
        self._last = last, first
        if not found:
            self._farthest = float(np.linalg.norm(self._state.u.numpy(), axis=1).max())
        return found

    def _search(self, start: Evaluation, *, jumps: bool) -> tuple[Evaluation, bool] | None:
        """Armijo backtracking along the change: the evaluation there, and whether the full step was taken.

        None if no step length decreases the potential. While held axes move, the potential gives no criterion, and the
        largest step with a finite potential is taken.
        """
        slope = float(self._numbers.numpy()[names.SLOPE])
        if not jumps and not slope > 0.0:
            # the tangent is not positive definite here: steepest descent
            self._run("descend", self._descend)
            slope = float(self._numbers.numpy()[names.SLOPE])
        part = 1.0
        for _ in range(MOST_HALVINGS):
            self._step.fill_(part)
            now = self._evaluation("try", self._try)
            slack = self._rounding * (abs(start.potential) + abs(now.potential) + slope)
            wanted = start.potential - ARMIJO * part * slope + slack
            falls = now.potential <= wanted
            if not falls and now.residual < start.residual:
                # the potential of the weight of a body that has drifted far is much larger than its change
                falls = now.potential <= wanted + self._rounding * (start.terms + now.terms)
            if falls or (jumps and math.isfinite(now.potential)):
                return now, part == 1.0
            # minimum of the parabola through the known values, within bounds
            rise = now.potential - start.potential + part * slope
            best = 0.5 * slope * part / rise if math.isfinite(rise) and rise > 0.0 else 0.1
            part *= min(max(best, 0.1), 0.5)
        return None

    def _evaluation(self, name: str, launch: Callable[[], None]) -> Evaluation:
        self._run(name, launch)
        numbers = self._numbers.numpy()
        return Evaluation(
            residual=math.sqrt(numbers[names.RESIDUAL]),
            scale=math.sqrt(numbers[names.SCALE]),
            rounding=math.sqrt(numbers[names.ROUNDING]),
            potential=0.5 * float(numbers[names.POTENTIAL]),
            # at least the sum of the particles' magnitudes
            terms=0.5 * math.sqrt(self._n * float(numbers[names.POTENTIAL + 1])),
        )

    def _evaluate(self) -> None:
        """Forces, residual and potential of the present displacements."""
        state, vectors = self._state, self.tangent.vectors
        for _, launch in self._model.passes:
            launch(state, 0, self._n)
        self._model.launch_energy(state, self._energy)
        inputs = [self._free, self._mass, self.inertia, self._stiffness]
        inputs += [state.u, self.center, state.force, self.applied, self._energy]
        outputs = [vectors(self._residual), vectors(self._scale), vectors(self._rounded), self._potential]
        self._launch(self._kernels.residual, inputs, outputs)
        self._store(names.RESIDUAL, self._sums[0].launch(self._residual, self._residual, self._change))
        self._store(names.SCALE, self._sums[0].launch(self._scale, self._scale, self._scale))
        self._store(names.ROUNDING, self._sums[0].launch(self._rounded, self._rounded, self._rounded))
        self._store(names.POTENTIAL, self._sums[1].launch(self._potential, self._ones, self._potential))

    def _find_direction(self) -> None:
        reuse = self.preconditioner.reuse
        if reuse.rebuild_due:
            self.preconditioner.rebuild()
        self._run("direct", self._direct)
        reuse.record_solve(self.solver.read_statistics().last_iterations)

    def _direct(self) -> None:
        """Newton direction: solve (K + m a) du = r at the present state."""
        kernels, vectors = self._kernels, self.tangent.vectors
        wp.copy(self._kept, self._state.u)
        self._launch(kernels.jump, [self._free, self._state.u, self.target], [vectors(self._jump)])
        self.tangent.multiply(self._jump, self._pushed)
        inputs = [self._free, vectors(self._residual), vectors(self._pushed)]
        self._launch(kernels.right_hand_side, inputs, [vectors(self._right), vectors(self._change)])
        self.solver.solve(self.tangent.operator, self._right, self._change)
        self._end_direction()

    def _descend(self) -> None:
        """Steepest descent direction in the norm of the diagonal blocks, which are positive in any state."""
        self.tangent.apply(self._residual, self._change)
        self._end_direction()

    def _end_direction(self) -> None:
        vectors = self.tangent.vectors
        self._launch(self._kernels.add_jump, [vectors(self._jump)], [vectors(self._change)])
        self._store(names.RESIDUAL, self._sums[0].launch(self._residual, self._residual, self._change))

    def _try(self) -> None:
        inputs = [self._step, self._kept, self.tangent.vectors(self._change)]
        self._launch(self._kernels.trial, inputs, [self._state.u])
        self._evaluate()

    def _store(self, place: int, sums: wp.array) -> None:
        wp.launch(self._kernels.store_sums, 1, [place, sums], [self._numbers], device=self._device)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._n, inputs, outputs, device=self._device)

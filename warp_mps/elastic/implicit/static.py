"""Static equilibrium: elastic bodies under loads that grow step by step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.explicit.solid import Solid
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.newton import Newton
from warp_mps.elastic.implicit.statistics import solver_record
from warp_mps.elastic.implicit.step_kernels import step_kernels
from warp_mps.errors import RunError
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import select_held
from warp_mps.results.energy import Energy
from warp_mps.scene import Scene, TableMotion

# an increment is halved at most so often where its equilibrium is not found
MOST_HALVINGS = 6


class StaticSolid(Solid):
    """The elastic bodies of a scene in equilibrium with a part of its loads, the load factor, which is the time.

    Weight, loads and the way of moving supports, which ends where their tables do, grow in proportion to it. The weight
    counts as a load: what it does is work, and there is no potential energy.
    """

    def __init__(
        self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any, graphs: bool = True
    ) -> None:
        super().__init__(scene, particles, dt=1.0, types=types, device=device)
        assert isinstance(self.model, HamiltonianModel)
        state = self.state
        held = self.boundary.held
        self._kernels = step_kernels(types)
        self.newton = Newton(self.model, particles, state, self._mass, held, types=types, device=device, graphs=graphs)
        # no inertia makes the first equation easy
        self.newton.preconditioner.reuse.request_rebuild()
        self._free = wp.array(~held, dtype=types.vec, device=device)
        weights = np.outer(self._masses, scene.gravity) if len(scene.gravity) else np.zeros(held.shape)
        self._load = wp.array(weights, dtype=types.vec, device=device)
        self.boundary.push(self._load, self._mass, 0.0)
        self._ends = wp.array(_ends(scene, particles), dtype=types.vec, device=device)
        self._factor = wp.zeros(1, dtype=wp.float64, device=device)
        self._part = wp.zeros(1, dtype=wp.float64, device=device)
        # load factors of the present equilibrium and of the one before it, and the displacements of that
        self._reached = self._earlier = 0.0
        self._u_earlier = wp.zeros_like(state.u)
        self._before = [wp.zeros_like(state.u) for _ in range(3)]
        self._work = wp.zeros(self._n, dtype=wp.float64, device=device)
        state.v.zero_()

    def start(self) -> None:
        """Evaluate the forces of the unloaded bodies."""
        self._elastic_forces()

    def advance(self, time: float) -> None:
        """Load the bodies up to a load factor.

        Raises:
            RunError: No equilibrium was found, even in small increments; the state is the last one that was found.
        """
        increment = time - self._reached
        smallest = increment * 0.5**MOST_HALVINGS
        while self._reached < time:
            # the last increment ends where it should, not where rounding puts it
            to = time if self._reached + 1.001 * increment >= time else self._reached + increment
            if self._load_to(to):
                continue
            increment *= 0.5
            if increment < smallest:
                raise RunError(self._not_found())

    def energy(self) -> Energy:
        """Energies of the present state; that of the weight is in the work."""
        return replace(super().energy(), potential=0.0)

    def work(self) -> float:
        """Work of weight, loads and moving supports so far [J]."""
        return float(np.sum(self._work.numpy()))

    def reactions(self) -> np.ndarray:
        """Force that the supports exert on each particle [N], shape [n, d]."""
        forces = self.state.force.numpy() + self.newton.applied.numpy()
        return np.where(self.boundary.held, -forces, 0.0)

    def internal_forces(self) -> np.ndarray:
        """Elastic forces [N], shape [n, d]."""
        return self.state.force.numpy().astype(float)

    def record(self) -> dict[str, dict[str, float]]:
        """What the solvers did, for run.json."""
        return {"implicit": solver_record(self.newton)}

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        own = {"static_work": self._work, "applied": self.newton.applied, "u_earlier": self._u_earlier}
        copies = {name: array.numpy().copy() for name, array in own.items()}
        solver = self.newton.preconditioner.arrays()
        return {**super().arrays(), **copies, **solver, "factors": np.array([self._earlier, self._reached])}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        super().assign(arrays)
        self._earlier, self._reached = (float(factor) for factor in arrays["factors"])
        self._u_earlier.assign(arrays["u_earlier"])
        self._work.assign(arrays["static_work"])
        self.newton.applied.assign(arrays["applied"])
        self.newton.preconditioner.assign(arrays)
        self._elastic_forces()

    def _not_found(self) -> str:
        """Why there may be no further equilibrium, and where it was missed by most."""
        causes = "a body is held too little to stay where it is, it buckles, or more load steps are needed"
        if self._types.precision == "float32":
            # rounding of the large forces that cancel in it leaves more than the residual that is asked for
            causes += "; or it is too slender for single precision"
        worst = self._particles.describe(self.newton.worst_particle())
        factor = f"{self._reached:.6g}"
        return f"no equilibrium was found beyond a load factor of {factor}: {causes}; {worst} was furthest from it"

    def _load_to(self, factor: float) -> bool:
        """Find the equilibrium of a load factor; where there is none, the state is as it was."""
        state, newton = self.state, self.newton
        for kept, now in zip(self._before, (state.u, state.force, newton.applied), strict=True):
            wp.copy(kept, now)
        self._factor.fill_(factor)
        self._launch(self._kernels.ramp, [self._factor, self._load, self._ends], [newton.applied, newton.target])
        # the search begins where the last increment leads to
        last = self._reached - self._earlier
        self._part.fill_((factor - self._reached) / last if last > 0.0 else 0.0)
        self._launch(self._kernels.predict, [self._part, self._free, self._u_earlier], [state.u])
        if not newton.solve(jumps=self.boundary.driven):
            wp.copy(state.u, self._before[0])
            wp.copy(newton.applied, self._before[2])
            self._elastic_forces()
            return False
        inputs = [self._free, *self._before, state.u, state.force, newton.applied]
        self._launch(self._kernels.static_work, inputs, [self._work])
        wp.copy(self._u_earlier, self._before[0])
        self._earlier, self._reached = self._reached, factor
        return True

    def _elastic_forces(self) -> None:
        for _, launch in self.model.passes:
            launch(self.state, 0, self._n)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._n, inputs, outputs, device=self._device)


def _ends(scene: Scene, particles: Particles) -> np.ndarray:
    """Where moving supports bring the axes that they hold [m], 0 elsewhere, shape [n, d]."""
    ends = np.zeros(particles.positions.shape)
    for support in scene.supports:
        if isinstance(support.motion, TableMotion):
            axes = sorted(support.axes) or range(particles.dimension)
            here = np.ix_(select_held(particles, support), np.array(axes))
            ends[here] = np.asarray(support.motion.displacements, float)[-1][np.array(axes)]
    return ends

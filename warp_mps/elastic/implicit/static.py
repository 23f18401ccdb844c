"""Static equilibrium: elastic bodies under loads that grow step by step.

The load factor s takes the place of the time. Equilibrium at s is f_el(u) + s f = 0 on the free axes, with f the weight
and the loads, and u = s u_end on the axes of moving supports.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.newton import Newton
from warp_mps.elastic.implicit.statistics import solver_record
from warp_mps.elastic.implicit.step_kernels import step_kernels
from warp_mps.elastic.parts import SolidParts
from warp_mps.elastic.readings import SolidReadings
from warp_mps.elastic.solid_state import SolidState
from warp_mps.elastic.system import ElasticSystem
from warp_mps.errors import RunError
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import select_held
from warp_mps.results.energy import Energy
from warp_mps.scene import Scene, TableMotion

# most halvings of a load increment whose equilibrium is not found
MOST_HALVINGS = 6


class LoadSteps:
    """Load stepping: one equilibrium after another, each from an extrapolation of the last two.

    Attributes:
        newton: The solver of an equilibrium.
        work: Work of weight, loads and supports so far [J], float64 [n].

    Args:
        scene: The case.
        parts: The parts of the bodies.
        graphs: Whether launches are replayed as graphs.
    """

    def __init__(self, scene: Scene, parts: SolidParts, *, graphs: bool) -> None:
        assert isinstance(parts.model, HamiltonianModel)
        types, device, state = parts.types, parts.device, parts.state
        self._parts, self._kernels = parts, step_kernels(types)
        held = parts.boundary.held
        options: dict[str, Any] = {"types": types, "device": device, "graphs": graphs}
        self.newton = Newton(parts.model, parts.particles, state, parts.mass, held, **options)
        # without inertia the first equation is already ill-conditioned
        self.newton.preconditioner.reuse.request_rebuild()
        self._free = wp.array(~held, dtype=types.vec, device=device)
        weights = np.outer(parts.masses, scene.gravity) if len(scene.gravity) else np.zeros(held.shape)
        self._load = wp.array(weights, dtype=types.vec, device=device)
        parts.boundary.add_loads(self._load, parts.mass, 0.0)
        self._ends = wp.array(_ends(scene, parts.particles), dtype=types.vec, device=device)
        self._factor = wp.zeros(1, dtype=wp.float64, device=device)
        self._part = wp.zeros(1, dtype=wp.float64, device=device)
        # load factors of the present equilibrium and of the one before it, and the displacements of the latter
        self._reached = self._earlier = 0.0
        self._u_earlier = wp.zeros_like(state.u)
        self._before = [wp.zeros_like(state.u) for _ in range(3)]
        self.work = wp.zeros(parts.count, dtype=wp.float64, device=device)
        state.v.zero_()

    def advance(self, factor: float) -> None:
        """Load the bodies up to a load factor, in increments that are halved where no equilibrium is found.

        Raises:
            RunError: No equilibrium was found, even in small increments; the state is the last one that was found.
        """
        increment = factor - self._reached
        smallest = increment * 0.5**MOST_HALVINGS
        while self._reached < factor:
            # the last increment ends at the factor itself, not at its rounded sum
            to = factor if self._reached + 1.001 * increment >= factor else self._reached + increment
            if self._load_to(to):
                continue
            increment *= 0.5
            if increment < smallest:
                raise RunError(self._not_found())

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        own = {"static_work": self.work, "applied": self.newton.applied, "u_earlier": self._u_earlier}
        copies = {name: array.numpy().copy() for name, array in own.items()}
        factors = np.array([self._earlier, self._reached])
        return {**copies, **self.newton.arrays(), "factors": factors}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self._earlier, self._reached = (float(factor) for factor in arrays["factors"])
        self._u_earlier.assign(arrays["u_earlier"])
        self.work.assign(arrays["static_work"])
        self.newton.applied.assign(arrays["applied"])
        self.newton.assign(arrays)
        self._parts.evaluate_model()

    def _not_found(self) -> str:
        """Why there may be no further equilibrium, and which particle was furthest from it."""
        causes = (
            self.newton.describe_rounding()
            or "a body is held too little to stay where it is, it buckles, or more load steps are needed"
        )
        worst = self._parts.particles.describe(self.newton.worst_particle())
        factor = f"{self._reached:.6g}"
        return f"no equilibrium was found beyond a load factor of {factor}: {causes}; {worst} was furthest from it"

    def _load_to(self, factor: float) -> bool:
        """Find the equilibrium of a load factor; restore the state if it is not found."""
        state, newton = self._parts.state, self.newton
        for kept, now in zip(self._before, (state.u, state.force, newton.applied), strict=True):
            wp.copy(kept, now)
        self._factor.fill_(factor)
        self._launch(self._kernels.scale_loads, [self._factor, self._load, self._ends], [newton.applied, newton.target])
        # initial guess: the last increment, continued
        last = self._reached - self._earlier
        self._part.fill_((factor - self._reached) / last if last > 0.0 else 0.0)
        self._launch(self._kernels.extrapolate_increment, [self._part, self._free, self._u_earlier], [state.u])
        self._parts.inversions.keep()
        found = newton.solve(jumps=self._parts.boundary.supports_move)
        self._parts.inversions.recall()
        if not found:
            wp.copy(state.u, self._before[0])
            wp.copy(newton.applied, self._before[2])
            self._parts.evaluate_model()
            return False
        self._parts.inversions.note(self._parts.model.gradients(state))
        inputs = [self._free, *self._before, state.u, state.force, newton.applied]
        self._launch(self._kernels.static_work, inputs, [self.work])
        wp.copy(self._u_earlier, self._before[0])
        self._earlier, self._reached = self._reached, factor
        return True

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._parts.count, inputs, outputs, device=self._parts.device)


class StaticReadings(SolidReadings):
    """Readings of bodies in equilibrium.

    The weight counts as a load: its work is work, and there is no potential energy.

    Args:
        parts: The parts of the bodies.
        steps: The load steps.
    """

    def __init__(self, parts: SolidParts, steps: LoadSteps) -> None:
        super().__init__(parts)
        self._steps = steps

    def energy(self) -> Energy:
        """Energies of the present state [J]; that of the weight is in the work."""
        return replace(super().energy(), potential=0.0)

    def work(self) -> float:
        """Work of weight, loads and moving supports so far [J]."""
        return float(np.sum(self._steps.work.numpy()))

    def reactions(self) -> np.ndarray:
        """Force that the supports exert on each particle [N], shape [n, d]."""
        forces = self.parts.state.force.numpy() + self._steps.newton.applied.numpy()
        return np.where(self.parts.boundary.held, -forces, 0.0)

    def internal_forces(self) -> np.ndarray:
        """Elastic forces [N], shape [n, d]."""
        return self.parts.state.force.numpy().astype(float)


class StaticSolid(ElasticSystem):
    """The elastic bodies of a scene in equilibrium with a part of their loads: the load factor, which is the time.

    Weight, loads and the displacements of moving supports, which end with their tables, grow in proportion to it.

    Attributes:
        newton: The solver of an equilibrium.

    Args:
        scene: The case.
        particles: Its particles.
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
    """

    def __init__(
        self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any, graphs: bool = True
    ) -> None:
        parts = SolidParts(scene, particles, dt=1.0, types=types, device=device)
        self._steps = LoadSteps(scene, parts, graphs=graphs)
        self.newton = self._steps.newton
        super().__init__(parts, SolidState(parts), StaticReadings(parts, self._steps))

    def start(self) -> None:
        """Evaluate the forces of the unloaded bodies."""
        self.parts.evaluate_model()

    def advance(self, time: float) -> None:
        """Load the bodies up to a load factor.

        Raises:
            RunError: No equilibrium was found, even in small increments; the state is the last one that was found.
        """
        self._steps.advance(time)

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of the solvers, for run.json."""
        return {"implicit": solver_record(self.newton)}

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of everything that evolves, by name, for a checkpoint."""
        return {**super().arrays(), **self._steps.arrays()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        super().assign(arrays)
        self._steps.assign(arrays)


def _ends(scene: Scene, particles: Particles) -> np.ndarray:
    """Displacements at the end of the tables of moving supports, along the axes that they hold [m], shape [n, d]."""
    ends = np.zeros(particles.positions.shape)
    for support in scene.supports:
        if isinstance(support.motion, TableMotion):
            axes = sorted(support.axes) or range(particles.dimension)
            here = np.ix_(select_held(particles, support), np.array(axes))
            ends[here] = np.asarray(support.motion.displacements, float)[-1][np.array(axes)]
    return ends

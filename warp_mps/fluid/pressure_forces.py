"""Forces of the pressure: on fluid particles by its gradient, and on the particles of walls."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.neighbours import NeighbourLists
from warp_mps.fluid.pressure.equation import PressureEquation
from warp_mps.fluid.schemes import CONSERVATIVE
from warp_mps.fluid.state import FluidState


class PressureForces:
    """Forces of the pressure; see `warp_mps.fluid.gradient` for their equations.

    Attributes:
        slopes: Slopes of the pressure along walls [Pa/m], of particles beside their faces, vec [m].

    Args:
        model: Constants of the run.
        state: State of the fluid.
        neighbours: Neighbour lists.
        equation: The pressure Poisson equation, of which faces and density scales are taken.
    """

    def __init__(
        self, model: FluidModel, state: FluidState, neighbours: NeighbourLists, equation: PressureEquation
    ) -> None:
        self._model, self._state, self._neighbours, self._equation = model, state, neighbours, equation
        self._kernels = fluid_kernels(model.types)
        self.slopes = wp.zeros(model.count, dtype=model.types.vec, device=model.device)

    def find_slopes(self) -> None:
        """Launch the slopes of the pressure along walls, where the scheme mirrors there."""
        model, state, equation, lists = self._model, self._state, self._equation, self._neighbours
        if model.scheme == CONSERVATIVE:
            inputs = [model.constants, lists.table, state.x, state.a, state.p]
            inputs += [equation.normal, equation.depth, equation.rest]
            model.launch(self._kernels.wall_tangential_gradient, model.count, inputs, [self.slopes])

    def accelerate(self, dt: wp.array, du: wp.array) -> None:
        """Launch the change of velocity du = -dt grad p / rho of fluid particles.

        Args:
            dt: Time step [s], float64 [1].
            du: Changes of velocity [m/s], vec [m]; written.
        """
        model, state, lists = self._model, self._state, self._neighbours
        inputs = [model.constants, lists.table, dt, state.x, state.a, state.p]
        inputs += [self._equation.density_scale, self.slopes, self._equation.rest]
        model.launch(self._kernels.pressure_velocity_change, model.count, inputs, [du])

    def add_wall_impulse(self, count: int, dt: wp.array, impulse: wp.array, work: wp.array) -> None:
        """Launch the impulses on the first particles of walls in a time, and the walls' work.

        Args:
            count: Number of wall particles.
            dt: The time [s], float64 [1].
            impulse: Impulses [N s], vec64 [w]; added to.
            work: Work of the walls on the fluid [J], float64 [w]; added to.
        """
        model, state, lists = self._model, self._state, self._neighbours
        inputs = [model.constants, lists.table, dt, state.x, state.u, state.a, state.p]
        inputs += [self._equation.density_scale, self.slopes, self._equation.rest]
        model.launch(self._kernels.pressure_wall_impulse, count, inputs, [impulse, work])

    def wall_pressures(self) -> np.ndarray:
        """Pressures of the fluid beside the particles of walls [Pa], shape [w]."""
        model, state, lists = self._model, self._state, self._neighbours
        p = wp.zeros(max(model.walls, 1), dtype=wp.float64, device=model.device)
        inputs = [model.constants, lists.table, state.x, state.a, state.p]
        model.launch(self._kernels.wall_pressure, model.walls, inputs, [p])
        return p.numpy()[: model.walls]

"""The pressure Poisson equation of a step: its room, its assembly, its solution, and bounds on the pressure."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Matrix, Product
from warp_mps.core.multigrid.preconditioner import MultigridPreconditioner
from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.neighbours import NeighbourLists
from warp_mps.fluid.schemes import CONSERVATIVE
from warp_mps.fluid.state import FluidState

# fluid particles that one thread goes through when the least pressure is sought
CHUNK = 512
MAX_ITERATIONS = 2000


class PressureEquation:
    """The pressure Poisson equation A p = b of m fluid particles, and the quantities that its assembly finds.

    Attributes:
        matrix: A; its arrays have room for as many entries a row as the neighbour lists have.
        rhs: b, float64 [m].
        surface: 1 for particles of the free surface, else 0, int32 [m].
        density_scale: Factor of the density in gradients [-], see `warp_mps.fluid.pressure.rows`, real [m].
        normal: Unit normal of the wall's face that a particle is beside, else 0, vec [m].
        depth: Distance from that face [m], 0 if there is none, real [m].
        rest: Share by which the water is at rest [-], see `warp_mps.fluid.still_water`, real [1].
        tilt: Offset of a particle's pair vectors to walls beside a face [m], vec [m]; see there.
        solver: Its solver.

    Args:
        model: Constants of the run.
        state: State of the fluid.
        neighbours: Neighbour lists.
    """

    def __init__(self, model: FluidModel, state: FluidState, neighbours: NeighbourLists) -> None:
        self._model, self._state, self._neighbours = model, state, neighbours
        types, m = model.types, model.count
        self._kernels = fluid_kernels(types)
        self.matrix = Matrix(
            rows=wp.array([m], dtype=wp.int32, device=model.device),
            first=self._zeros(m, wp.int32),
            count=self._zeros(m, wp.int32),
            index=self._zeros(m * neighbours.listed.shape[1], wp.int32),
            value=self._zeros(m * neighbours.listed.shape[1], types.real),
            diagonal=self._zeros(m, types.real),
            active=self._zeros(m, wp.int32),
            singular=self._zeros(1, wp.int32),
        )
        self.rhs, self.surface = self._zeros(m, wp.float64), self._zeros(m, wp.int32)
        self.density_scale = wp.ones(m, dtype=types.real, device=model.device)
        self.normal, self.depth = self._zeros(m, types.vec), self._zeros(m, types.real)
        self.tilt = self._zeros(m, types.vec)
        self.rest, self._fastest = self._zeros(1, types.real), self._zeros(-(-m // CHUNK), types.real)
        self._settled = self._zeros(1, wp.int32)
        self._may_rest = model.scheme == CONSERVATIVE and bool(model.clip) and bool(np.any(model.gravity))
        self.solver = ConjugateGradient(
            m,
            types=types,
            device=model.device,
            tolerance=model.tolerance,
            max_iterations=MAX_ITERATIONS,
            preconditioner=_preconditioner(model, state),
        )
        self._least = self._zeros(-(-m // CHUNK), wp.float64)
        self._not_singular = self._zeros(1, wp.int32)

    def resize(self) -> None:
        """Give the rows the room that the neighbour lists have."""
        room = self._model.count * self._neighbours.listed.shape[1]
        index, value = self._zeros(room, wp.int32), self._zeros(room, self._model.types.real)
        self.matrix = self.matrix._replace(index=index, value=value)

    def assemble(self, dt: wp.array) -> None:
        """Launch the assembly for a time step [s], float64 [1]."""
        model, state, matrix = self._model, self._state, self.matrix
        assert matrix.singular is not None
        matrix.singular.fill_(1)
        self.find_planes()
        self.find_rest(dt)
        inputs = [model.constants, self._neighbours.table, dt, state.x, state.u, state.a, state.p]
        inputs += [self.normal, self.depth, self.rest]
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, matrix.active]
        outputs = [state.n, self.density_scale, *rows, self.rhs, self.surface, self.tilt, matrix.singular]
        model.launch(self._kernels.assemble, model.count, inputs, outputs)

    def find_planes(self) -> None:
        """Launch the search for the faces of walls that fluid particles are beside, where the scheme mirrors there."""
        model = self._model
        if model.scheme == CONSERVATIVE:
            inputs = [model.constants, self._neighbours.table, self._state.x]
            model.launch(self._kernels.find_mirror_planes, model.count, inputs, [self.normal, self.depth])

    def find_rest(self, dt: wp.array) -> None:
        """Launch the share by which the water is at rest, from predicted velocities of a step [s], float64 [1]."""
        model = self._model
        if self._may_rest:
            inputs = [model.constants, CHUNK, dt, self._state.u]
            model.launch(self._kernels.chunk_speeds, len(self._fastest), inputs, [self._fastest])
            outputs = [self.rest, self._settled]
            model.launch(self._kernels.find_rest, 1, [model.constants, self._fastest], outputs)
            inputs = [model.constants, self._neighbours.table, self._state.x, self.rest]
            model.launch(self._kernels.find_unsettled, model.count, inputs, [self._settled])
            model.launch(self._kernels.settle, 1, [self._settled], [self.rest])

    def solve(self) -> None:
        """Launch the solve from the last pressures, and clip negative ones or make the least of a closed fluid 0."""
        self.solver.solve(self.matrix, self.rhs, self._state.p)
        self._bound(self.matrix.singular)

    def solve_with(self, product: Product, *, same: bool) -> None:
        """Launch the solve of a fluid with a free surface, with more in the matrix than its rows hold.

        Args:
            product: Adds to the product with the matrix; `rest` of `ConjugateGradient.solve`.
            same: Whether the matrix is that of the last solve, so that the preconditioner is reused.
        """
        matrix = self.matrix._replace(singular=None)
        self.solver.solve(matrix, self.rhs, self._state.p, extra_product=product, reuse_preconditioner=same)
        self._bound(self._not_singular)

    def _bound(self, singular: wp.array | None) -> None:
        """Clip negative pressures, or make the least pressure 0 where constants are in the null space."""
        model, p = self._model, self._state.p
        model.launch(self._kernels.chunk_minima, len(self._least), [CHUNK, p], [self._least])
        model.launch(self._kernels.set_level, model.count, [model.clip, singular, self._least], [p])

    def _zeros(self, length: int, kind: Any) -> wp.array:
        return wp.zeros(length, dtype=kind, device=self._model.device)


def _preconditioner(model: FluidModel, state: FluidState) -> MultigridPreconditioner:
    """A multigrid preconditioner over the box of the particles, along periodic axes over the domain."""
    x = model.particles.positions
    wraps = np.isin(np.arange(model.types.dimension), model.periodic)
    return MultigridPreconditioner(
        state.x[model.walls :],
        low=np.where(wraps, model.low, np.maximum(x.min(axis=0), model.low)),
        high=np.where(wraps, model.high, np.minimum(x.max(axis=0), model.high)),
        reach=model.operators.radius,
        types=model.types,
        device=model.device,
        periodic=model.periodic,
    )

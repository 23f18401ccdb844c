"""The Robin term of the pressure Poisson equation: how the accelerations of the markers answer to pressure.

Its equations are in `warp_mps.coupling.robin_kernels`. The term is linear about forces F0 on the markers, the
linearization point: their accelerations are taken for a + b (F(p) - F0), b the mobility. Where F(p) = F0, which is what
the passes of a step converge to, the term is gone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.coupling.robin_kernels import coupling_kernels
from warp_mps.fluid.step import FluidStep


class RobinTerm:
    """Adds the Robin term of e markers to the equation of m fluid particles.

    Attributes:
        wet: 1 for fluid particles with a marker among their neighbours, else 0, int32 [m].
        diagonal: What the term adds to the diagonal, where `wet`, real [m].
        linearization: Linearization point F0: forces on the markers [N], vec [e].
        forces: Forces F(p) of the last pressures on the markers, as the term approximates them [N], vec [e].

    Args:
        step: The step of the fluid.
        count: Number of markers e; they are the first of its wall particles.
        mobility: Mobility b of each marker [1/kg], real [e].
    """

    def __init__(self, step: FluidStep, count: int, mobility: wp.array) -> None:
        self._step, self._count, self._mobility, model = step, count, mobility, step.model
        types, device, m = model.types, model.device, model.count
        self._kernels = coupling_kernels(types)
        self.wet = wp.zeros(m, dtype=wp.int32, device=device)
        self.diagonal = wp.zeros(m, dtype=types.real, device=device)
        self.linearization, self.forces, self._vectors = (
            wp.zeros(count, dtype=types.vec, device=device) for _ in range(3)
        )
        self._rhs, self._pressures = (wp.zeros(m, dtype=wp.float64, device=device) for _ in range(2))
        # as in the first pass of a solver: forces of the pressures, not of a search direction
        self._fresh = wp.ones(CONTROLS, dtype=wp.int32, device=device)

    def begin(self) -> None:
        """Launch what a newly assembled equation needs: its right-hand side is kept, and wet particles are found."""
        model, lists = self._step.model, self._step.neighbours
        wp.copy(self._rhs, self._step.pressure.rhs)
        inputs = [model.walls, self._count, lists.listed, lists.count]
        model.launch(self._kernels.find_wet, model.count, inputs, [self.wet])

    def add_to_diagonal(self) -> None:
        """Launch the addition to the diagonal of the matrix."""
        model, pressure, lists = self._step.model, self._step.pressure, self._step.neighbours
        inputs = [model.walls, self._count, *self._geometry(), model.density, model.volume, lists.listed, lists.count]
        inputs += [self.wet, self._mobility, self._step.state.x, pressure.tilt]
        model.launch(self._kernels.stiffen, model.count, inputs, [pressure.matrix.diagonal, self.diagonal])

    def set_rhs(self) -> None:
        """Launch the right-hand side: the one that was kept, and what a - b F0 adds to it."""
        wp.copy(self._step.pressure.rhs, self._rhs)
        self.add_to_rhs(self._step.pressure.rhs)

    def add_to_rhs(self, rhs: wp.array) -> None:
        """Launch the addition of rho sum_j c (b_j F0_j - a_j) . x_ij to a right-hand side, float64 [m]."""
        model, state = self._step.model, self._step.state
        inputs = [self._mobility, self.linearization, state.a]
        model.launch(self._kernels.answer, self._count, inputs, [self._vectors])
        inputs = [*self._rows(), state.x, self._step.pressure.tilt, self._vectors]
        model.launch(self._kernels.couple, model.count, inputs, [rhs])

    def multiply(self, control: wp.array, p: wp.array, direction: wp.array, q: wp.array) -> None:
        """Launch the addition of the term, off the diagonal, to a product q = A p; see `Product` of the solver.

        Args:
            control: Control of the solver, int32.
            p: Pressures [Pa], float64 [m].
            direction: Search direction, float64 [m].
            q: Product; added to, float64 [m].
        """
        model, state, tilt = self._step.model, self._step.state, self._step.pressure.tilt
        self._find_forces(control, p, direction, self._vectors)
        inputs = [*self._rows(), self.diagonal, self._mobility, control, state.x, tilt, self._vectors, p, direction]
        model.launch(self._kernels.couple_product, model.count, inputs, [q])

    def find_forces(self, p: wp.array) -> None:
        """Launch the forces F_j = V sum_l c p_l x_lj of pressures [Pa], float64 [m], on the markers."""
        self._find_forces(self._fresh, p, p, self.forces)

    def forces_of(self, pressures: np.ndarray) -> np.ndarray:
        """The forces F(p) [N], shape [e, d], of pressures [Pa], shape [m]."""
        self._pressures.assign(pressures)
        self.find_forces(self._pressures)
        return self.forces.numpy().astype(float)

    def _find_forces(self, control: wp.array, p: wp.array, direction: wp.array, forces: wp.array) -> None:
        model, state, lists = self._step.model, self._step.state, self._step.neighbours
        inputs = [model.walls, *self._geometry(), model.volume, lists.listed, lists.count, control, state.x]
        inputs += [self._step.pressure.tilt, p, direction]
        model.launch(self._kernels.respond, self._count, inputs, [forces])

    def _rows(self) -> list[Any]:
        """Arguments of kernels over the rows of wet particles."""
        model, lists = self._step.model, self._step.neighbours
        return [model.walls, self._count, *self._geometry(), model.density, lists.listed, lists.count, self.wet]

    def _geometry(self) -> list[Any]:
        """Periods, effective radius, spacing, and factor of the Laplacian."""
        ops = self._step.model.operators
        return [self._step.neighbours.period, ops.radius, self._step.model.spacing, ops.laplacian]

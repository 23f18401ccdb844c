"""The Robin term of the pressure Poisson equation: how the accelerations of the markers answer to pressure.

Its equations are in `warp_mps.coupling.robin_kernels`. The term is linear about forces F0 on the markers, the
linearization point: their accelerations are approximated by a + b (F(p) - F0), b the mobility. Where F(p) = F0, to
which the passes of a step converge, the term is gone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.kernels import CONTROLS
from warp_mps.coupling.robin_kernels import robin_constants, robin_kernels
from warp_mps.fluid.step import FluidStep


class RobinTerm:
    """Adds the Robin term of e markers to the equation of m fluid particles.

    Attributes:
        wet: 1 for fluid particles with a marker among their neighbours, else 0, int32 [m].
        diagonal: Part of the diagonal by the term, where `wet` [1/m^2], real [m].
        linearization: Linearization point F0: forces on the markers [N], vec [e].
        forces: Forces F(p) of the last pressures on the markers, as the term approximates them [N], vec [e].

    Args:
        step: The step of the fluid.
        count: Number of markers e; they are the first of its wall particles.
        mobility: Mobility b of each marker [1/kg], real [e].
    """

    def __init__(self, step: FluidStep, count: int, mobility: wp.array) -> None:
        self._step, self._count, self._mobility = step, count, mobility
        types, device, m = step.model.types, step.model.device, step.model.count
        self._kernels = robin_kernels(types)
        self._constants = _constants(step, count)
        self.wet = wp.zeros(m, dtype=wp.int32, device=device)
        self.diagonal = wp.zeros(m, dtype=types.real, device=device)
        self.linearization, self.forces, self._vectors = (
            wp.zeros(count, dtype=types.vec, device=device) for _ in range(3)
        )
        self._rhs, self._pressures = (wp.zeros(m, dtype=wp.float64, device=device) for _ in range(2))
        # as in the first pass of a solver: forces of the pressures, not of a search direction
        self._fresh = wp.ones(CONTROLS, dtype=wp.int32, device=device)

    def begin(self) -> None:
        """Launch what a newly assembled equation needs: its right-hand side is saved, and wet particles are marked."""
        wp.copy(self._rhs, self._step.pressure.rhs)
        inputs = [self._constants, *self._lists()]
        self._step.model.launch(self._kernels.mark_wet, self._step.model.count, inputs, [self.wet])

    def add_to_diagonal(self) -> None:
        """Launch the addition to the diagonal of the matrix."""
        pressure = self._step.pressure
        inputs = [*self._rows(), self._mobility, self._step.state.x, pressure.tilt]
        outputs = [pressure.matrix.diagonal, self.diagonal]
        self._step.model.launch(self._kernels.add_diagonal, self._step.model.count, inputs, outputs)

    def set_rhs(self) -> None:
        """Launch the right-hand side: the saved one, and what the term adds to it."""
        wp.copy(self._step.pressure.rhs, self._rhs)
        self.add_to_rhs(self._step.pressure.rhs)

    def add_to_rhs(self, rhs: wp.array) -> None:
        """Launch the addition to a right-hand side, float64 [m], for the accelerations of the markers."""
        model, state = self._step.model, self._step.state
        inputs = [self._mobility, self.linearization, state.a]
        model.launch(self._kernels.offset_accelerations, self._count, inputs, [self._vectors])
        inputs = [*self._rows(), state.x, self._step.pressure.tilt, self._vectors]
        model.launch(self._kernels.add_rhs, model.count, inputs, [rhs])

    def multiply(self, control: wp.array, p: wp.array, direction: wp.array, q: wp.array) -> None:
        """Launch the addition of the term, off the diagonal, to a product q; see `Product` of the solver.

        Args:
            control: Control of the solver, int32.
            p: Pressures [Pa], float64 [m].
            direction: Search direction, float64 [m].
            q: Product; added to, float64 [m].
        """
        self._find_forces(control, p, direction, self._vectors)
        inputs = [*self._rows(), self.diagonal, self._mobility, control, self._step.state.x, self._step.pressure.tilt]
        inputs += [self._vectors, p, direction]
        self._step.model.launch(self._kernels.add_product, self._step.model.count, inputs, [q])

    def find_forces(self, p: wp.array) -> None:
        """Launch the forces F(p) of pressures [Pa], float64 [m], on the markers."""
        self._find_forces(self._fresh, p, p, self.forces)

    def forces_of(self, pressures: np.ndarray) -> np.ndarray:
        """The forces F(p) [N], shape [e, d], of pressures [Pa], shape [m]."""
        self._pressures.assign(pressures)
        self.find_forces(self._pressures)
        return self.forces.numpy().astype(float)

    def _find_forces(self, control: wp.array, p: wp.array, direction: wp.array, forces: wp.array) -> None:
        inputs = [self._constants, *self._lists(), control, self._step.state.x, self._step.pressure.tilt, p, direction]
        self._step.model.launch(self._kernels.approximate_forces, self._count, inputs, [forces])

    def _rows(self) -> list[Any]:
        """Arguments of kernels over the rows of wet particles."""
        return [self._constants, *self._lists(), self.wet]

    def _lists(self) -> list[wp.array]:
        return [self._step.neighbours.listed, self._step.neighbours.count]


def _constants(step: FluidStep, count: int) -> Any:
    """The constants of the term, with a number of markers."""
    model, ops, constants = step.model, step.model.operators, robin_constants(step.model.types)()
    constants.walls, constants.markers = model.walls, count
    constants.period, constants.spacing = step.neighbours.period, model.spacing
    constants.radius, constants.laplacian = ops.radius, ops.laplacian
    constants.density, constants.volume = model.density, model.volume
    return constants

"""Implicit viscosity: velocities u' = u + dt (g + nu lap u'), for steps that explicit viscosity would not be stable in.

The components are independent of each other, and the matrix, 1 - dt nu lap among the fluid particles, is symmetric and
positive. Walls without slip enter with the velocities that viscosity sees in them, which are those of before the step.
The step then takes nu lap u' as its viscous acceleration, so that what the fluid loses to the walls is what they gain.
"""

import functools
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Matrix
from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid import METHOD
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.neighbour_search import neighbour_table_struct

TOLERANCE, MAX_ITERATIONS = 1e-6, 1000


@functools.cache
def implicit_viscosity_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `implicit_viscosity_rows` and `merge_velocities`."""
    real, vec, d = types.real, types.vec, types.dimension
    Constants, Neighbours = fluid_constants_struct(types), neighbour_table_struct()
    displacement, weight = displacement_function(types), weight_function(types)

    @types.kernel(METHOD)
    def implicit_viscosity_rows(
        # Model:
        fluid: Constants,
        neighbours: Neighbours,
        no_slip: wp.array(dtype=wp.int32),  # 1 for fluid particles and no-slip walls, else 0, [n]
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        x: wp.array(dtype=vec),  # positions [m], [n]
        u: wp.array(dtype=vec),  # velocities [m/s], [n]
        lost: wp.array(dtype=wp.int32),  # 1 for particles that have left the domain, else 0, [n]
        ghost: wp.array(dtype=vec),  # velocities of no-slip ghost particles [m/s], [w]
        # State out:
        first_out: wp.array(dtype=wp.int32),  # first entry of each row, [m]
        count_out: wp.array(dtype=wp.int32),  # number of entries of each row, [m]
        index_out: wp.array(dtype=wp.int32),  # column of each entry, [m room]
        value_out: wp.array(dtype=real),  # entries with their sign turned [-], [m room]
        diagonal_out: wp.array(dtype=real),  # diagonal [-], [m]
        active_out: wp.array(dtype=wp.int32),  # 1 for rows that are solved, else 0, [m]
        rhs_out: wp.array(dtype=wp.float64, ndim=2),  # right-hand sides [m/s], [d, m]
        guess_out: wp.array(dtype=wp.float64, ndim=2),  # first guesses [m/s], [d, m]
    ):
        """Row of a fluid particle, u'_i - dt nu laplacian sum_j w_ij (u'_j - u'_i) = u_i + dt g, by component."""
        k = wp.tid()
        i = k + fluid.walls
        h = real(dt[0])
        x_i = x[i]
        first = k * neighbours.index.shape[1]
        entries = wp.int32(0)
        diagonal = real(1.0)
        rhs = u[i] + h * fluid.gravity
        for m in range(neighbours.count[i]):
            j = neighbours.index[i, m]
            r = wp.length(displacement(x_i, x[j], fluid.period))
            if r < fluid.radius and no_slip[j] == 1 and lost[j] == 0:
                c = h * fluid.viscous_factor * weight(r, fluid.radius)
                diagonal += c
                if j < fluid.walls:
                    rhs += c * ghost[j]
                else:
                    index_out[first + entries] = j - fluid.walls
                    value_out[first + entries] = c
                    entries += 1
        first_out[k] = first
        count_out[k] = entries
        diagonal_out[k] = diagonal
        active_out[k] = 1 - lost[i]
        for axis in range(wp.static(d)):
            rhs_out[axis, k] = wp.float64(rhs[axis])
            guess_out[axis, k] = wp.float64(u[i][axis])

    @types.kernel(METHOD)
    def merge_velocities(
        # Model:
        fluid: Constants,
        # State in:
        u: wp.array(dtype=vec),  # velocities before the step [m/s], [n]
        solution: wp.array(dtype=wp.float64, ndim=2),  # velocities of fluid particles [m/s], [d, m]
        # State out:
        u_out: wp.array(dtype=vec),  # velocities at the end of the step [m/s], [n]
    ):
        """Velocities of all particles: the solution u' of the fluid, u of walls."""
        i = wp.tid()
        u_i = u[i]
        if i >= fluid.walls:
            for axis in range(wp.static(d)):
                u_i[axis] = real(solution[axis, i - fluid.walls])
        u_out[i] = u_i

    return SimpleNamespace(implicit_viscosity_rows=implicit_viscosity_rows, merge_velocities=merge_velocities)


class ImplicitViscosity:
    """Velocities after an implicit step of viscosity.

    Attributes:
        u: Viscous velocities of all particles [m/s], vec [n].
        solver: Solver of each component.

    Args:
        n: Number of particles.
        walls: Number of those that are walls, the first ones.
        matrix: Room for a matrix of the fluid's particles.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, n: int, walls: int, matrix: Matrix, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device, self._n, self._walls = implicit_viscosity_kernels(types), device, n, walls
        self.use(matrix)
        m = n - walls
        self._rhs = wp.zeros((types.dimension, m), dtype=wp.float64, device=device)
        self._solution = wp.zeros((types.dimension, m), dtype=wp.float64, device=device)
        self.solver = ConjugateGradient(
            m, types=types, device=device, tolerance=TOLERANCE, max_iterations=MAX_ITERATIONS
        )
        self.u = wp.zeros(n, dtype=types.vec, device=device)

    def use(self, matrix: Matrix) -> None:
        """Assemble into other arrays from now on."""
        self._matrix = matrix._replace(singular=None)

    def solve(self, constants: Any, inputs: list[Any], u: wp.array) -> None:
        """Launch the solve.

        Args:
            constants: Constants of the run as kernels take them.
            inputs: Arguments of the kernel `implicit_viscosity_rows` up to its outputs.
            u: Velocities before the step [m/s], vec [n].
        """
        matrix, kernels, device = self._matrix, self._kernels, self._device
        outputs = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, matrix.active]
        outputs += [self._rhs, self._solution]
        wp.launch(kernels.implicit_viscosity_rows, self._n - self._walls, inputs, outputs, device=device)
        for axis in range(self._rhs.shape[0]):
            self.solver.solve(matrix, self._rhs[axis], self._solution[axis])
        wp.launch(kernels.merge_velocities, self._n, [constants, u, self._solution], [self.u], device=device)

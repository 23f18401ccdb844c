"""Statistics of the solvers of an implicit run, as run.json holds them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.core.counters import whole_numbers

if TYPE_CHECKING:
    from warp_mps.elastic.implicit.newton import Newton


@dataclass
class NewtonStatistics:
    """Statistics of a solver since its start.

    Attributes:
        solves: Equilibria found.
        iterations: Newton iterations of all solves.
        most_iterations: Newton iterations of the longest solve.
        worst_residual: Largest final residual of the forces, relative to its scale.
    """

    solves: int = 0
    iterations: int = 0
    most_iterations: int = 0
    worst_residual: float = 0.0

    def state(self) -> np.ndarray:
        """The statistics, for a checkpoint, shape [4]."""
        return np.array([self.solves, self.iterations, self.most_iterations, self.worst_residual], float)

    def assign(self, state: np.ndarray) -> None:
        """Continue from what `state` returned.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        self.solves, self.iterations, self.most_iterations = whole_numbers(state[:3])
        self.worst_residual = float(state[3])


def solver_record(newton: Newton) -> dict[str, float]:
    """Iterations of both solvers, renewals of the coarse level, and the largest residual, relative to the forces."""
    done, linear = newton.statistics, newton.solver.read_statistics()
    return {
        "equilibria": done.solves,
        "newton_iterations": done.iterations,
        "most_newton_iterations": done.most_iterations,
        "worst_residual": done.worst_residual,
        "linear_iterations": linear.iterations,
        "most_linear_iterations": linear.most_iterations,
        "coarse_renewals": newton.preconditioner.reuse.rebuilds,
        "unsolved": newton.solver.count_unsolved(),
    }

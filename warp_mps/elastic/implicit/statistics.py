"""Statistics of the solvers of an implicit run, as run.json holds them."""

from __future__ import annotations

from warp_mps.elastic.implicit.newton import Newton


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

"""How small the residual of Newton's method can become, in view of the rounding of the forces that cancel in it.

The kernel `residual` of `warp_mps.elastic.implicit.newton_kernels` gives the rounding of every state: some 1e-16 of the
stiffness times the displacement. A body of steel that has floated by millimetres as a whole has more of it than the
tolerance allows. An iteration that gains no more has then found the solution, as far as the numbers can tell.
"""

from __future__ import annotations

from typing import NamedTuple

# times its rounding that a residual which gains no more may be, and the share of the forces that act that it may be at
# most; measured residuals that stall are 0.1 to 0.8 times their rounding
FLOOR, COARSEST = 2.0, 1e-3
# an iteration that leaves more than this part of the residual gains no more
STALLED = 0.5
# times its rounding that an unsolved equation's residual is, at most, if the rounding is why
ROUNDED = 20.0


class Evaluation(NamedTuple):
    """An evaluation of the equation.

    Attributes:
        residual: Norm of the residual [N].
        scale: Norm of the forces that act [N].
        rounding: Norm of the rounding of the residual [N].
        potential: Potential [J].
        terms: Magnitude of its terms [J].
    """

    residual: float
    scale: float
    rounding: float
    potential: float
    terms: float

    def floor(self, first: float) -> float:
        """Least residual that can be asked for [N].

        Args:
            first: Residual that takes the place of the scale if no forces act [N].
        """
        return min(FLOOR * self.rounding, COARSEST * (self.scale or first))


def describe_rounding(last: Evaluation, first: float, farthest: float, *, single: bool) -> str | None:
    """Cause and remedy if it is the rounding that has kept a solve from its tolerance, else None.

    Args:
        last: Its last evaluation.
        first: Residual that takes the place of the scale if no forces act [N].
        farthest: Largest displacement [m].
        single: Whether the precision is single.
    """
    scale = last.scale or first
    most = COARSEST * scale
    if not (last.residual <= ROUNDED * last.rounding and FLOOR * last.rounding > most > 0.0):
        return None
    remedy = "double precision" if single else f"a Young's modulus {1.1 * FLOOR * last.rounding / most:.2g} times lower"
    return (
        f"the elastic forces are rounded by {last.rounding:.2g} N, for this stiffness and displacements of "
        f"{farthest:.3g} m, against {scale:.3g} N that act (at most {COARSEST / FLOOR:g} of it can be allowed): "
        f"take {remedy}"
    )

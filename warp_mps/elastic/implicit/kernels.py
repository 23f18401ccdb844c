"""Every kernel of the implicit methods, declared together so that their module is compiled once."""

from __future__ import annotations

from warp_mps.core.linear import conjugate_gradient as solver
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.implicit.newton_kernels import newton_kernels
from warp_mps.elastic.implicit.step_kernels import step_kernels
from warp_mps.elastic.implicit.tangent_kernels import METHOD, tangent_kernels
from warp_mps.elastic.implicit.two_level_kernels import two_level_kernels

KERNELS = (tangent_kernels, newton_kernels, step_kernels, two_level_kernels)


def declare_implicit(types: NumericTypes) -> list[str]:
    """Declare the kernels of a types, and return the names of their modules."""
    for declare in KERNELS:
        declare(types)
    return [types.module(METHOD), *solver.declare_kernels(types)]

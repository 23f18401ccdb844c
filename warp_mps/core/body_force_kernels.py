"""The kernel that evaluates a Warp function of place and time at particles."""

import functools
from collections import Counter
from typing import Any

import warp as wp

from warp_mps.core.types import NumericTypes

# how many kernels have been made of functions of one identity
_made: Counter[str] = Counter()


@functools.cache
def body_force_kernel(function: Any, identity: str, types: NumericTypes) -> Any:
    """The kernel of a function, in a Warp module of its own, which is compiled for it alone.

    Args:
        function: The Warp function: position and time to acceleration.
        identity: Name and hash of it, for the name of the module.
        types: Number types.
    """
    real, vec = types.real, types.vec
    module = types.module(f"body_force.{identity}")
    _made[module] += 1
    if _made[module] > 1:  # the same text with other global values
        module = f"{module}.{_made[module]}"

    @wp.kernel(module=module, enable_backward=False)
    def add_body_force(
        # State in:
        x: wp.array(dtype=vec),  # positions [m], [n]
        time: wp.array(dtype=wp.float64),  # time [s], [1]
        acts: wp.array(dtype=real),  # 1 for the particles that it acts on, else 0, [n]
        # State in and out:
        acceleration: wp.array(dtype=vec),  # forces per mass [m/s^2], [n]
    ):
        """Add the acceleration of a body force at the particles that it acts on [m/s^2]."""
        i = wp.tid()
        if acts[i] > real(0.0):
            acceleration[i] = acceleration[i] + function(x[i], real(time[0]))

    return add_body_force

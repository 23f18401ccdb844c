"""Bounds on the solution of the PPE: no negative pressures, or a least pressure of 0 in a closed domain."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid import METHOD


@functools.cache
def level_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `chunk_minima` and `set_level`."""

    @types.kernel(METHOD)
    def chunk_minima(
        # Model:
        chunk: wp.int32,
        # State in:
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
        # State out:
        least_out: wp.array(dtype=wp.float64),  # least pressures [Pa], [m / chunk]
    ):
        """Min p over each chunk of particles."""
        c = wp.tid()
        value = p[c * chunk]
        for k in range(c * chunk + 1, wp.min((c + 1) * chunk, p.shape[0])):
            value = wp.min(value, p[k])
        least_out[c] = value

    @types.kernel(METHOD)
    def set_level(
        # Model:
        clip: wp.int32,
        # State in:
        singular: wp.array(dtype=wp.int32),  # 1 if the PPE holds pressure differences alone, [1]
        least: wp.array(dtype=wp.float64),  # least pressures of chunks [Pa], [m / chunk]
        # State in and out:
        p: wp.array(dtype=wp.float64),  # pressures [Pa], [m]
    ):
        """Clip negative pressures, p = max(p, 0); in a closed domain p = p - min p, for only differences matter."""
        k = wp.tid()
        if singular[0] == 1:
            floor = least[0]
            for c in range(1, least.shape[0]):
                floor = wp.min(floor, least[c])
            p[k] = p[k] - floor
        elif clip == 1:
            p[k] = wp.max(p[k], wp.float64(0.0))

    return SimpleNamespace(chunk_minima=chunk_minima, set_level=set_level)

"""Kernels of dot products as sums of fixed chunks, whose bits do not depend on the schedule of the device."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.linear.kernels import METHOD
from warp_mps.core.types import NumericTypes

# Terms that one thread sums. A sum over n rows takes about log(n)/log(CHUNK) launches.
CHUNK = 128


@functools.cache
def sum_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `dot_products` and `sum_chunks`, always in double precision."""
    zero = wp.constant(wp.float64(0.0))
    numbers, pairs = wp.array(dtype=wp.float64), wp.array(dtype=wp.vec2d)

    @types.kernel(METHOD)
    def dot_products(
        # Model:
        across: wp.int32,  # distance of the first elements of two threads
        along: wp.int32,  # distance of the elements of a thread
        # State in:
        a: numbers,  # vector a, [n]
        b: numbers,  # vector b, [n]
        c: numbers,  # vector c, [n]
        # State out:
        sums_out: pairs,  # partial sums, [threads]
    ):
        """Partial sums of a.b and a.c: thread t adds up the elements `across` t + `along` k, k < CHUNK."""
        t = wp.tid()
        ab = zero
        ac = zero
        i = across * t
        for _k in range(CHUNK):
            if i < a.shape[0]:
                ab += a[i] * b[i]
                ac += a[i] * c[i]
            i += along
        sums_out[t] = wp.vec2d(ab, ac)

    @types.kernel(METHOD)
    def sum_chunks(
        # Model:
        across: wp.int32,  # distance of the first elements of two threads
        along: wp.int32,  # distance of the elements of a thread
        n: wp.int32,  # number of partial sums
        # State in:
        values: pairs,  # partial sums of the last level, [n]
        # State out:
        sums_out: pairs,  # partial sums, [threads]
    ):
        """Sums of the partial sums that a thread of the next level adds up."""
        t = wp.tid()
        total = wp.vec2d()
        i = across * t
        for _k in range(CHUNK):
            if i < n:
                total += values[i]
            i += along
        sums_out[t] = total

    return SimpleNamespace(dot_products=dot_products, sum_chunks=sum_chunks)

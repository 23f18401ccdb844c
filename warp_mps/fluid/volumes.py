"""The volumes that particles take up, whose sum an incompressible fluid keeps.

A particle inside has l0^d n0/n: more than a cell of the lattice where its neighbours have come apart, less where they
are squeezed. What a particle of the free surface takes up beyond its neighbours cannot be known from where they are: it
counts as a cell of the lattice, and so does a single drop. n falls a little faster than the volume grows (by 1.24 in
2-D), so that what the sum loses or gains is overstated.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.fluid.lists import METHOD, list_kernels
from warp_mps.fluid.pressure import CLOSEST, SURFACE_DENSITY, SURFACE_NEIGHBOURS, pressure_kernels


@functools.cache
def volume_kernels(kit: Kit) -> SimpleNamespace:
    """The kernel `take_up`."""
    real, vec = kit.real, kit.vec
    apart, weight = list_kernels(kit).apart, pressure_kernels(kit).weight

    @kit.kernel(METHOD)
    def take_up(
        # Model:
        walls: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        n0: real,
        full: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        # Out:
        share_out: wp.array(dtype=real),
    ):
        """Volume of a fluid particle over that of a cell of the lattice; 0 of one that has left the domain."""
        k = wp.tid()
        i = k + walls
        n = real(0.0)
        near = wp.int32(0)
        for m in range(count[i]):
            r = wp.length(apart(x[i], x[listed[i, m]], period))
            if r < radius:
                n += weight(wp.max(r, real(CLOSEST) * spacing), radius)
                near += 1
        share = real(1 - lost[i])
        if n >= real(SURFACE_DENSITY) * n0 or real(near) >= real(SURFACE_NEIGHBOURS) * full:
            share = n0 / n
        share_out[k] = share

    return SimpleNamespace(take_up=take_up)

"""Energies of the elastic particles, summed in fixed chunks so that no schedule of the device can change the sum."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD

CHUNK = 512


@functools.cache
def energy_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `particle_energies` and `chunk_sums`."""
    real, vec = types.real, types.vec

    @types.kernel(METHOD)
    def particle_energies(
        # Model:
        gravity: vec,  # acceleration of gravity [m/s^2]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State out:
        kinetic_out: wp.array(dtype=real),  # kinetic energies [J], [n]
        potential_out: wp.array(dtype=real),  # potential energies [J], [n]
    ):
        """Kinetic energy 1/2 m |v|^2 of the translation, and potential energy -m g . u from the reference position."""
        i = wp.tid()
        kinetic_out[i] = real(0.5) * mass[i] * wp.dot(v[i], v[i])
        potential_out[i] = -mass[i] * wp.dot(gravity, u[i])

    @types.kernel(METHOD)
    def chunk_sums(
        # State in:
        values: wp.array(dtype=real),  # values to sum, [n]
        # State out:
        sums_out: wp.array(dtype=wp.float64),  # sums, [chunks]
    ):
        """Sums of CHUNK consecutive values, in double precision."""
        c = wp.tid()
        total = wp.float64(0.0)
        for i in range(c * CHUNK, wp.min((c + 1) * CHUNK, values.shape[0])):
            total += wp.float64(values[i])
        sums_out[c] = total

    return SimpleNamespace(particle_energies=particle_energies, chunk_sums=chunk_sums)

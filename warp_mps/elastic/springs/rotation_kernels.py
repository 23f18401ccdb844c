"""Kernels of the particles' own rotation: the same velocity Verlet as for the translation."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.rotation import rotation_funcs
from warp_mps.core.types import NumericTypes

METHOD = "elastic"


@functools.cache
def rotation_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `drift`, `kick`, `damp` and `add_kinetic` of the rotation."""
    real, axial, rotor = types.real, types.axial, types.rotor
    advance = rotation_funcs(types, METHOD).advance

    @types.kernel(METHOD)
    def drift(
        # Model:
        first: wp.int32,
        dt: real,
        inverse_inertia: wp.array(dtype=real),
        torque: wp.array(dtype=axial),
        # State in and out:
        q: wp.array(dtype=rotor),
        omega: wp.array(dtype=axial),
    ):
        i = first + wp.tid()
        omega_i = omega[i] + (real(0.5) * dt * inverse_inertia[i]) * torque[i]
        omega[i] = omega_i
        q[i] = advance(q[i], omega_i, dt)

    @types.kernel(METHOD)
    def kick(
        # Model:
        first: wp.int32,
        dt: real,
        inverse_inertia: wp.array(dtype=real),
        torque: wp.array(dtype=axial),
        # State in and out:
        omega: wp.array(dtype=axial),
    ):
        i = first + wp.tid()
        omega[i] = omega[i] + (real(0.5) * dt * inverse_inertia[i]) * torque[i]

    @types.kernel(METHOD)
    def damp(
        # Model:
        factor: wp.float64,
        inertia: wp.array(dtype=real),
        inverse_inertia: wp.array(dtype=real),
        # State in and out:
        omega: wp.array(dtype=axial),
        dissipated: wp.array(dtype=wp.float64),
    ):
        """Mass-proportional damping over half a step, as for the velocity."""
        i = wp.tid()
        if inverse_inertia[i] > real(0.0):
            before = omega[i]
            after = real(factor) * before
            omega[i] = after
            loss = real(0.5) * inertia[i] * wp.dot(before - after, before + after)
            dissipated[i] = dissipated[i] + wp.float64(loss)

    @types.kernel(METHOD)
    def add_kinetic(
        # Model:
        inertia: wp.array(dtype=real),
        # State in:
        omega: wp.array(dtype=axial),
        # Out:
        kinetic_out: wp.array(dtype=real),
    ):
        """Add the kinetic energy of the rotation."""
        i = wp.tid()
        kinetic_out[i] = kinetic_out[i] + real(0.5) * inertia[i] * wp.dot(omega[i], omega[i])

    return SimpleNamespace(drift=drift, kick=kick, damp=damp, add_kinetic=add_kinetic)

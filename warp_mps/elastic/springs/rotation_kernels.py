"""Kernels of the particles' own rotation: velocity Verlet, as for the translation (eq. 4 of the paper).

    omega += dt/2 tau/I,   q <- advance(q, omega, dt),   torques tau,   omega += dt/2 tau/I

References:
    Robortella, M. S., Nishimoto, K. and Cheng, L.-Y., Dynamic analyses of elastic structures by using the moving
    particle semi-implicit method (MPS), equation 4.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.rotation import rotation_funcs
from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD


@functools.cache
def rotation_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `drift`, `kick`, `damp` and `add_kinetic` of the rotation."""
    real, axial, rotor = types.real, types.axial, types.rotor
    advance = rotation_funcs(types, METHOD).advance

    @types.kernel(METHOD)
    def drift(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        inverse_inertia: wp.array(dtype=real),  # inverse moments of inertia, 0 where rotation is held [1/(kg m^2)], [n]
        # State in:
        torque: wp.array(dtype=axial),  # torques [N m], [n]
        # State in and out:
        q: wp.array(dtype=rotor),  # rotors [-], [n]
        omega: wp.array(dtype=axial),  # angular velocities [rad/s], [n]
    ):
        """Half a kick omega += dt/2 tau/I with the torques of the last step, then the rotation by omega dt."""
        i = first + wp.tid()
        omega_i = omega[i] + (real(0.5) * dt * inverse_inertia[i]) * torque[i]
        omega[i] = omega_i
        q[i] = advance(q[i], omega_i, dt)

    @types.kernel(METHOD)
    def kick(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        inverse_inertia: wp.array(dtype=real),  # inverse moments of inertia, 0 where rotation is held [1/(kg m^2)], [n]
        # State in:
        torque: wp.array(dtype=axial),  # torques [N m], [n]
        # State in and out:
        omega: wp.array(dtype=axial),  # angular velocities [rad/s], [n]
    ):
        """The second half of the kick, omega += dt/2 tau/I."""
        i = first + wp.tid()
        omega[i] = omega[i] + (real(0.5) * dt * inverse_inertia[i]) * torque[i]

    @types.kernel(METHOD)
    def damp(
        # Model:
        factor: wp.float64,  # exp(-damping dt/2) [-]
        inertia: wp.array(dtype=real),  # moments of inertia [kg m^2], [n]
        inverse_inertia: wp.array(dtype=real),  # inverse moments of inertia, 0 where rotation is held [1/(kg m^2)], [n]
        # State in and out:
        omega: wp.array(dtype=axial),  # angular velocities [rad/s], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Mass-proportional damping over half a step: omega *= exp(-damping dt/2), with its energy loss."""
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
        inertia: wp.array(dtype=real),  # moments of inertia [kg m^2], [n]
        # State in:
        omega: wp.array(dtype=axial),  # angular velocities [rad/s], [n]
        # State in and out:
        kinetic: wp.array(dtype=real),  # kinetic energies [J], [n]
    ):
        """Kinetic energy of the rotation, added: T_i += 1/2 I_i |omega_i|^2."""
        i = wp.tid()
        kinetic[i] = kinetic[i] + real(0.5) * inertia[i] * wp.dot(omega[i], omega[i])

    return SimpleNamespace(drift=drift, kick=kick, damp=damp, add_kinetic=add_kinetic)

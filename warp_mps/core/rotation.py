"""Rotation of particles in 2-D and 3-D.

A particle carries a rotor. In 3-D it is the unit quaternion (w, x, y, z). In 2-D it is (cos(theta/4), sin(theta/4)),
the square root of the quaternion about the normal, because the product of two particles' rotors is then the quaternion
(cos(theta_ij/2), sin(theta_ij/2)) of their mean rotation theta_ij = (theta_i + theta_j)/2, with no trigonometry in the
pair loop. Rotations act as R X - X, formed from half angles so that small ones keep their digits in single precision.
"""

import functools
from types import SimpleNamespace

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes


@functools.cache
def rotation_funcs(types: NumericTypes, method: str) -> SimpleNamespace:
    """Device functions `cross`, `mean_rotor`, `turn`, `torque_share` and `advance` of one dimension and precision."""
    return _plane_funcs(types, method) if types.dimension == 2 else _space_funcs(types, method)


def _plane_funcs(types: NumericTypes, method: str) -> SimpleNamespace:
    real, vec, axial, rotor = types.real, types.vec, types.axial, types.rotor

    @types.func(method)
    def cross(a: vec, b: vec) -> axial:
        return axial(a[0] * b[1] - a[1] * b[0])

    @types.func(method)
    def mean_rotor(q_i: rotor, q_j: rotor) -> rotor:
        return rotor(q_i[0] * q_j[0] - q_i[1] * q_j[1], q_i[0] * q_j[1] + q_i[1] * q_j[0])

    @types.func(method)
    def turn(m: rotor, x: vec) -> vec:
        """R X - X for a mean rotor m = (cos(theta/2), sin(theta/2))."""
        s = real(2.0) * m[1]
        return vec(-s * (m[1] * x[0] + m[0] * x[1]), s * (m[0] * x[0] - m[1] * x[1]))

    @types.func(method)
    def torque_share(q_i: rotor, m: rotor, torque: axial) -> axial:
        return real(0.5) * torque

    @types.func(method)
    def advance(q: rotor, omega: axial, dt: real) -> rotor:
        """Rotor after a turn of omega dt, by the Cayley map.

        Normalized, because in single precision the length would grow by the same rounding at every step.
        """
        a = real(0.25) * dt * omega[0]
        return wp.normalize(rotor(q[0] - a * q[1], q[1] + a * q[0]))

    return SimpleNamespace(cross=cross, mean_rotor=mean_rotor, turn=turn, torque_share=torque_share, advance=advance)


def _space_funcs(types: NumericTypes, method: str) -> SimpleNamespace:
    real, vec, axial, rotor = types.real, types.vec, types.axial, types.rotor

    @types.func(method)
    def cross(a: vec, b: vec) -> axial:
        return wp.cross(a, b)

    @types.func(method)
    def mean_rotor(q_i: rotor, q_j: rotor) -> rotor:
        """Unit quaternion of the mean rotation times any factor.

        q and -q are the same rotation, but rotors start out equal and neighbours never part by half a turn, so the
        sum does not cancel.
        """
        return q_i + q_j

    @types.func(method)
    def turn(m: rotor, x: vec) -> vec:
        """R X - X for a quaternion m of any length."""
        v = vec(m[1], m[2], m[3])
        t = (real(2.0) / wp.dot(m, m)) * wp.cross(v, x)
        return m[0] * t + wp.cross(v, t)

    @types.func(method)
    def torque_share(q_i: rotor, m: rotor, torque: axial) -> axial:
        """Torque on particle i when `torque` acts on the mean rotation m of i and j.

        The mean rotation turns by (omega_i c + omega_i x v + ...)/(2 c), with (c, v) = q_i m^-1 of any length, when q_i
        turns by omega_i: the share is the adjoint of that, so that energy is kept, and the two shares add up to the
        torque.
        """
        p = vec(q_i[1], q_i[2], q_i[3])
        b = vec(m[1], m[2], m[3])
        c = q_i[0] * m[0] + wp.dot(p, b)
        v = m[0] * p - q_i[0] * b - wp.cross(p, b)
        return real(0.5) * (torque + wp.cross(v, torque) / c)

    @types.func(method)
    def advance(q: rotor, omega: axial, dt: real) -> rotor:
        """Quaternion after a turn of omega dt (world axes), by the Cayley map."""
        a = real(0.5) * dt * omega
        p = vec(q[1], q[2], q[3])
        w = q[0] - wp.dot(a, p)
        v = p + q[0] * a + wp.cross(a, p)
        return wp.normalize(rotor(w, v[0], v[1], v[2]))

    return SimpleNamespace(cross=cross, mean_rotor=mean_rotor, turn=turn, torque_share=torque_share, advance=advance)


def identity_rotors(count: int, dimension: int) -> np.ndarray:
    """Rotors of unrotated particles, shape [n, 2] in 2-D and [n, 4] in 3-D."""
    rotors = np.zeros((count, 2 * dimension - 2))
    rotors[:, 0] = 1.0
    return rotors


def rotation_vectors(rotors: np.ndarray) -> np.ndarray:
    """Rotation vectors [rad] of rotors: shape [n, 1] (the angle theta) in 2-D, [n, 3] in 3-D."""
    if rotors.shape[1] == 2:
        return 4.0 * np.arctan2(rotors[:, 1:], rotors[:, :1])
    rotors = np.where(rotors[:, :1] < 0.0, -rotors, rotors)
    sine = np.linalg.norm(rotors[:, 1:], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, rotors[:, :1])
    return rotors[:, 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)

"""Named initial velocity fields: shapes of vibration along an axis, and flows of a liquid without divergence.

References:
    Rao, S. S., Mechanical Vibrations, 5th ed., sections 8.4 (torsion of rods) and 8.5 (transverse vibration of beams).
    Lamb, H., Hydrodynamics, 6th ed., section 228 (standing waves in water of any depth).
    Taylor, G. I. and Green, A. E., Proc. R. Soc. London A 158 (1937) 499.
"""

from __future__ import annotations

import math

import numpy as np

from warp_mps.scene import VelocityField


def velocity(field: VelocityField, positions: np.ndarray) -> np.ndarray:
    """Velocity of each particle in a named field.

    Args:
        field: The field.
        positions: Reference positions [m], shape [n, d].

    Returns:
        Velocities [m/s], shape [n, d].
    """
    axis = np.asarray(field.axis, float) / np.linalg.norm(field.axis)
    arms = positions - np.asarray(field.origin, float)
    if field.kind in _FLOWS:
        return _FLOWS[field.kind](field, arms, axis)
    assert field.length is not None
    values = _SHAPES[field.kind](arms @ axis / field.length, field.mode)
    if field.kind == "twist":
        return (field.rate or 0.0) * values[:, None] * np.cross(axis, arms)
    return np.outer(values, np.asarray(field.amplitude, float))


def beam_root(ends: str, mode: int) -> float:
    """The root b = beta L of a uniform beam's frequency equation.

    cos(b) cosh(b) = 1 for ``free_free_beam``, -1 for ``clamped_free_beam`` (Rao, table 8.4).
    """
    sign = 1.0 if ends == "free_free_beam" else -1.0
    root = (mode + 0.5 * sign) * math.pi
    for _ in range(50):  # Newton on cos(b) - sign / cosh(b), which stays of order one where cosh(b) does not
        inverse = 2.0 * math.exp(-root) / (1.0 + math.exp(-2.0 * root))
        root -= (math.cos(root) - sign * inverse) / (sign * inverse * math.tanh(root) - math.sin(root))
    return root


def _sine(along: np.ndarray, mode: int) -> np.ndarray:
    return np.sin(mode * math.pi * along)


def _twist(along: np.ndarray, mode: int) -> np.ndarray:
    return np.sin((mode - 0.5) * math.pi * along)


def _free_free(along: np.ndarray, mode: int) -> np.ndarray:
    return _beam(along, beam_root("free_free_beam", mode), 1.0)


def _clamped_free(along: np.ndarray, mode: int) -> np.ndarray:
    return _beam(along, beam_root("clamped_free_beam", mode), -1.0)


def _beam(along: np.ndarray, root: float, sign: float) -> np.ndarray:
    """Bending shape of a beam, 1 at its end: cosh s - r sinh s + sign (cos s - r sin s), s = b along.

    r = (cosh b - sign cos b)/(sinh b - sign sin b).

    cosh s - r sinh s = ((1 - r) exp(s) + (1 + r) exp(-s))/2, in which 1 - r is a small difference times a large
    exponential: both are formed together.
    """
    sine, cosine, decay = math.sin(root), math.cos(root), math.exp(-root)
    half_sinh = 0.5 * (1.0 - decay**2) - sign * sine * decay  # (sinh b - sign sin b) exp(-b)
    small = sign * (cosine - sine) - decay  # (1 - r)(sinh b - sign sin b)
    ratio = (0.5 * (1.0 + decay**2) - sign * cosine * decay) / half_sinh

    def shape(s: np.ndarray) -> np.ndarray:
        growing = small * np.exp(s - root) / half_sinh
        return 0.5 * (growing + (1.0 + ratio) * np.exp(-s)) + sign * (np.cos(s) - ratio * np.sin(s))

    return shape(root * along) / shape(np.asarray(root))


def _stagnation(field: VelocityField, arms: np.ndarray, axis: np.ndarray) -> np.ndarray:
    along = np.outer(arms @ axis, axis)
    return (field.rate or 0.0) * (along - (arms - along) / (len(axis) - 1))


def _taylor_green(field: VelocityField, arms: np.ndarray, axis: np.ndarray) -> np.ndarray:
    amplitude, along, across, _ = _phases(field, arms, axis)
    crests = np.outer(np.sin(along) * np.cos(across), amplitude)
    return crests - np.outer(np.cos(along) * np.sin(across), axis) * np.linalg.norm(amplitude)


def _standing_wave(field: VelocityField, arms: np.ndarray, axis: np.ndarray) -> np.ndarray:
    amplitude, along, up, k = _phases(field, arms, axis)
    assert field.depth is not None
    level = k * field.depth
    # sinh(k q)/sinh(k H) and cosh(k q)/sinh(k H) in exponentials that cannot overflow
    growing, falling, whole = np.exp(up - level), np.exp(-up - level), 1.0 - math.exp(-2.0 * level)
    crests = np.outer(np.cos(along) * (growing - falling) / whole, amplitude)
    return crests - np.outer(np.sin(along) * (growing + falling) / whole, axis) * np.linalg.norm(amplitude)


def _phases(
    field: VelocityField, arms: np.ndarray, axis: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The amplitude, k s along the axis, k q along the amplitude, and k = 2 pi / length."""
    amplitude = np.asarray(field.amplitude, float)
    assert field.length is not None
    k = 2.0 * math.pi / field.length
    return amplitude, k * (arms @ axis), k * (arms @ amplitude) / np.linalg.norm(amplitude), k


_SHAPES = {"sine": _sine, "free_free_beam": _free_free, "clamped_free_beam": _clamped_free, "twist": _twist}
_FLOWS = {"stagnation": _stagnation, "taylor_green": _taylor_green, "standing_wave": _standing_wave}

"""Rotors as NumPy and SciPy see them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def rotors_of(vectors: np.ndarray) -> np.ndarray:
    """Rotors of rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
    if vectors.shape[1] == 1:
        return np.hstack((np.cos(vectors / 4), np.sin(vectors / 4)))
    return np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=1)


def matrices_of(rotors: np.ndarray) -> np.ndarray:
    """Rotation matrices of rotors, shape [n, d, d]."""
    if rotors.shape[1] == 4:
        return Rotation.from_quat(np.roll(rotors, -1, axis=1)).as_matrix()
    angles = 4 * np.arctan2(rotors[:, 1], rotors[:, 0])
    c, s = np.cos(angles), np.sin(angles)
    return np.array([[c, -s], [s, c]]).transpose(2, 0, 1)


def turned(rotors: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Rotors after a further turn by rotation vectors (space axes)."""
    turn, old = rotors_of(vectors), rotors
    if rotors.shape[1] == 2:
        return np.column_stack(
            (turn[:, 0] * old[:, 0] - turn[:, 1] * old[:, 1], turn[:, 1] * old[:, 0] + turn[:, 0] * old[:, 1])
        )
    w, p = turn[:, :1], turn[:, 1:]
    s, q = old[:, :1], old[:, 1:]
    return np.hstack((w * s - np.sum(p * q, axis=1, keepdims=True), w * q + s * p + np.cross(p, q)))

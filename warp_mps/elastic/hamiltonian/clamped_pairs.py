"""Pairs of the Hamiltonian model that meet the face of a clamp, by `warp_mps.elastic.boundary.clamp_faces`."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.elastic.boundary.clamp_faces import ClampFaces
from warp_mps.elastic.hamiltonian.kernels import FLAT


def end_pairs_at_faces(
    faces: ClampFaces, start: np.ndarray, index: np.ndarray, bond: wp.array, weight: wp.array, inverse_shape: wp.array
) -> None:
    """Let pairs end at the faces of clamps: X_ij becomes t_ij X_ij and omega_ij becomes omega_ij / t_ij^2.

    The shape tensors of free particles stay; those of held ones near the face become one-sided.

    Args:
        faces: The faces.
        start: First pair of each particle, shape [n + 1].
        index: Neighbour of each pair.
        bond: Reference vectors X_ij [m], changed in place.
        weight: Weights omega_ij [1/m^2], changed in place.
        inverse_shape: Inverse shape tensors A_i^-1 [-], changed in place.
    """
    bonds, weights, inverses = (array.numpy() for array in (bond, weight, inverse_shape))
    bonds[faces.pairs] *= faces.fraction[:, None]
    weights[faces.pairs] *= faces.weight / faces.fraction**2
    for i in np.unique(np.searchsorted(start, faces.pairs, side="right") - 1):
        pairs = slice(start[i], start[i + 1])
        x, omega = bonds[pairs].astype(float), weights[pairs].astype(float)
        shape = (omega[:, None] * x).T @ x
        n = float(np.sum(omega * np.sum(x * x, axis=1)))
        flat = n <= 0.0 or np.linalg.det(len(shape) / n * shape) <= FLAT
        inverses[i] = 0.0 if flat else np.linalg.inv(shape)
    for array, values in ((bond, bonds), (weight, weights), (inverse_shape, inverses)):
        array.assign(values)

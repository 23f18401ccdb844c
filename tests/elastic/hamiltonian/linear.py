"""The Hamiltonian model linearised about rest, assembled from its energy with NumPy and SciPy alone.

For small displacements psi is that of linear elasticity whatever the law, and W is a quadratic form of the particles' d
displacements:

    W = sum_i V_i (mu eps_i : eps_i + lambda/2 tr(eps_i)^2) + sum_ij 1/2 kappa_i omega_ij |u_ij - H_i X_ij|^2
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tests.elastic.springs.linear import LinearSystem, lame_of, pairs_of
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


def linear_hamiltonian(scene: Scene, particles: Particles, held: np.ndarray | None = None) -> LinearSystem:
    """Assemble the system of a scene.

    Args:
        scene: The scene; its supports are not looked at.
        particles: Its particles.
        held: Which displacements are held, shape [n, d]; None holds none.
    """
    d = particles.dimension
    lame, mu = np.array([lame_of(material, scene) for material in scene.materials])[particles.materials].T
    volume = particles.spacings**d
    i, j, bond, w = pairs_of(scene, particles)
    omega = w / np.sum(bond**2, axis=1)
    differences = _differences(i, j, particles.count, d)
    gradient = _gradients(differences, i, bond, omega, particles.count)
    trace = sum(gradient[a][a] for a in range(d))
    stiffness = trace.T @ sp.diags(volume * lame) @ trace
    for a in range(d):
        for b in range(d):
            strain = 0.5 * (gradient[a][b] + gradient[b][a])
            stiffness = stiffness + strain.T @ sp.diags(2 * mu * volume) @ strain
    kappa = scene.elasticity.control * volume * 2 * mu * d / np.bincount(i, w, particles.count)
    for a in range(d):
        rest = differences[a] - sum(sp.diags(bond[:, b]) @ gradient[a][b][i] for b in range(d))
        stiffness = stiffness + rest.T @ sp.diags(kappa[i] * omega) @ rest
    masses = np.repeat(particles.masses, d)
    free = np.arange(len(masses)) if held is None else np.flatnonzero(~held.ravel())
    return LinearSystem(stiffness.tocsr(), masses, free)


def _differences(i: np.ndarray, j: np.ndarray, n: int, d: int) -> list[sp.csr_matrix]:
    """For each axis the matrix that gives that component of u_ij of every pair."""
    pairs, ones = np.arange(len(i)), np.ones(len(i))
    rows, values = np.concatenate((pairs, pairs)), np.concatenate((ones, -ones))
    return [sp.csr_matrix((values, (rows, np.concatenate((j, i)) * d + a)), (len(i), n * d)) for a in range(d)]


def _gradients(
    differences: list[sp.csr_matrix], i: np.ndarray, bond: np.ndarray, omega: np.ndarray, n: int
) -> list[list[sp.csr_matrix]]:
    """Matrices [a][b] that give du_a/dX_b of every particle."""
    d, pairs = bond.shape[1], np.arange(len(i))
    shape = np.zeros((n, d, d))
    np.add.at(shape, i, omega[:, None, None] * bond[:, :, None] * bond[:, None, :])
    slopes = np.einsum("kab,kb->ka", np.linalg.inv(shape)[i], bond) * omega[:, None]
    sums = [sp.csr_matrix((slopes[:, b], (i, pairs)), (n, len(i))) for b in range(d)]
    return [[sums[b] @ differences[a] for b in range(d)] for a in range(d)]

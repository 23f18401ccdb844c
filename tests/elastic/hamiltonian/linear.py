"""The Hamiltonian model linearised about rest, assembled from its energy with NumPy and SciPy alone.

For small displacements psi is that of linear elasticity whatever the law, and W is a quadratic form of the particles' d
displacements:

    W = sum_i V_i (mu eps_i : eps_i + lambda/2 tr(eps_i)^2) + sum_ij 1/2 kappa_i omega_ij |u_ij - H_i X_ij|^2

Beyond 4 mu, lambda acts on the mean of tr(eps) over the neighbours of the same material, unless it is plane stress,
with the weights w scaled to a symmetric matrix whose rows add up to 1; and the control is weaker.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tests.elastic.springs.linear import LinearSystem, lame_of, pairs_of
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


def linear_hamiltonian(
    scene: Scene, particles: Particles, held: np.ndarray | None = None, *, face: float | None = None
) -> LinearSystem:
    """Assemble the system of a scene.

    Args:
        scene: The scene; its supports are not looked at.
        particles: Its particles.
        held: Which displacements are held, shape [n, d]; None holds none.
        face: Place x of the plane face of a clamp that holds what is held [m]; for pairs of neighbouring columns only.
    """
    d = particles.dimension
    lame, mu = np.array([lame_of(material, scene) for material in scene.materials])[particles.materials].T
    volume = particles.spacings**d
    i, j, bond, w = pairs_of(scene, particles)
    omega = w / np.sum(bond**2, axis=1)
    share = np.ones(particles.count)
    if face is not None and held is not None:
        share, ends, factor = ended_pairs(particles, held[:, 0], i, j, face)
        bond, omega = bond * ends[:, None], omega * factor / ends**2
    differences = _differences(i, j, particles.count, d)
    gradient = _gradients(differences, i, bond, omega, particles.count)
    volume = volume * share
    trace = sum(gradient[a][a] for a in range(d))
    beyond = np.where(scene.dimension == 2 and scene.plane == "stress", 0.0, np.maximum(lame - 4.0 * mu, 0.0))
    same = (lame[i] == lame[j]) & (mu[i] == mu[j])
    mean = sp.csr_matrix((w * same, (i, j)), (particles.count, particles.count))
    averaged = balanced(mean) @ trace
    stiffness = trace.T @ sp.diags(volume * (lame - beyond)) @ trace
    stiffness = stiffness + averaged.T @ sp.diags(volume * beyond) @ averaged
    for a in range(d):
        for b in range(d):
            strain = 0.5 * (gradient[a][b] + gradient[b][a])
            stiffness = stiffness + strain.T @ sp.diags(2 * mu * volume) @ strain
    control = scene.elasticity.control * (1.0 - 0.22 * (beyond / np.where(beyond > 0.0, lame, 1.0)) ** 2)
    kappa = control * particles.spacings**d * 2 * mu * d / np.bincount(i, w, particles.count)
    kappa = kappa * np.where(share < 1.0, 2.0 * share, 1.0)
    for a in range(d):
        rest = differences[a] - sum(sp.diags(bond[:, b]) @ gradient[a][b][i] for b in range(d))
        stiffness = stiffness + rest.T @ sp.diags(kappa[i] * omega) @ rest
    masses = np.repeat(particles.masses, d)
    free = np.arange(len(masses)) if held is None else np.flatnonzero(~held.ravel())
    return LinearSystem(stiffness.tocsr(), masses, free)


def ended_pairs(
    particles: Particles, held: np.ndarray, i: np.ndarray, j: np.ndarray, face: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs that end at a face x: shares of the particles' volumes, of the bonds' lengths, and factors of weights.

    The column of held particles next to the face has the part of its volume that lies in front of the face, and no
    neighbours behind itself; those beside it count half.
    """
    depth = (face - particles.positions[:, 0]) / particles.spacings
    ends = np.ones(len(i))
    across = held[i] != held[j]
    free, fixed = np.where(held[i], j, i), np.where(held[i], i, j)
    ends[across] = depth[free[across]] / (depth[free[across]] - depth[fixed[across]])
    first = held & (depth < 0.65)
    share = np.where(first, np.maximum(0.5 - depth, 1e-9), 1.0)
    factor = np.where(held[i] & held[j] & (first[i] | first[j]), 0.5 * (first[i] & first[j]), 1.0)
    return share, ends, factor


def balanced(weights: sp.csr_matrix) -> sp.csr_matrix:
    """The symmetric matrix r_i w_ij r_j whose rows add up to 1, by the iterations of Sinkhorn and Knopp.

    What the rows lack of 1 after the iterations, also where there are no neighbours, is on the diagonal.
    """
    r = np.ones(weights.shape[0])
    for _ in range(20):
        sums = r * (weights @ r)
        r = r / np.sqrt(np.where(sums > 0.0, sums, 1.0))
    sums = r * (weights @ r)
    near = np.maximum(sums, np.asarray((weights != 0).multiply(sums[None]).max(axis=1).todense()).ravel())
    r = r / np.sqrt(np.maximum(near, 1.0))
    scaled = sp.diags(r) @ weights @ sp.diags(r)
    return scaled + sp.diags(1.0 - np.asarray(scaled.sum(axis=1)).ravel())


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
    # held particles behind a face may have too few neighbours for a gradient
    good = np.linalg.det(shape) > 1e-6
    inverse = np.zeros_like(shape)
    inverse[good] = np.linalg.inv(shape[good])
    slopes = np.einsum("kab,kb->ka", inverse[i], bond) * omega[:, None]
    sums = [sp.csr_matrix((slopes[:, b], (i, pairs)), (n, len(i))) for b in range(d)]
    return [[sums[b] @ differences[a] for b in range(d)] for a in range(d)]

"""The spring model linearised about rest, assembled with NumPy and SciPy alone: what the kernels are held against.

A particle has d displacements and then 1 rotation in 2-D, 3 in 3-D. For small ones eq. 9 is u_ij = u_j - u_i -
theta_ij x X_ij, and the energy of `warp_mps.elastic.springs.kernels` is a quadratic form of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from scipy.spatial import cKDTree

from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


@dataclass(frozen=True)
class LinearSystem:
    """K a = omega^2 M a.

    Attributes:
        stiffness: K, shape [m, m], m the number of particles times that of the freedoms of each.
        masses: Diagonal of M: masses, and moments of inertia [kg, kg m^2], shape [m].
        free: Numbers of the freedoms that are not held.
    """

    stiffness: sp.csr_matrix
    masses: np.ndarray
    free: np.ndarray

    def modes(self, count: int, *, rigid: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """The lowest eigenfrequencies [rad/s], shape [count], and their shapes, shape [count, m], with a M a = 1.

        Args:
            count: Number of modes.
            rigid: Number of rigid motions, which are left out.
        """
        scaled = self._scaled()
        # a shift far below the lowest bending mode, where K itself may be singular
        shift = -1e-9 * sla.eigsh(scaled, k=1, which="LM", return_eigenvectors=False, v0=self._start())[0]
        values, vectors = sla.eigsh(scaled.tocsc(), k=count + rigid, sigma=shift, which="LM", v0=self._start())
        order = np.argsort(values)[rigid:]
        shapes = np.zeros((count, len(self.masses)))
        shapes[:, self.free] = vectors[:, order].T / np.sqrt(self.masses[self.free])
        return np.sqrt(values[order]), shapes

    def highest_frequency(self) -> float:
        """The highest eigenfrequency [rad/s]."""
        highest = sla.eigsh(self._scaled(), k=1, which="LA", return_eigenvectors=False, tol=1e-6, v0=self._start())
        return float(np.sqrt(highest[0]))

    def _scaled(self) -> sp.csr_matrix:
        root = sp.diags(1.0 / np.sqrt(self.masses[self.free]))
        return root @ self.stiffness[self.free][:, self.free] @ root

    def _start(self) -> np.ndarray:
        return np.random.default_rng(0).normal(size=len(self.free))


def linear_system(
    scene: Scene, particles: Particles, held: np.ndarray | None = None, *, face: float | None = None
) -> LinearSystem:
    """Assemble the system of a scene.

    Args:
        scene: The scene; its supports are not looked at.
        particles: Its particles.
        held: Which freedoms are held, shape [n, d + 1] in 2-D and [n, 6] in 3-D; None holds none.
        face: Place x of the plane face of a clamp [m]: bonds to held particles are cut there.
    """
    d, n = particles.dimension, particles.count
    lame = np.array([lame_of(material, scene) for material in scene.materials])[particles.materials]
    volume = particles.spacings**d
    i, j, bond, w = pairs_of(scene, particles)
    length = np.linalg.norm(bond, axis=1)
    density = _number_density(scene, particles, i, w)
    cut, doubled = np.ones(len(i)), np.ones(n)
    if face is not None and held is not None:
        ahead, fixed = particles.positions[:, 0] - face, held[:, 0]
        across = fixed[i] != fixed[j]
        near = np.where(fixed[i], ahead[j], ahead[i])
        cut[across] = near[across] / np.abs(bond[across, 0])
        beside = np.unique(np.where(fixed[i], i, j)[across])
        doubled[beside] = 4.0 * np.maximum(0.5 + ahead[beside] / particles.spacings[beside], 0.0)
        bond = bond * cut[:, None]
    operators = _relative_displacements(bond, i, j, n)
    mu = 2.0 * lame[i, 1] * lame[j, 1] / (lame[i, 1] + lame[j, 1])
    springs = volume[i] * (2 * d) * (2 * mu) * w / length**2 / cut * 0.5 * (1 / density[i] + 1 / density[j])
    stretch = sum(sp.diags(bond[:, axis] / (length * cut)) @ operator for axis, operator in enumerate(operators))
    divergence = (
        sp.diags(d / density) @ sp.csr_matrix((w / length / cut, (i, np.arange(len(i)))), (n, len(i))) @ stretch
    )
    # every pair stands in the list twice
    stiffness = 0.5 * sum(operator.T @ sp.diags(springs) @ operator for operator in operators)
    stiffness = stiffness + divergence.T @ sp.diags(volume * lame[:, 0] * doubled) @ divergence
    spins = 2 * d - 3
    inertia = particles.masses * particles.spacings**2 / 6
    masses = np.column_stack([particles.masses] * d + [inertia] * spins).ravel()
    free = np.arange(len(masses)) if held is None else np.flatnonzero(~held.ravel())
    return LinearSystem(stiffness.tocsr(), masses, free)


def lame_of(material, scene: Scene) -> tuple[float, float]:
    """Lame's constants lambda and mu [Pa]."""
    youngs, nu = material.youngs_modulus, material.poissons_ratio
    if scene.dimension == 2 and scene.plane == "stress":
        return youngs * nu / (1 - nu**2), youngs / (2 * (1 + nu))
    return youngs * nu / ((1 + nu) * (1 - 2 * nu)), youngs / (2 * (1 + nu))


def pairs_of(scene: Scene, particles: Particles) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Both directions of every pair of neighbours: i, j, X_ij and the weight."""
    radius = scene.elasticity.effective_radius * particles.spacings
    found = cKDTree(particles.positions).query_pairs(radius.max() * (1 + 1e-9), output_type="ndarray")
    found = found[particles.groups[found[:, 0]] == particles.groups[found[:, 1]]]
    i, j = np.concatenate((found, found[:, ::-1])).T
    bond = particles.positions[j] - particles.positions[i]
    return i, j, bond, np.maximum(radius[i] / np.linalg.norm(bond, axis=1) - 1.0, 0.0)


def _number_density(scene: Scene, particles: Particles, i: np.ndarray, w: np.ndarray) -> np.ndarray:
    if scene.elasticity.normalization == "particle":
        return np.bincount(i, w, particles.count)
    reach = scene.elasticity.effective_radius
    steps = np.arange(-int(reach), int(reach) + 1)
    radii = np.sqrt(sum(grid.astype(float) ** 2 for grid in np.meshgrid(*[steps] * particles.dimension))).ravel()
    radii = radii[(radii > 0) & (radii < reach)]
    return np.full(particles.count, np.sum(reach / radii - 1))


def _relative_displacements(bond: np.ndarray, i: np.ndarray, j: np.ndarray, n: int) -> list[sp.csr_matrix]:
    """For each axis the matrix that gives that component of u_ij of every pair."""
    d = bond.shape[1]
    spins, pairs = 2 * d - 3, np.arange(len(i))
    operators = []
    for axis in range(d):
        # component `axis` of -e x X_ij, for each axis e of rotation
        arms = [bond[:, 1 - axis] * (1.0, -1.0)[axis]] if d == 2 else [-np.cross(e, bond)[:, axis] for e in np.eye(3)]
        columns = [j * (d + spins) + axis, i * (d + spins) + axis]
        values = [np.ones(len(i)), -np.ones(len(i))]
        for k, arm in enumerate(arms):
            columns += [i * (d + spins) + d + k, j * (d + spins) + d + k]
            values += [0.5 * arm, 0.5 * arm]
        entries = (np.concatenate(values), (np.tile(pairs, len(columns)), np.concatenate(columns)))
        operators.append(sp.csr_matrix(entries, (len(i), n * (d + spins))))
    return operators

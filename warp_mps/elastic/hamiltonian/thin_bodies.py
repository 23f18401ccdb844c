"""Remarks on bodies of two particles across, which bend too little whatever the model does.

Bending strains the two sides of a plate oppositely across itself, and two particles across have one gradient for both.
The mean dilatation (`warp_mps.elastic.hamiltonian.dilatation_kernels`) therefore cures three particles and more only.
"""

from __future__ import annotations

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.scene import Body, Material, Scene
from warp_mps.scene.validation.scene import place

# deflection of a clamped plate of two particles across under a load at its end, over that of plate theory, in plane
# strain: static solutions of the linearised model with its default control
RATIOS = (0.0, 0.1, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.47, 0.48, 0.49, 0.495, 0.499, 0.5)
BENDING = (0.83, 0.85, 0.86, 0.84, 0.80, 0.74, 0.61, 0.66, 0.66, 0.64, 0.56, 0.45, 0.17, 0.0)
# share of the particles that must lie in rows of two for the body to count as thin
MOSTLY = 0.5


def two_particle_bending(material: Material, scene: Scene) -> float:
    """Deflection of a body of two particles across, over what it should be [-]; about, for it varies with the shape."""
    nu = material.poissons_ratio
    if scene.dimension == 2 and scene.plane == "stress":
        # the nu of plane strain that has the same ratio of lambda to mu
        nu = nu / (1.0 + nu)
    return float(np.interp(nu, RATIOS, BENDING))


def remarks_on_thin_bodies(scene: Scene, particles: Particles) -> list[str]:
    """A line for each elastic body that is two particles thick: how much it bends of what it should, and the remedy."""
    if scene.elasticity.model != "hamiltonian":
        return []
    rows = particles_across(particles)
    lines = []
    for number, body in enumerate(scene.bodies):
        first, last = particles.ranges[number]
        if np.mean(rows[first:last] == 2) >= MOSTLY:
            lines.append(_line(body, scene))
    return lines


def particles_across(particles: Particles) -> np.ndarray:
    """Length of the shortest row of adjacent elastic particles along any axis through each one, shape [n]."""
    shortest = np.full(particles.elastic, np.iinfo(np.int64).max)
    groups = particles.groups[: particles.elastic]
    for group in np.unique(groups):
        here = np.flatnonzero(groups == group)
        x = particles.positions[here]
        cells = np.rint((x - x.min(axis=0)) / particles.spacings[here, None]).astype(np.int64)
        for axis in range(particles.dimension):
            shortest[here] = np.minimum(shortest[here], _row_lengths(cells, axis))
    return shortest


def _row_lengths(cells: np.ndarray, axis: int) -> np.ndarray:
    """Length of the row of adjacent cells along an axis that each cell lies in, shape [n]."""
    others = np.delete(cells, axis, axis=1)
    order = np.lexsort((cells[:, axis], *others.T))
    ends = (np.diff(others[order], axis=0) != 0).any(axis=1) | (np.diff(cells[order, axis]) > 1)
    row = np.concatenate(([0], np.cumsum(ends)))
    lengths = np.empty(len(cells), np.int64)
    lengths[order] = np.bincount(row)[row]
    return lengths


def _line(body: Body, scene: Scene) -> str:
    material = body.material
    return (
        f"{place(body, 'body')}: is 2 particles thick; with a Poisson's ratio of {material.poissons_ratio:g} it "
        f"deflects in bending by about {two_particle_bending(material, scene):.2f} of what it should; take 3 particles "
        f"or more, as with a spacing of {2.0 * body.spacing / 3.0:.3g} m"
    )

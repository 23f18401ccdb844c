"""Remarks on a case: what a user should know before its numbers are believed, the same from a check and from a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warp_mps.elastic.hamiltonian.thin_bodies import remarks_on_thin_bodies
from warp_mps.particles.misfits import remarks_on_misfits
from warp_mps.particles.open_corners import remarks_on_open_corners
from warp_mps.particles.particles import Particles
from warp_mps.particles.unheld_fluid import remarks_on_unheld_fluid
from warp_mps.run.inventory.doubts import remarks_on_flotation, remarks_on_missing_contact, remarks_on_rows
from warp_mps.run.inventory.drift import remarks_on_drift
from warp_mps.run.inventory.flotation import Flotation, flotations
from warp_mps.run.penetrations import remarks_on_penetrations
from warp_mps.run.spilled import remarks_on_spilled_fluid
from warp_mps.scene import Scene
from warp_mps.scene.validation.fluids import remarks as remarks_on_fluids
from warp_mps.scene.validation.meshes import remarks_on_meshes


def remarks_on_end(scene: Scene, particles: Particles, positions: np.ndarray, velocities: np.ndarray) -> list[str]:
    """Remarks on the end of a run, a line each.

    Args:
        scene: The scene.
        particles: Its particles.
        positions: Their positions [m], shape [n, d].
        velocities: Their velocities [m/s], shape [n, d].
    """
    return [
        *remarks_on_spilled_fluid(scene, particles, positions, velocities),
        *remarks_on_penetrations(scene, particles, positions),
    ]


def remarks_on_case(scene: Scene, particles: Particles, floating: Mapping[str, Flotation] | None = None) -> list[str]:
    """Remarks on a scene and on the particles that fill it, a line each: what it is about, the number, the remedy.

    Args:
        scene: The scene.
        particles: Its particles.
        floating: How its free bodies float, by name, where that is known already.
    """
    if floating is None:
        floating = flotations(scene, particles)
    return [
        *scene.remarks,
        *remarks_on_meshes(scene),
        *remarks_on_fluids(scene),
        *particles.remarks(),
        *remarks_on_misfits(scene),
        *remarks_on_unheld_fluid(scene, particles),
        *remarks_on_open_corners(scene),
        *remarks_on_thin_bodies(scene, particles),
        *remarks_on_flotation(scene, particles, floating),
        *remarks_on_missing_contact(scene, particles, floating),
        *remarks_on_drift(scene, particles),
        *remarks_on_rows(scene, particles),
    ]

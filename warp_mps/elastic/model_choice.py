"""The elastic models by name."""

from typing import Any

import numpy as np

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.model import ElasticModel
from warp_mps.elastic.springs.model import SpringModel
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


def make_model(
    scene: Scene, particles: Particles, held: np.ndarray, *, types: NumericTypes, device: Any
) -> ElasticModel:
    """The model that a scene names.

    Args:
        scene: The case.
        particles: Its particles.
        held: Whether the rotation of each particle is held, shape [n].
        types: Number types.
        device: Warp device.
    """
    if scene.elasticity.model == "hamiltonian":
        return HamiltonianModel(scene, particles, types=types, device=device)
    return SpringModel(scene, particles, held, types=types, device=device)

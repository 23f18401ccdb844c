"""Kelvin-Voigt damping on a given set of particles: its constants, and the launches that use them."""

import functools
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.damping.kernels import viscous_kernels
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.materials.constants import lame_constants
from warp_mps.elastic.model import ElasticModel, Pass
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class Viscosity:
    """Kelvin-Voigt damping of the particles of a Hamiltonian model.

    Attributes:
        force: Viscous force at the last evaluation [N], vec [n].
    """

    def __init__(
        self, scene: Scene, particles: Particles, model: HamiltonianModel, *, types: NumericTypes, device: Any
    ) -> None:
        self._kernels, self._device, self._model = viscous_kernels(types), device, model
        # the constants of the linear law for every law: all laws agree at small strains
        constants = [lame_constants(material, particles.dimension, scene.plane) for material in scene.materials]
        times = np.array([material.retardation_time for material in scene.materials])[particles.materials]
        mean = model.dilatation.lame.numpy().astype(float)
        lame, mu = times * (np.array(constants)[particles.materials].T - (mean, np.zeros(len(mean))))
        self._tau_lame, self._tau_mu = (wp.array(values, dtype=types.real, device=device) for values in (lame, mu))
        self._tau_kappa = wp.array(times * model.kappa.numpy(), dtype=types.real, device=device)
        self._tau_mean = wp.array(times * mean, dtype=types.real, device=device)
        self._linear = wp.zeros(particles.count, dtype=wp.int32, device=device)
        self._matrices = [wp.zeros(particles.count, dtype=types.mat, device=device) for _ in range(3)]
        # rates of the dilatations, their means, and the stress of these
        self._rates = [wp.zeros(particles.count, dtype=types.real, device=device) for _ in range(3)]
        self._u_before = wp.zeros(particles.count, dtype=types.vec, device=device)
        self.force = wp.zeros(particles.count, dtype=types.vec, device=device)

    def passes(self, dt: float) -> list[tuple[str, Pass]]:
        """Launches that follow each of the model's passes; `dt` is the time step, 0 before the first one [s]."""
        mean: list[tuple[str, Pass]] = [("viscous mean", self.launch_mean), ("viscous gather", self.launch_gather)]
        return [
            ("viscous stress", functools.partial(self.launch_stress, dt)),
            *(mean if self._model.dilatation.acts else []),
            ("viscous force", self.launch_force),
        ]

    def launch_stress(self, dt: float, state: ElasticState, first: int, count: int) -> None:
        """Launch the viscous stresses, after the elastic ones; `dt` is 0 before the first step."""
        model = self._model
        constants = [*model.operators(), self._tau_lame, self._tau_mu, self._tau_kappa]
        inputs = [first, dt, *constants, model.gradient, state.u, state.v]
        stiffness, damping, pull = self._matrices
        outputs = [stiffness, damping, self._rates[0], pull]
        wp.launch(self._kernels.viscous_stress, count, inputs, outputs, device=self._device)

    def launch_mean(self, state: ElasticState, first: int, count: int) -> None:
        """Launch the means of the rates of the dilatations."""
        self._model.dilatation.average(self._rates[0], self._rates[1], first, count)

    def launch_gather(self, state: ElasticState, first: int, count: int) -> None:
        """Add the stress of these means to D_i."""
        _, mean, stress = self._rates
        inputs = [self._model.gradient, mean, stress, self._matrices[2], first, count]
        self._model.dilatation.gather(*inputs, modulus=self._tau_mean, law=self._linear)

    def launch_force(self, state: ElasticState, first: int, count: int) -> None:
        """Add the viscous forces to those of the model, and the energy that they dissipate."""
        inputs = [first, *self._model.operators()[:4], state.u, state.v, *self._matrices]
        outputs = [self._u_before, self.force, state.force, state.dissipated]
        wp.launch(self._kernels.viscous_force, count, inputs, outputs, device=self._device)

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [self.force, self._u_before]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name."""
        return {"viscous": self.force.numpy().copy()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.force.assign(arrays["viscous"])
        # forces are evaluated where a step ends: these are the displacements of the last one
        self._u_before.assign(arrays["u"][: len(self._u_before)])


def make_viscosity(
    scene: Scene, particles: Particles, model: ElasticModel, *, types: NumericTypes, device: Any
) -> Viscosity | None:
    """The damping of the materials of a scene; None without a retardation time."""
    if not any(material.retardation_time for material in scene.materials):
        return None
    assert isinstance(model, HamiltonianModel)
    return Viscosity(scene, particles, model, types=types, device=device)

"""What a simulation shows to its observers, and what it asks of them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from warp_mps.core.interrupts import hold_interrupts
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy

if TYPE_CHECKING:
    from warp_mps.scene import Scene


class View(Protocol):
    """A run at one moment, read-only; arrays are float64, evaluated when first asked for and kept for the moment.

    In 2-D every extensive quantity (mass, force, energy) is per metre of depth.
    """

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def step(self) -> int:
        """Number of steps done."""

    @property
    def steps_done(self) -> int:
        """Number of time steps done, of fluids those within the steps of the run."""

    @property
    def total_steps(self) -> int:
        """Number of steps of the whole run."""

    @property
    def particles(self) -> Particles:
        """Particles in their reference configuration."""

    @property
    def scene(self) -> Scene:
        """The case."""

    @property
    def positions(self) -> np.ndarray:
        """Particle positions x [m], shape [n, dimension]."""

    @property
    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, dimension]."""

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, dimension]."""

    @property
    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""

    @property
    def volumes(self) -> np.ndarray:
        """Volumes that particles of fluids take up, else 0 [m^d], shape [n]."""

    @property
    def stresses(self) -> np.ndarray:
        """Cauchy stresses [Pa], shape [n, 3, 3]; in 2-D the third axis is the normal of the plane."""

    @property
    def strains(self) -> np.ndarray:
        """Green-Lagrange strains [-], shape [n, 3, 3]."""

    @property
    def von_mises(self) -> np.ndarray:
        """Von Mises stresses [Pa], shape [n]."""

    @property
    def strain_energy_densities(self) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""

    @property
    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, dimension]."""

    @property
    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces on the particles [N], shape [n, dimension]."""

    @property
    def elastic_forces(self) -> np.ndarray:
        """Elastic forces, and those of the material's damping, on the particles [N], shape [n, dimension]."""

    @property
    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def reactions(self) -> np.ndarray:
        """Forces that the supports exert on the particles [N], shape [n, dimension]."""

    @property
    def energy(self) -> Energy:
        """Energies of all particles."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, as host arrays of their own (later steps do not change them)."""


class Observer(Protocol):
    """Something that looks at a run every so many steps, at its start and at its end."""

    @property
    def every(self) -> int:
        """Steps between two calls of :meth:`observe`."""

    def observe(self, view: View) -> None:
        """Look at the run.

        Raises:
            RunError: The run must stop.
        """

    def close(self) -> None:
        """Finish; called once, also after a failure or an interruption."""


@contextlib.contextmanager
def closing(observers: Sequence[Observer]) -> Iterator[None]:
    """Close all observers at the end, whatever happens; of several errors the first is raised.

    An interrupt does not stop the closing: who is impatient loses nothing.
    """
    errors: list[BaseException] = []
    try:
        yield
    except BaseException as error:
        errors.append(error)
    with hold_interrupts():
        for observer in observers:
            try:
                observer.close()
            except BaseException as error:
                errors.append(error)
        if errors:
            raise errors[0]

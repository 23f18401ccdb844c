"""The interface of observers: the view of a run that they get, and the methods that they define.

An observer of one's own::

    class Crest(mps.Observer):
        interval = 0.01  # [s]

        def observe(self, view: mps.View) -> None:
            print(view.time, view.positions[:, 1].max())

    mps.run_scene(scene, "runs/waves", observers=[Crest()])
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from warp_mps.core.interrupts import defer_interrupts
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy

if TYPE_CHECKING:
    from warp_mps.scene import Scene


class View(Protocol):
    """A run at one moment, read-only.

    Arrays are float64 NumPy arrays that cannot be written to, read from the device when first asked for and kept until
    the next step; they stay valid after it. Their rows are the n particles in the order of `particles`: elastic bodies,
    walls, fluids, each as the scene has them; ``particles.ranges`` has the rows of each by name. d is the scene's
    dimension. In 2-D every extensive quantity (mass, force, energy) is per metre of depth.
    """

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def step(self) -> int:
        """Number of steps of the run done; with fluids a step of the run is an interval between two samples."""

    @property
    def steps_done(self) -> int:
        """Number of time steps done; of fluids, those within the steps of the run."""

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
        """Particle positions x [m], shape [n, d]."""

    @property
    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""

    @property
    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""

    @property
    def number_densities(self) -> np.ndarray:
        """Number densities of fluids in units of a full lattice's, else 1 [-], shape [n]."""

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
        """Contact forces on the particles [N], shape [n, d]."""

    @property
    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces on the particles [N], shape [n, d]."""

    @property
    def elastic_forces(self) -> np.ndarray:
        """Elastic forces, and those of the material's damping, on the particles [N], shape [n, d]."""

    @property
    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""

    @property
    def reactions(self) -> np.ndarray:
        """Forces that the supports exert on the particles [N], shape [n, d]."""

    @property
    def energy(self) -> Energy:
        """Energies of all particles."""

    @property
    def energy_of_bodies(self) -> Energy | None:
        """Energies of elastic bodies in water alone, on which the water does work; None if either is missing."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, as host arrays of their own (later steps do not change them)."""


class Observer:
    """Something that looks at a run at its start, then regularly, and at its end.

    A subclass defines `observe`, and sets `every` or `interval`, on the class or in its constructor.

    Attributes:
        every: Steps of the run between two calls of `observe`.
        interval: Simulated time between two calls [s], instead of `every`: each call is at the first step of the run
            at or after a multiple of it. With fluids a step of the run is an interval between two samples, by the
            scene's `sample_rate`.
    """

    every: int = 1
    interval: float | None = None

    def observe(self, view: View) -> None:
        """Look at the run.

        Raises:
            RunError: The run must stop.
        """
        raise NotImplementedError(f"{type(self).__name__} does not define observe(view)")

    def close(self) -> None:
        """Finish; called once, also after a failure or an interruption."""


@contextlib.contextmanager
def closing(observers: Sequence[Observer]) -> Iterator[None]:
    """Close all observers at the end, whatever happens; of several errors the first is raised.

    An interrupt takes effect after the closing, so that nothing is lost.
    """
    errors: list[BaseException] = []
    try:
        yield
    except BaseException as error:
        errors.append(error)
    with defer_interrupts():
        for observer in observers:
            try:
                observer.close()
            except BaseException as error:
                errors.append(error)
        if errors:
            raise errors[0]

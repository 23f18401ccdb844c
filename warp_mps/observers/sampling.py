"""Evaluation of probes: neighbours and weights in the reference configuration are found once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warp_mps.errors import InputError
from warp_mps.observers.base import View
from warp_mps.observers.fluid_sampling import sample_of_fluid
from warp_mps.observers.interpolation import interpolate
from warp_mps.observers.rigid_point import rigid_point
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import is_clamp, select, select_held
from warp_mps.scene import PROBE_UNITS, Probe, Scene
from warp_mps.scene.components import TENSORS, component_names, tensor_places
from warp_mps.scene.validation.fluids import is_in_fluid
from warp_mps.scene.validation.scene import place

FIELDS = {
    "displacement": "displacements",
    "velocity": "velocities",
    "rotation": "rotations",
    "pressure": "pressures",
    "stress": "stresses",
    "strain": "strains",
    "von_mises": "von_mises",
    "strain_energy": "strain_energy_densities",
}
Sample = Callable[[View], np.ndarray]


@dataclass(frozen=True)
class Sampler:
    """A probe ready to be evaluated.

    Attributes:
        labels: Labels of its columns, e.g. ``tip.x [m]``.
        sample: Gives the values, one for each label, at a moment of the run.
    """

    labels: tuple[str, ...]
    sample: Sample


def make_sampler(probe: Probe, scene: Scene, particles: Particles) -> Sampler:
    """Prepare a probe.

    Raises:
        InputError: The probe lies outside every body, or its region holds no particle.
    """
    if probe.body is not None:
        sample = _of_body(probe, particles)
    elif probe.support is not None:
        support = next(support for support in scene.supports if support.name == probe.support)
        sample = _sum("reactions", select_held(particles, support))
    elif is_in_fluid(probe, scene):
        sample = sample_of_fluid(probe, scene, particles)
    else:
        sample = _of_place(probe, particles)
        _refuse_clamped_section(probe, scene, particles)
    return Sampler(_labels(probe, scene), sample)


def _labels(probe: Probe, scene: Scene) -> tuple[str, ...]:
    """Labels with the axes of the stage, which are those that a person knows."""
    unit = PROBE_UNITS[probe.quantity][scene.dimension - 2]
    names = component_names(probe.quantity, scene.frame.axes)
    return tuple(f"{probe.name}.{name} [{unit}]" for name in names) or (f"{probe.name} [{unit}]",)


def _of_place(probe: Probe, particles: Particles) -> Sample:
    where = place(probe, "probe")
    if probe.point is not None:
        origin = np.asarray(probe.point, dtype=float)
        indices, weights = interpolate(particles, origin, where)
        return _mean(probe.quantity, origin, indices, weights)
    assert probe.region is not None
    indices = select(particles, probe.region)
    if len(indices) == 0:
        raise InputError(where, "region", "holds no particle: it must reach into a body")
    if probe.quantity == "section_force":
        return _sum("elastic_forces", indices)
    if probe.quantity == "section_moment":
        return _section_moment(probe, particles, indices)
    weights = np.full(len(indices), 1.0 / len(indices))
    return _mean(probe.quantity, weights @ particles.positions[indices], indices, weights)


def _of_body(probe: Probe, particles: Particles) -> Sample:
    """Of a body, a wall or a fluid."""
    assert probe.body is not None
    first, last = particles.ranges[particles.names.index(probe.body)]
    indices = np.arange(first, last)
    masses, width = particles.masses[indices], float(particles.spacings[first])
    weights = masses / masses.sum()
    # a particle reaches half a spacing beyond its centre
    samples: dict[str, Sample] = {
        "contact_force": _sum("contact_forces", indices),
        "momentum": lambda view: masses @ view.velocities[indices],
        "angular_momentum": _angular_momentum(particles, indices),
        "kinetic_energy": lambda view: np.atleast_1d(0.5 * masses @ np.sum(view.velocities[indices] ** 2, axis=1)),
        "extent": lambda view: np.ptp(view.positions[indices], axis=0) + width,
        "lowest": lambda view: view.positions[indices].min(axis=0) - 0.5 * width,
        "highest": lambda view: view.positions[indices].max(axis=0) + 0.5 * width,
        "volume": lambda view: np.atleast_1d(view.volumes[indices].sum()),
    }
    if probe.quantity == "contact_moment":
        return _contact_moment(probe, particles, indices)
    if probe.quantity in samples:
        return samples[probe.quantity]
    return _mean(probe.quantity, weights @ particles.positions[indices], indices, weights)


def _mean(quantity: str, origin: np.ndarray, indices: np.ndarray, weights: np.ndarray) -> Sample:
    """Weighted mean of a field; a position is the origin moved by the mean displacement, to lose no digits."""
    if quantity == "position":
        return lambda view: origin + weights @ view.displacements[indices]
    field = FIELDS[quantity]
    if quantity in TENSORS:
        rows, columns = zip(*tensor_places(len(origin)), strict=True)
        return lambda view: weights @ getattr(view, field)[indices][:, rows, columns]
    return lambda view: np.atleast_1d(weights @ getattr(view, field)[indices])


def _sum(field: str, indices: np.ndarray) -> Sample:
    return lambda view: getattr(view, field)[indices].sum(axis=0)


def _refuse_clamped_section(probe: Probe, scene: Scene, particles: Particles) -> None:
    """Refuse the moment of a part that a clamp holds, whose forces act at the face and not on the held particles.

    Raises:
        InputError: The probe's region holds particles of a clamp.
    """
    if probe.quantity != "section_moment" or probe.region is None:
        return
    inside = select(particles, probe.region)
    for support in scene.supports:
        if is_clamp(support, particles.dimension) and np.isin(select_held(particles, support), inside).any():
            reason = (
                f"holds particles of {place(support, 'support')}, whose forces act at its face: "
                "draw it about the free part, whose moment is the opposite"
            )
            raise InputError(place(probe, "probe"), "region", reason)


def _section_moment(probe: Probe, particles: Particles, indices: np.ndarray) -> Sample:
    """Sum of (x - c) cross f and of the torques on the particles' own rotation, c the displaced point `about`."""
    origin = np.asarray(probe.about, dtype=float)
    near, weights = interpolate(particles, origin, place(probe, "probe"), "about")
    arms = particles.positions[indices] - origin

    def sample(view: View) -> np.ndarray:
        moved = view.displacements[indices] - weights @ view.displacements[near]
        return (_cross(arms + moved, view.elastic_forces[indices]) + view.elastic_torques[indices]).sum(axis=0)

    return sample


def _contact_moment(probe: Probe, particles: Particles, indices: np.ndarray) -> Sample:
    """Sum of (x - c) cross f, c the point `about` of the wall, which moves with it."""
    assert probe.body is not None
    locate = rigid_point(particles, probe.body, np.asarray(probe.about, dtype=float))

    def sample(view: View) -> np.ndarray:
        return _cross(view.positions[indices] - locate(view), view.contact_forces[indices]).sum(axis=0)

    return sample


def _angular_momentum(particles: Particles, indices: np.ndarray) -> Sample:
    """Sum of x cross m v about the scene's origin and of the particles' spin I omega, I = m l0^2/6."""
    masses = particles.masses[indices, None]
    inertias = masses * particles.spacings[indices, None] ** 2 / 6.0

    def sample(view: View) -> np.ndarray:
        orbital = _cross(view.positions[indices], masses * view.velocities[indices])
        return (orbital + inertias * view.angular_velocities[indices]).sum(axis=0)

    return sample


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    if a.shape[1] == 2:
        return a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]
    return np.cross(a, b)

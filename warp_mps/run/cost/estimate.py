"""The estimated cost of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from warp_mps.core.weights import lattice_neighbours
from warp_mps.fluid.domain import domain
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.run.cost.disk import disk_of
from warp_mps.run.cost.memory import memory_of, refuse_too_large
from warp_mps.run.cost.time_step import TimeStep, time_step
from warp_mps.run.cost.work import seconds_of
from warp_mps.run.schedule import Clock
from warp_mps.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Estimated cost of a run.

    Attributes:
        particles: Number of particles of each body, wall and fluid.
        neighbours: Neighbours of a particle inside a body, or inside a fluid where there is one.
        time_step: The time step, and what limits it.
        frames: Number of saved frames.
        frame_rate: Saved frames per simulated second [1/s]; in statics, per unit of the load factor.
        sample_rate: Rows of probes.csv likewise [1/s].
        memory: Memory needed at most, beside that of the program itself [bytes].
        disk: Size of the animation at most, of which two are kept while it is written [bytes].
        seconds: CPU time on one core, the start of the program included [s].
    """

    particles: Mapping[str, int]
    neighbours: int
    time_step: TimeStep
    frames: int
    frame_rate: float
    sample_rate: float
    memory: float
    disk: float
    seconds: float


def estimate(scene: Scene, particles: Particles | None = None) -> Cost:
    """Estimate the cost of a run of a scene.

    Args:
        scene: The scene.
        particles: Its particles, where it is filled already.

    Raises:
        InputError: It cannot be filled, needs more memory than there is, or has a domain that leaves fluids out.
    """
    if particles is None:
        refuse_too_large(scene)
        particles = fill_scene(scene)
    counts = dict(zip(particles.names, np.diff(particles.ranges, axis=1).ravel().tolist(), strict=True))
    clock, step = Clock(scene), time_step(scene, particles)
    if scene.fluids:
        domain(scene, particles)  # refuses what a run would refuse
    radius = scene.flow.radius(scene.dimension) if scene.fluids else scene.elasticity.effective_radius
    frames = clock.steps // clock.frame_every + 1
    return Cost(
        particles=counts,
        neighbours=lattice_neighbours(scene.dimension, radius),
        time_step=step,
        frames=frames,
        frame_rate=1.0 / (clock.frame_every * clock.dt),
        sample_rate=1.0 / (clock.sample_every * clock.dt),
        memory=memory_of(scene, counts),
        disk=disk_of(scene, counts, frames),
        seconds=seconds_of(scene, particles, step, clock),
    )

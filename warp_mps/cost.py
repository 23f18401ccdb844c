"""What a run will take, known before anything is allocated: particles, memory, steps, time."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles import count_particles
from warp_mps.scene import Scene
from warp_mps.simulation import Clock

# seconds a particle-step and neighbour on one CPU core, as the benchmark measures it (2-D, 3-D)
SECONDS_PER_PAIR = {2: 12e-9, 3: 30e-9}
# bytes that a particle and a pair take at most (2-D, 3-D); a block of a million particles was measured to need 0.7 GB
# in 2-D and 1.8 GB in 3-D, where these figures give 1.1 and 2.4
BYTES_PER_PARTICLE = {2: 600, 3: 900}
BYTES_PER_PAIR = {2: 40, 3: 48}


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a run will take.

    Attributes:
        particles: Number of particles of each body, at most.
        neighbours: Neighbours of a particle inside a body.
        dt: Time step [s].
        steps: Number of steps.
        frames: Number of saved frames.
        memory: Memory needed at most [bytes].
        seconds: Wall time on one CPU core [s].
    """

    particles: dict[str, int]
    neighbours: int
    dt: float
    steps: int
    frames: int
    memory: float
    seconds: float


def estimate(scene: Scene) -> Cost:
    """Estimate what a run of a scene takes.

    Raises:
        InputError: A body cannot be filled.
    """
    clock = Clock(scene)
    particles = count_particles(scene)
    total = sum(particles.values())
    neighbours = lattice_neighbours(scene.dimension, scene.elasticity.effective_radius)
    memory = float(total) * (BYTES_PER_PARTICLE[scene.dimension] + BYTES_PER_PAIR[scene.dimension] * neighbours)
    return Cost(
        particles=particles,
        neighbours=neighbours,
        dt=clock.dt,
        steps=clock.steps,
        frames=clock.steps // clock.frame_every + 1,
        memory=memory,
        seconds=total * clock.steps * neighbours * SECONDS_PER_PAIR[scene.dimension],
    )


def lattice_neighbours(dimension: int, effective_radius: float) -> int:
    """Number of neighbours inside a lattice."""
    reach = np.arange(-int(effective_radius) - 1, int(effective_radius) + 2)
    squared = sum(axis**2 for axis in np.meshgrid(*[reach] * dimension))
    return int(np.sum(squared < effective_radius**2)) - 1


def refuse_too_large(scene: Scene, cost: Cost) -> None:
    """Refuse a run that needs more memory than there is, before any of it is taken.

    Raises:
        InputError: It does; the line names the largest body.
    """
    available = available_memory()
    if cost.memory > available:
        name = max(cost.particles, key=lambda body: cost.particles[body])
        body = next(body for body in scene.bodies if body.name == name)
        raise InputError(
            body.path or f"body '{name}'",
            "spacing",
            f"{body.spacing:g} m makes {cost.particles[name]:.4g} particles; the run needs about "
            f"{cost.memory / 2**30:.3g} GiB of memory and {available / 2**30:.3g} GiB are available",
        )


def available_memory() -> float:
    """Memory that can be taken without swapping [bytes]; infinite where the system does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            values = dict(line.split(":") for line in file)
        return float(values["MemAvailable"].split()[0]) * 1024.0
    except (OSError, KeyError, ValueError):
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (OSError, ValueError, AttributeError):
        return float("inf")

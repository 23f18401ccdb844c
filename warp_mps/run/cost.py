"""Cost of a run, estimated before anything is allocated: particles, memory, steps, wall time."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from warp_mps.core.weights import lattice_neighbours
from warp_mps.elastic.explicit.time_step import stable_time_step
from warp_mps.errors import InputError
from warp_mps.particles.filling import count_particles, fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.run.schedule import Clock
from warp_mps.scene import Body, Scene
from warp_mps.scene.validation.rules import kind_of
from warp_mps.scene.validation.scene import place

# wall time per particle-step and neighbour on one CPU core, as the benchmark measures it [s] (2-D, 3-D)
SECONDS_PER_PAIR = {"springs": {2: 12e-9, 3: 28e-9}, "hamiltonian": {2: 7e-9, 3: 9e-9}}
# factor of that with a retardation time (2-D, 3-D)
VISCOUS = {2: 2.6, 3: 3.7}
# additional wall time per particle-step, walls included, of contact, and of friction [s] (2-D, 3-D)
SECONDS_OF_CONTACT = {2: 15e-9, 3: 25e-9}
SECONDS_OF_FRICTION = {2: 13e-9, 3: 28e-9}
# wall time per particle-step of fluids, walls included, on one CPU core [s] (2-D, 3-D): tanks of 2000 to 70000
# particles took 0.8 to 1.1 and 0.7 to 1.8 us
SECONDS_PER_FLUID_STEP = {2: 1.2e-6, 3: 1.6e-6}
# memory per particle of a scene of fluids, walls and markers of bodies included [bytes] (2-D, 3-D); tanks of 0.04 and
# 0.13 million particles took 1610 in 2-D and 1930 in 3-D, and less where most are of walls; neighbour lists that have
# to grow to twice the room, which dam breaks do not need, take 1000 and 1600 more
BYTES_OF_FLUID = {2: 1700, 3: 2100}
# memory per particle of a body, and per pair [bytes] (2-D, 3-D); blocks of 0.16 and 0.04 million particles took 1200
# and 1820 a particle at the peak, where these figures give 1220 and 1860
BYTES_PER_PARTICLE = {2: 900, 3: 1000}
BYTES_PER_PAIR = {2: 40, 3: 48}
# additional memory per particle of contact between bodies of equal spacing, and of friction [bytes] (2-D, 3-D); 320 and
# 550, 450 and 920 measured
BYTES_OF_CONTACT = {2: 350, 3: 450}
BYTES_OF_FRICTION = {2: 560, 3: 930}
# additional memory per marker of a body in water, mostly of the interface quasi-Newton method [bytes] (2-D, 3-D);
# columns of water against blocks took 3800 to 8100 in 2-D and 8900 in 3-D
BYTES_OF_MARKER = {2: 8500, 3: 10000}

# size of a particle in a frame: position, velocity and pressure, and the outputs [bytes]
BYTES_OF_FRAME = 28
BYTES_OF_OUTPUT = {"stress": 72, "strain": 72, "von_mises": 4, "strain_energy": 4}
# every save leaves the tables of the previous one in the file: their size, that of a sample in them, and the most that
# is left beyond the content (`warp_mps.usd.animation.points_file`) [bytes]; time samples of each body, wall and fluid
BYTES_OF_SAVE, BYTES_OF_SAMPLE, MOST_LEFT, SERIES = 1200, 10, 2**20, 4

# additional memory per particle of implicit steps and statics [bytes] (2-D, 3-D); 1150 and 1850 measured, of which
# aggregates take 490 and 730, most of it during setup
BYTES_OF_SOLVER = {2: 1200, 3: 2000}
# Newton iterations of a load step and of a time step; cost of an iteration of the linear solver in units of an explicit
# step; linear iterations, and the number of particles above which they grow: squares and cubes of 1400 to 96000
# particles took 27 to 91, and 30 to 49
NEWTON = {"static": 6.0, "dynamic": 2.0}
PRODUCT, LINEAR, LINEAR_PARTICLES = 1.5, 40.0, 10_000
# coupling passes of a step, each with a pressure solve, which is the larger part of it
PASSES = 3.0


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Estimated cost of a run.

    Attributes:
        particles: Number of particles of each body and wall, at most.
        neighbours: Neighbours of a particle inside a body.
        dt: Time step [s]; of fluids the longest.
        dt_limit: Time step above which the run is unstable [s].
        steps: Number of steps; of fluids the least.
        frames: Number of saved frames.
        memory: Memory needed at most [bytes].
        disk: Size of the animation at most, of which two are kept while it is written [bytes].
        seconds: Wall time on one CPU core [s].
    """

    particles: dict[str, int]
    neighbours: int
    dt: float
    dt_limit: float
    steps: int
    frames: int
    memory: float
    disk: float
    seconds: float


def estimate(scene: Scene) -> Cost:
    """Estimate the cost of a run of a scene.

    Raises:
        InputError: A body cannot be filled, or fluids need more memory than there is, or their domain leaves them out.
    """
    if scene.fluids:
        return _estimate_fluids(scene)
    clock = Clock(scene)
    particles = count_particles(scene)
    total = sum(particles.values())
    elastic = sum(particles[body.name] for body in scene.bodies)
    neighbours = lattice_neighbours(scene.dimension, scene.elasticity.effective_radius)
    per_pair = SECONDS_PER_PAIR[scene.elasticity.model][scene.dimension]
    if any(material.retardation_time for material in scene.materials):
        per_pair *= VISCOUS[scene.dimension]
    contact = _contact_of(scene, SECONDS_OF_CONTACT, SECONDS_OF_FRICTION)
    products = _products(scene, elastic) if scene.implicit else 1.0
    return Cost(
        particles=particles,
        neighbours=neighbours,
        dt=clock.dt,
        dt_limit=clock.dt_limit,
        steps=clock.steps,
        frames=frames_of(clock),
        memory=memory_of(scene, particles),
        disk=disk_of(scene, particles, frames_of(clock)),
        seconds=clock.steps * (elastic * neighbours * per_pair * products + total * contact),
    )


def _products(scene: Scene, particles: int) -> float:
    """Cost of an implicit step in equivalent explicit steps."""
    iterations = LINEAR * max(1.0, particles / LINEAR_PARTICLES) ** (1.0 / scene.dimension)
    if scene.analysis == "dynamic" and scene.time_step is not None:
        # short steps are dominated by inertia, so that few linear iterations are needed
        explicit = min(stable_time_step(body, scene) for body in scene.bodies)
        iterations = min(iterations, 1.0 + 2.0 * scene.time_step / explicit)
    return PRODUCT * NEWTON[scene.analysis] * iterations


def _estimate_fluids(scene: Scene) -> Cost:
    from warp_mps.fluid.domain import domain
    from warp_mps.fluid.time_step import step_limit

    refuse_too_large(scene)  # before the fluid is filled, which its time step depends on
    clock, filled = Clock(scene), fill_scene(scene)
    particles = dict(zip(filled.names, np.diff(filled.ranges, axis=1).ravel().tolist(), strict=True))
    domain(scene, filled)  # refuses what a run would refuse
    limit, _ = step_limit(scene, filled)
    dt = min(limit, scene.time_step or limit, clock.dt)
    steps = math.ceil(scene.duration / dt - 1e-6)
    passes = PASSES if scene.bodies else 1.0
    return Cost(
        particles=particles,
        neighbours=lattice_neighbours(scene.dimension, scene.flow.radius(scene.dimension)),
        dt=dt,
        dt_limit=limit,
        steps=steps,
        frames=frames_of(clock),
        memory=memory_of(scene, particles),
        disk=disk_of(scene, particles, frames_of(clock)),
        seconds=steps * (filled.count * SECONDS_PER_FLUID_STEP[scene.dimension] * passes + _of_bodies(scene, filled)),
    )


def _of_bodies(scene: Scene, particles: Particles) -> float:
    """Wall time of the elastic bodies in a step of the fluid around them [s]."""
    from warp_mps.coupling.integrator_choice import stable_step, substep, takes_implicit_steps
    from warp_mps.fluid.time_step import longest_step

    if not scene.bodies:
        return 0.0
    dt = longest_step(scene, particles)
    if takes_implicit_steps(scene):
        iterations = min(LINEAR * particles.elastic ** (1.0 / scene.dimension), 1.0 + 2.0 * dt / stable_step(scene))
        steps = PRODUCT * NEWTON["dynamic"] * iterations
    else:
        steps = dt / substep(scene, particles, Clock(scene).dt)[0]
    neighbours = lattice_neighbours(scene.dimension, scene.elasticity.effective_radius)
    contact = _contact_of(scene, SECONDS_OF_CONTACT, SECONDS_OF_FRICTION)
    pairs = neighbours * SECONDS_PER_PAIR[scene.elasticity.model][scene.dimension]
    dry = particles.count - particles.liquid
    return (PASSES + 1.0) * steps * (particles.elastic * pairs + dry * contact)


def frames_of(clock: Clock) -> int:
    """Number of saved frames, the first and the last included."""
    return clock.steps // clock.frame_every + 1


def disk_of(scene: Scene, particles: Mapping[str, int], frames: int) -> float:
    """Size of an animation of so many frames, at most, with so many particles of each body, wall and fluid [bytes]."""
    elastic, total = sum(particles[body.name] for body in scene.bodies), sum(particles.values())
    content = frames * (total * BYTES_OF_FRAME + elastic * sum(BYTES_OF_OUTPUT[name] for name in scene.outputs))
    series = SERIES * len(particles) + len(scene.outputs) * len(scene.bodies)
    left = 0.5 * frames * (BYTES_OF_SAVE + frames * series * BYTES_OF_SAMPLE)
    return float(content + min(left, content + MOST_LEFT))


def memory_of(scene: Scene, particles: Mapping[str, int]) -> float:
    """Memory that a run with so many particles of each body, wall and fluid needs at most [bytes]."""
    d, elastic, total = scene.dimension, sum(particles[body.name] for body in scene.bodies), sum(particles.values())
    pairs = lattice_neighbours(d, scene.elasticity.effective_radius)
    implicit = scene.implicit or bool(scene.fluids and scene.bodies and _follows_implicitly(scene))
    own = BYTES_PER_PARTICLE[d] + BYTES_PER_PAIR[d] * pairs + (BYTES_OF_SOLVER[d] if implicit else 0)
    dry = total - sum(particles[fluid.name] for fluid in scene.fluids)
    wet = total - elastic if scene.fluids else 0
    # without fluids, walls take as much memory as bodies
    solid = elastic if scene.fluids else total
    seen = sum(particles[body.name] / _finer(scene, body) ** d for body in scene.bodies) if scene.fluids else 0.0
    water = wet * BYTES_OF_FLUID[d] + seen * (BYTES_OF_FLUID[d] + BYTES_OF_MARKER[d])
    return solid * own + dry * _contact_of(scene, BYTES_OF_CONTACT, BYTES_OF_FRICTION) + water


def _follows_implicitly(scene: Scene) -> bool:
    from warp_mps.coupling.integrator_choice import takes_implicit_steps

    return takes_implicit_steps(scene)


def _finer(scene: Scene, body: Body) -> int:
    """Particles of a body along a spacing of the fluid."""
    return max(1, round(scene.fluids[0].spacing / body.spacing))


def _contact_of(scene: Scene, touching: Mapping[int, float], friction: Mapping[int, float]) -> float:
    """Additional cost of contact per particle: the first where bodies can touch, and the second with friction."""
    several = len(scene.bodies) + len(scene.walls) > 1
    if scene.contact.between == "none" or not (several or scene.contact.between == "all"):
        return 0.0
    slides = scene.contact.friction or any(wall.friction for wall in scene.walls)
    return touching[scene.dimension] + (friction[scene.dimension] if slides else 0.0)


def refuse_too_large(scene: Scene) -> None:
    """Refuse a run that needs more memory than is available, before any of it is allocated.

    Raises:
        InputError: It does; the line names the largest body.
    """
    particles, available = count_particles(scene), available_memory()
    memory = memory_of(scene, particles)
    if memory > available:
        name = max(particles, key=lambda body: particles[body])
        body = next(item for item in scene.filled if item.name == name)
        raise InputError(
            place(body, kind_of(body)),
            "spacing",
            f"{body.spacing:g} m makes {particles[name]:.4g} particles; the run needs about "
            f"{memory / 2**30:.3g} GiB of memory and {available / 2**30:.3g} GiB are available",
        )


def available_memory() -> float:
    """Memory that can be taken without swapping [bytes]; infinite where the system does not say."""
    return min(_free_memory(), _left_of_limit())


def _left_of_limit() -> float:
    """Memory that the process may still take [bytes], where its address space is limited."""
    try:
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit == resource.RLIM_INFINITY:
            return math.inf
        with open("/proc/self/statm", encoding="ascii") as file:
            return max(0.0, limit - float(file.read().split()[0]) * resource.getpagesize())
    except (ImportError, OSError, ValueError):
        return math.inf


def _free_memory() -> float:
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

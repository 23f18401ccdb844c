"""CPU time of a run on one core.

The constants are fitted to the shipped stages on one core of a server, where the estimate of each is within a factor of
1.5 of the time that it takes.
"""

from __future__ import annotations

from warp_mps.core.weights import lattice_neighbours
from warp_mps.coupling.integrator_choice import stable_step
from warp_mps.elastic.materials.constants import mean_lame
from warp_mps.particles.particles import Particles
from warp_mps.run.cost.memory import contact_of
from warp_mps.run.cost.time_step import TimeStep
from warp_mps.run.schedule import Clock
from warp_mps.scene import Scene

# start of the program, with the kernels in their cache [s]; of kernels of solvers and of fluids
START, START_OF_SOLVERS = 1.5, 0.3
# launches of an explicit step, of a step of fluids, and of an iteration of the linear solver [s]
LAUNCHES_OF_STEP = {"springs": 10e-6, "hamiltonian": 15e-6}
LAUNCHES_OF_FLUID, LAUNCHES_OF_ITERATION = 2e-3, 35e-6
# time per step of an elastic particle and neighbour [s] (2-D, 3-D)
SECONDS_PER_PAIR = {"springs": {2: 12e-9, 3: 28e-9}, "hamiltonian": {2: 12.5e-9, 3: 19e-9}}
# factor of that with a retardation time (2-D, 3-D)
VISCOUS = {2: 2.6, 3: 3.7}
# factor of that with a mean dilatation, of materials above nu = 0.4 (2-D, 3-D)
DILATATION = {2: 1.75, 3: 1.6}
# launches of contact in a step [s]; additional time per particle-step, walls included, of contact and of friction [s]
LAUNCHES_OF_CONTACT = 15e-6
SECONDS_OF_CONTACT = {2: 25e-9, 3: 30e-9}
SECONDS_OF_FRICTION = {2: 15e-9, 3: 30e-9}
# time per step of a fluid particle, and of a wall particle beside it [s] (2-D, 3-D)
SECONDS_OF_FLUID = {2: 2.9e-6, 3: 7e-6}
SECONDS_OF_WALL = {2: 0.5e-6, 3: 1e-6}
# factor of the schemes with more neighbour sums in a step
SCHEMES = {"conservative": 1.0, "corrected": 1.5, "koshizuka_oka": 1.0}
# observers at a row and at a frame [s], and for each particle [s]; of a fluid, whose surface they search; a probe [s];
# polar decompositions where rotations are probed in 3-D, for each elastic particle [s]
ROW, ROW_PER_PARTICLE, ROW_PER_FLUID, ROW_PER_PROBE, ROW_PER_ROTATION = 0.8e-3, 0.25e-6, 1.2e-6, 0.05e-3, 2.5e-6
FRAME, FRAME_PER_PARTICLE = 3.5e-3, 0.5e-6

# Newton iterations of a time step; those of a load step: two, one that corrects and one that confirms, and more where
# the steps are long, since the guess continues the last one (2.1 to 5.5 were counted in 2 steps, 2.2 to 4.6 in 5,
# 2.1 to 3.9 in 10, 2.0 in 30)
NEWTON, LEAST_NEWTON, NEWTON_OF_LONG_STEPS, STEPS_OF_NEWTON = 2.0, 2.0, 12.0, 5.0
# cost of an iteration of the linear solver in units of an explicit step; linear iterations, the assembly counted as 12
# of them (2-D, 3-D), and the number of particles above which they grow: squares and cubes of 1400 to 96000 particles
# took 27 to 91, and 20 to 49
PRODUCT, LINEAR, LINEAR_PARTICLES = 1.5, {2: 40.0, 3: 30.0}, 10_000
# linear iterations of a Newton iteration of a time step are this many, and so many more for each explicit step in it
LEAST_LINEAR, LINEAR_PER_STEP = 4.0, 0.45
# coupling passes of a step; Newton iterations of all of its passes; part of a step of the fluid that a pass repeats
PASSES, NEWTON_OF_PASSES, REPEATED = 2.8, 6.2, 0.5


def seconds_of(scene: Scene, particles: Particles, step: TimeStep, clock: Clock) -> float:
    """CPU time of a run [s]."""
    start = START + (START_OF_SOLVERS if scene.fluids or step.implicit else 0.0)
    return start + step.steps * _step(scene, particles, step) + _observers(scene, particles, clock)


def _step(scene: Scene, particles: Particles, step: TimeStep) -> float:
    """CPU time of a step [s]."""
    d = scene.dimension
    if not scene.fluids:
        if not step.implicit:
            return _explicit_step(scene, particles)
        newton = newton_of_load_step(step.steps) if scene.analysis == "static" else NEWTON
        return newton * _linear_iterations(scene, particles, step.length) * _linear_iteration(scene, particles)
    walls = particles.count - particles.elastic - particles.liquid
    fluid = particles.liquid * SECONDS_OF_FLUID[d] * SCHEMES[scene.flow.scheme] + walls * SECONDS_OF_WALL[d]
    fluid += LAUNCHES_OF_FLUID
    if not scene.bodies:
        return fluid
    fluid *= 1.0 + REPEATED * (PASSES - 1.0)
    if not step.implicit:
        return fluid + (PASSES + 1.0) * step.substeps * _explicit_step(scene, particles)
    iterations = NEWTON_OF_PASSES * _linear_iterations(scene, particles, step.length)
    return fluid + iterations * _linear_iteration(scene, particles)


def newton_of_load_step(steps: int) -> float:
    """Newton iterations of a load step of a static analysis, where so many make up the complete load."""
    return LEAST_NEWTON + NEWTON_OF_LONG_STEPS / (steps + STEPS_OF_NEWTON)


def _explicit_step(scene: Scene, particles: Particles) -> float:
    """CPU time of an explicit step of the elastic bodies [s]."""
    d, dry = scene.dimension, particles.count - particles.liquid
    contact = contact_of(scene, SECONDS_OF_CONTACT, SECONDS_OF_FRICTION)
    launches = LAUNCHES_OF_STEP[scene.elasticity.model] + (LAUNCHES_OF_CONTACT if contact else 0.0)
    viscous = VISCOUS[d] if any(material.retardation_time for material in scene.materials) else 1.0
    return launches + particles.elastic * _per_particle(scene) * viscous + dry * contact


def _per_particle(scene: Scene) -> float:
    """CPU time of an elastic particle in an explicit step [s]."""
    d, model = scene.dimension, scene.elasticity.model
    averages = model == "hamiltonian" and any(mean_lame(material, d, scene.plane) for material in scene.materials)
    neighbours = lattice_neighbours(d, scene.elasticity.effective_radius)
    return neighbours * SECONDS_PER_PAIR[model][d] * (DILATATION[d] if averages else 1.0)


def _linear_iteration(scene: Scene, particles: Particles) -> float:
    """CPU time of an iteration of the linear solver of implicit steps [s]."""
    return LAUNCHES_OF_ITERATION + PRODUCT * particles.elastic * _per_particle(scene)


def _linear_iterations(scene: Scene, particles: Particles, dt: float) -> float:
    """Linear iterations of a Newton iteration of an implicit step.

    Short steps are dominated by inertia, so that few are needed.
    """
    most = LINEAR[scene.dimension] * max(1.0, particles.elastic / LINEAR_PARTICLES) ** (1.0 / scene.dimension)
    if scene.analysis == "static":
        return most
    return min(most, LEAST_LINEAR + LINEAR_PER_STEP * dt / stable_step(scene))


def _observers(scene: Scene, particles: Particles, clock: Clock) -> float:
    """CPU time of what observes a run [s]."""
    rows, frames = clock.steps / clock.sample_every, clock.steps / clock.frame_every
    row = ROW + len(scene.probes) * ROW_PER_PROBE
    row += particles.count * ROW_PER_PARTICLE + particles.liquid * ROW_PER_FLUID
    if scene.dimension == 3 and any(probe.quantity == "rotation" for probe in scene.probes):
        row += particles.elastic * ROW_PER_ROTATION
    return rows * row + frames * (FRAME + particles.count * FRAME_PER_PARTICLE)

"""The longest time step of a run, and what limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from warp_mps.coupling.integrator_choice import substep, takes_implicit_steps
from warp_mps.fluid.time_step import step_limits
from warp_mps.particles.particles import Particles
from warp_mps.run.schedule import Clock, body_step_limits
from warp_mps.scene import Scene

# part by which the fastest particle is expected to exceed the speed at the start
FASTER = 1.05
# the name of the limit that rows are
ROWS = "the rows of probes.csv: steps end at them"


@dataclass(frozen=True, kw_only=True)
class TimeStep:
    """The time step of a run.

    Attributes:
        length: Time step [s], of fluids the longest; in statics, of the load factor.
        stable: Time step above which the run is unstable [s], infinite where there is none.
        limits: Limits of the step [s], by what sets them; the rows of probes.csv are one, since steps end at them.
        limited_by: What sets the length.
        steps: Number of steps; of fluids about the least.
        substeps: Explicit sub-steps of the bodies in a step of the fluid around them; 1 where they take the same steps.
        implicit: Whether the bodies take implicit steps.
    """

    length: float
    stable: float
    limits: dict[str, float]
    limited_by: str
    steps: int
    substeps: int = 1
    implicit: bool = False


def time_step(scene: Scene, particles: Particles) -> TimeStep:
    """The time step of a scene that is filled with particles."""
    clock = Clock(scene)
    if scene.fluids:
        return _of_fluids(scene, particles, clock)
    if scene.analysis == "static":
        limits = {"mps:loadSteps": clock.dt}
    else:
        rows = {ROWS: clock.dt * clock.sample_every}
        given = None if scene.time_step is None else {"mps:timeStep": scene.time_step}
        limits = given or {**body_step_limits(scene), **rows}
    return TimeStep(
        length=clock.dt,
        stable=clock.dt_limit,
        limits=limits,
        limited_by=min(limits, key=lambda cause: limits[cause]),
        steps=clock.steps,
        implicit=scene.implicit,
    )


def _of_fluids(scene: Scene, particles: Particles, clock: Clock) -> TimeStep:
    limits = step_limits(scene, particles)
    stable = min(limits.values())
    if scene.time_step is not None:
        limits["mps:timeStep"] = scene.time_step
    limits[ROWS] = clock.dt
    length = min(limits.values())
    # a fluid that becomes a little faster than at the start takes a step more between two rows
    faster = min(stable / FASTER, scene.time_step or math.inf)
    implicit = bool(scene.bodies) and takes_implicit_steps(scene)
    substeps = 1
    if scene.bodies and not implicit:
        substeps = max(1, round(length / substep(scene, particles, clock.dt)[0]))
    return TimeStep(
        length=length,
        stable=stable,
        limits=limits,
        limited_by=min(limits, key=lambda cause: limits[cause]),
        steps=clock.steps * max(1, math.ceil(clock.dt / faster - 1e-6)),
        substeps=substeps,
        implicit=implicit,
    )

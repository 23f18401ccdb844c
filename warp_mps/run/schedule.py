"""Time step and schedule of a run: frames and samples fall on whole steps, and observers are called at steps."""

from __future__ import annotations

import math

import numpy as np

from warp_mps.elastic.explicit.time_step import SAFETY, contact_slowing, stable_limit
from warp_mps.elastic.materials.constants import pressure_wave_speed
from warp_mps.errors import InputError
from warp_mps.scene import Scene
from warp_mps.shapes.numbers import is_number

# steps are counted in 32 bits on the device
MOST_STEPS = 2**31 - 1
SMALLEST_STEP = 1e-200
# part of a step by which rounding may shift a time
ROUNDING = 1e-6


class Clock:
    """Time step and schedule of a run.

    Attributes:
        dt: Time step [s]; of fluids, the interval between two samples; in statics, of the load factor.
        steps: Number of steps of the run.
        frame_every: Steps between saved frames.
        sample_every: Steps between rows of probes.csv.
        dt_limit: Largest time step that is stable for small deformations, contact apart [s].

    Raises:
        InputError: The time step is too small for its number type, or there are more steps than can be counted.
    """

    _rate: float | None

    def __init__(self, scene: Scene) -> None:
        frame = 1.0 / scene.frame_rate
        samples = max(1, round((scene.sample_rate or scene.frame_rate) / scene.frame_rate))
        if scene.fluids:
            # a step of a run is an interval between two samples, which takes as many steps of the fluid as it needs
            self.dt_limit, self.sample_every, self.dt = math.inf, 1, frame / samples
        elif scene.analysis == "static":
            self._ramp(scene)
            return
        else:
            self._divide(scene, frame, samples)
        self.frame_every = samples * self.sample_every
        self.steps = max(1, math.ceil(_count(scene, scene.duration, self.dt, "duration") - ROUNDING))
        # a quotient has less rounding than a product with dt: frames are at 0.2 s, not at 0.19999999999999998
        given = scene.time_step is not None and not scene.fluids
        self._rate = None if given else self.frame_every * scene.frame_rate

    def _ramp(self, scene: Scene) -> None:
        """Statics: a step is a load step, each makes a frame, and the time is the load factor."""
        self.dt_limit, self.dt, self._rate = math.inf, 1.0 / scene.load_steps, float(scene.load_steps)
        self.steps = max(1, math.ceil(_count(scene, scene.duration, self.dt, "duration") - ROUNDING))
        self.sample_every = self.frame_every = 1

    def _divide(self, scene: Scene, frame: float, samples: int) -> None:
        """Find the time step of elastic bodies: a whole number of steps fits between two samples."""
        self.dt_limit = math.inf if scene.implicit else stable_limit(scene)
        if scene.time_step is None:
            step = min(body_step_limits(scene).values())
            self.sample_every = max(1, math.ceil(_count(scene, frame / samples, step, "frame_rate")))
            self.dt = frame / (samples * self.sample_every)
        else:
            self.sample_every = max(1, round(_count(scene, frame / samples, scene.time_step, "time_step")))
            self.dt = scene.time_step

    def time(self, step: int) -> float:
        """Time after so many steps [s]."""
        return step / self._rate if self._rate else step * self.dt

    def first_step_at(self, time: float) -> int:
        """Number of steps after which the time is first at or beyond a time [s], but for rounding."""
        return max(0, math.ceil((time * self._rate if self._rate else time / self.dt) - ROUNDING))


class Trigger:
    """The steps of a run at which an observer is called: the first one, then regularly.

    Args:
        clock: The schedule of the run.
        every: Steps between two calls.
        interval: Simulated time between two calls [s], instead: each is at the first step at or after a multiple of it.

    Raises:
        InputError: The number of steps is below 1, or the time is not finite and above 0.
    """

    def __init__(self, clock: Clock, every: int, interval: float | None = None) -> None:
        if not isinstance(every, int | np.integer) or every < 1:
            raise InputError("observer", "every", f"is {every!r}, must be a whole number of 1 or more steps")
        if interval is not None and not (is_number(interval) and 0.0 < float(interval) < math.inf):
            raise InputError("observer", "interval", f"is {interval!r} s, must be finite and above 0")
        self._clock, self._every, self._interval = clock, every, interval

    def is_due(self, step: int) -> bool:
        """Whether the observer is called after so many steps."""
        return step == 0 or self.next_after(step - 1) == step

    def next_after(self, step: int) -> int:
        """The next step, after so many, at which the observer is called."""
        if self._interval is None:
            return (step // self._every + 1) * self._every
        passed = math.floor(self._clock.time(step) / self._interval + ROUNDING)
        return max(step + 1, self._clock.first_step_at((passed + 1) * self._interval))


def body_step_limits(scene: Scene) -> dict[str, float]:
    """Limits of a time step of elastic bodies that is not given [s], by what sets them.

    Implicit steps keep to the CFL number only.
    """
    waves = [
        (body.spacing / (speed := pressure_wave_speed(material, scene.dimension, scene.plane)), speed, body.name)
        for body in scene.bodies
        for material in body.materials
    ]
    (crossing, speed, name), touching = min(waves, key=lambda wave: wave[0]), contact_slowing(scene)
    cause = f"CFL number {scene.courant:g} at {speed:.4g} m/s, the speed of pressure waves in {name}"
    limits = {cause: scene.courant * (crossing / touching)}
    if not scene.implicit:
        stiff = f" with contact {scene.contact.stiffness:g} times as stiff as the material" if touching > 1.0 else ""
        limits[f"{SAFETY:g} of the largest stable step{stiff}"] = SAFETY * stable_limit(scene)
    return limits


def _count(scene: Scene, interval: float, step: float, attribute: str) -> float:
    """How many steps an interval takes.

    Raises:
        InputError: The step underflows, or there are more steps than a run can count.
    """
    if step < SMALLEST_STEP:
        raise InputError(
            scene.path,
            attribute,
            f"makes a time step of {step:.3g} s, which underflows; it must be at least {SMALLEST_STEP:g} s",
        )
    if interval / step > MOST_STEPS:
        reason = f"makes {interval / step:.3g} steps of {step:.3g} s; at most {MOST_STEPS:.3g} can be counted"
        raise InputError(scene.path, attribute, reason)
    return interval / step

"""A simulation: a scene on a device, its state advanced in time and shown to observers."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_mps.core.interrupts import defer_interrupts
from warp_mps.core.warp_turn import warp_turn
from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, closing
from warp_mps.observers.causes import plain_cause
from warp_mps.observers.guard import find_not_finite
from warp_mps.particles.filling import fill_scene
from warp_mps.run.cost import refuse_too_large
from warp_mps.run.device_arrays import device_arrays
from warp_mps.run.far_scenes import refuse_far_scene
from warp_mps.run.readings import Readings
from warp_mps.run.schedule import Clock, Trigger
from warp_mps.run.steps import PacedSteps, ReplayedSteps, Steps, ThreadedSteps, require_threads
from warp_mps.run.system import PacedSystem, System
from warp_mps.run.system_factory import make_system
from warp_mps.scene import Scene
from warp_mps.scene.choices import PRECISIONS, PrecisionName
from warp_mps.shapes.numbers import is_number

if TYPE_CHECKING:
    import warp as wp

    from warp_mps.elastic.system import ElasticSystem
    from warp_mps.fluid.fluids import Fluids


def require_scene(scene: object) -> None:
    """Refuse anything but a scene, such as the name of a case.

    Raises:
        InputError: It is not a scene.
    """
    if not isinstance(scene, Scene):
        reason = f"is {scene!r}, must be a Scene; read_stage gives that of a stage or of a shipped case"
        raise InputError("", "scene", reason)


class Simulation(Readings):
    """A scene on a device, at one moment of its run.

    ``Simulation(scene).run()`` computes the scene; `advance` and `step_to` do so by hand. Quantities of the present
    moment (`positions`, `energy`, ...) are NumPy arrays; observers see the same, by `warp_mps.observers.base.View`.
    `device_arrays` are those that the kernels work on, without a copy.

    Attributes:
        scene: The case.
        precision: ``float64`` or ``float32``.
        clock: Time step and schedule.
        particles: The particles in their reference configuration.
        step: Number of steps done.

    Args:
        scene: The case.
        device: ``cpu``, or a CUDA device such as ``cuda:0``.
        precision: ``float64`` or ``float32``.
        graphs: Whether steps are replayed as graphs; else every kernel is launched by itself, with the same result.
        threads: Threads of the CPU device that share the particles, with the same result; worth it from some
            thousands on.
        announce: Called with a message when kernels have to be compiled first.

    Raises:
        InputError: The scene's bodies, supports, loads or domain do not fit its particles, or there is no such device
            or precision, or the device takes no threads.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        device: str = "cpu",
        precision: PrecisionName = "float64",
        graphs: bool = True,
        threads: int = 1,
        announce: Callable[[str], None] | None = None,
    ) -> None:
        # Warp is imported with the first simulation, not with the package
        from warp_mps.core.device import open_device
        from warp_mps.core.types import numeric_types

        require_scene(scene)
        if precision not in PRECISIONS:
            raise InputError("", "precision", f"is {precision!r}, must be one of: {', '.join(PRECISIONS)}")
        with warp_turn:
            self._device = open_device(device)
        require_threads(threads, scene, "" if self._device.is_cpu else device)
        if self._device.is_cpu:
            refuse_too_large(scene)
        else:
            refuse_too_large(scene, available=float(self._device.free_memory), memory="GPU memory")
        self.scene, self.precision, self.step = scene, precision, 0
        self.clock, particles = Clock(scene), fill_scene(scene)
        refuse_far_scene(scene, particles, precision)
        with warp_turn:
            options: dict[str, Any] = {"types": numeric_types(scene.dimension, precision), "device": self._device}
            made = make_system(scene, particles, self.clock, graphs=graphs, announce=announce, **options)
            super().__init__(particles, made)
            self._system: System = made
            self._system.start()
            self._paced: PacedSystem | None = made if scene.fluids or scene.implicit else None
            self._steps = self._make_steps(graphs, threads)
        for array in vars(particles).values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False  # observers share it
        self._observed = False

    def _make_steps(self, graphs: bool, threads: int) -> Steps:
        if self._paced:
            return PacedSteps(self._paced, self.clock)
        from warp_mps.elastic.explicit.solid import Solid

        assert isinstance(self._system, Solid)
        if threads > 1:
            return ThreadedSteps(self._system, self.particles.elastic, self._device, threads)
        return ReplayedSteps(self._system, self._device, graphs=graphs)

    @property
    def system(self) -> System:
        """The elastic bodies of the scene, its fluids, or both in strong coupling."""
        return self._system

    @property
    def solid(self) -> ElasticSystem:
        """The elastic bodies.

        Raises:
            TypeError: The scene has none.
        """
        from warp_mps.elastic.system import ElasticSystem

        made = getattr(self._system, "solid", self._system)
        if not isinstance(made, ElasticSystem):
            raise TypeError(f"the scene {self.scene.name!r} has no elastic bodies")
        return made

    @property
    def fluids(self) -> Fluids:
        """The fluids.

        Raises:
            TypeError: The scene has none.
        """
        from warp_mps.fluid.fluids import Fluids

        made = getattr(self._system, "fluids", self._system)
        if not isinstance(made, Fluids):
            raise TypeError(f"the scene {self.scene.name!r} has no fluids")
        return made

    @property
    def device(self) -> str:
        """Name of the device."""
        return str(self._device)

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return self.clock.dt

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time(self.step)

    @property
    def total_steps(self) -> int:
        """Number of steps of the whole run."""
        return self.clock.steps

    @property
    def steps_done(self) -> int:
        """Number of time steps done; of fluids, those within the steps of the run."""
        with warp_turn:
            return int(self.fluids.state.steps.numpy()[0]) if self.scene.fluids else self.step

    @property
    def longest_step(self) -> tuple[float, float]:
        """The longest time step that may be taken, and the stability limit [s]."""
        if self.scene.fluids:
            limit = self.fluids.model.step_limit
            return min(self.scene.time_step or limit, limit), limit
        return self.clock.dt, self.clock.dt_limit

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of the solvers, by the field of `warp_mps.results.summary.RunSummary` that holds them."""
        with warp_turn:
            return self._paced.record() if self._paced else {}

    def advance(self, steps: int) -> None:
        """Advance by a number of steps of the run, each of `dt`; of fluids, of so many intervals between two samples.

        An interrupt (Ctrl-C) takes effect between two blocks of steps, so that `step` is that of the state.

        Raises:
            InputError: The number is not a whole number of 0 or more.
            RunError: A step, or an equilibrium, could not be solved, or a fluid particle is too fast.
            RuntimeError: An earlier failure within a step has ended the threads; `restore` starts new ones.
        """
        if not isinstance(steps, int | np.integer) or steps < 0:
            raise InputError("", "steps", f"is {steps!r}, must be a whole number of at least 0")
        self._refuse_while_observed()
        self.forget()
        block = self._steps.block
        blocks, rest = divmod(steps, block)
        for count in itertools.chain(itertools.repeat(block, blocks), itertools.repeat(1, rest)):
            with defer_interrupts(), warp_turn:
                self._steps.take(self.step, count)
                self.step += count

    def step_to(self, time: float) -> None:
        """Advance to the first step of the run at or after a time [s], also beyond the scene's duration.

        Raises:
            InputError: The time is not finite, or it has passed.
            RunError: As `advance`.
        """
        last = self.clock.first_step_at(time) if is_number(time) and np.isfinite(float(time)) else -1
        if last < self.step:
            raise InputError("", "time", f"is {time!r} s, must be finite and not before {self.time:.6g} s")
        self.advance(last - self.step)

    @property
    def device_arrays(self) -> Mapping[str, wp.array]:
        """Arrays that the kernels work on, without a copy, by name; see `warp_mps.run.device_arrays`."""
        return device_arrays(self.solid if self.scene.bodies else None, self.fluids if self.scene.fluids else None)

    def synchronize(self) -> None:
        """Wait until the device has finished all launches."""
        import warp as wp

        with warp_turn:
            wp.synchronize_device(self._device)

    def run(self, observers: Sequence[Observer] = ()) -> None:
        """Advance to the end, showing the run to observers on the way; they are closed whatever happens.

        Raises:
            RunError: The run cannot go on, as the simulation or an observer has found, or its end is not finite.
        """
        with closing(observers):
            triggers = [Trigger(self.clock, observer.every, observer.interval) for observer in observers]
            self._show(observers, triggers)
            while self.step < self.total_steps:
                due = min((trigger.next_after(self.step) for trigger in triggers), default=self.total_steps)
                try:
                    self.advance(min(due, self.total_steps) - self.step)
                except RunError as error:
                    raise RunError(self._explained(str(error))) from error
                self._show(observers, triggers)
            if (found := find_not_finite(self)) is not None:
                raise RunError(self._explained(found))

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, as host copies; `restore` continues from them to the same bits."""
        with warp_turn:
            return {"step": np.array(self.step), **{name: np.array(a) for name, a in self._system.arrays().items()}}

    def restore(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `state_arrays` gave in a simulation of the same scene."""
        self._refuse_while_observed()
        with warp_turn:
            self._steps.reopen()
            self.forget()
            self._system.assign(arrays)
            self.step = int(arrays["step"])

    def _show(self, observers: Sequence[Observer], triggers: Sequence[Trigger]) -> None:
        # before the observers, so that no invalid state is recorded
        with warp_turn:
            trouble = self._system.trouble()
        if trouble is not None:
            raise RunError(self._explained(f"at t = {self.time:.6g} s: {trouble}"))
        last = self.step == self.total_steps
        self._observed = True
        try:
            for observer, trigger in zip(observers, triggers, strict=True):
                if last or trigger.is_due(self.step):
                    observer.observe(self)
        finally:
            self._observed = False

    def _explained(self, failure: str) -> str:
        """A failure, with the cause if there is a plain one."""
        longest, limit = self.longest_step
        cause = plain_cause(self, time_step=longest, limit=limit)
        return f"{failure}; {cause}" if cause else failure

    def _refuse_while_observed(self) -> None:
        if self._observed:
            raise RuntimeError("an observer may look at a run, but not advance or restore it")

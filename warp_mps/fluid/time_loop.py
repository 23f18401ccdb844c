"""The time loop of fluids: as many steps from one sample to the next as the fastest particle asks for."""

from __future__ import annotations

from collections.abc import Callable

from warp_mps.errors import RunError
from warp_mps.fluid.step import FluidStep

# steps after which the particles are sorted by cells
SORT_EVERY = 100


class TimeLoop:
    """Advances fluids to given times.

    Args:
        step: The step of the fluids.
        take_step: Takes one step towards the target time; by default the fluids alone.
        find_failure: Says why no further step makes sense, or None, from the number of steps left.
    """

    def __init__(
        self,
        step: FluidStep,
        *,
        find_failure: Callable[[int], str | None],
        take_step: Callable[[], None] | None = None,
    ) -> None:
        self._step, self._find_failure, self._take_step = step, find_failure, take_step or step.take

    def advance(self, time: float) -> int:
        """Advance to a time [s], and return the number of steps that it took.

        Raises:
            RunError: A particle is so fast that the time would take more steps than can be waited for, or an equation
                was not solved for too many steps in a row.
        """
        step, state = self._step, self._step.state
        before = state.now
        step.time_step.set_target(time)
        state.impulse.zero_()
        if step.body_forces:
            step.body_forces.begin_interval()
        first = int(state.steps.numpy()[0])
        state.u_before, state.interval = state.in_scene_order(state.u), time - before
        step.grow_neighbours()
        while True:
            self._take_step()
            step.grow_neighbours()
            left = int(step.time_step.steps_left.numpy()[0])
            if (failure := self._find_failure(left)) is not None:
                raise RunError(f"at t = {state.now:.6g} s: {failure}")
            if left <= 1:
                break
        steps = int(state.steps.numpy()[0])
        state.forces.assign(state.impulse.numpy() / state.interval)
        if step.body_forces:
            step.body_forces.end_interval(state.interval)
        if steps // SORT_EVERY > first // SORT_EVERY:
            step.sort_particles()
        return steps - first

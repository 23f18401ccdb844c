"""The time step of fluids, found on the device from the speed of the fastest particle (the CFL condition)."""

from __future__ import annotations

import warp as wp

from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.state import FluidState

# particles that one thread goes through when a maximum is sought
CHUNK = 512


class AdaptiveTimeStep:
    """Divides the time up to a target into equal steps that are as long as the CFL number allows.

    Attributes:
        dt: Time step [s], float64 [1].
        displacement: Displacement of the fastest particle in it [m], float64 [1].
        steps_left: Number of steps of this length up to the target, this one included, int32 [1].
        end: Time at the end of the step [s], float64 [1].
        middle: Time at its midpoint [s], float64 [1].
        target: Time that steps go towards [s], float64 [1].
        longest: Longest time step [s].

    Args:
        model: Constants of the run.
        state: State of the fluid.
    """

    def __init__(self, model: FluidModel, state: FluidState) -> None:
        self._model, self._state, self._kernels = model, state, fluid_kernels(model.types)
        device = model.device
        self.dt, self.displacement, self.target, self.end, self.middle = (
            wp.zeros(1, dtype=wp.float64, device=device) for _ in range(5)
        )
        self.steps_left = wp.zeros(1, dtype=wp.int32, device=device)
        self.longest = model.longest_step
        self._speeds = wp.zeros(-(-len(state.u) // CHUNK), dtype=model.types.real, device=device)

    def set_target(self, time: float) -> None:
        """Set the time that steps go towards [s]."""
        self.target.assign([time])

    def choose(self) -> None:
        """Launch the choice of the next step: dt = min(longest, C l0 / max |u|), and equal steps up to the target."""
        model, state = self._model, self._state
        model.launch(self._kernels.square_speeds, len(self._speeds), [CHUNK, state.u], [self._speeds])
        inputs = [self.longest, model.courant * model.spacing, self._speeds, self.target, state.time]
        outputs = [self.dt, self.displacement, self.steps_left, self.end, self.middle]
        model.launch(self._kernels.choose_time_step, 1, inputs, outputs)

    def replace(self, dt: float, steps_left: int) -> float:
        """Take another step instead of the chosen one, and return the time at its end [s].

        Args:
            dt: Its length [s].
            steps_left: Number of steps of this length up to the target.
        """
        self.displacement.assign(self.displacement.numpy() * (dt / float(self.dt.numpy()[0])))
        self.dt.assign([dt])
        self.steps_left.assign([steps_left])
        end = float(self.target.numpy()[0]) if steps_left == 1 else self._state.now + dt
        self.end.assign([end])
        self.middle.assign([self._state.now + 0.5 * dt])
        return end

    def advance_clock(self) -> None:
        """Launch the end of the step: the state's time becomes `end`, and its steps one more."""
        self._model.launch(self._kernels.advance_clock, 1, [self.end], [self._state.time, self._state.steps])

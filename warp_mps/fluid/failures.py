"""Detection of failures of a run of fluids: why no further step makes sense, and at which particle."""

from __future__ import annotations

import math

import numpy as np

from warp_mps.core.counters import whole_numbers
from warp_mps.fluid.step import FluidStep

# share of the fluid that may leave the domain
LARGEST_LOSS = 0.01
# in units of the speed that the longest step is for, and of the walls': a particle that is faster has run away, and the
# time step collapses with it
LARGEST_SPEED = 1000.0
# steps in a row after which an equation that stays unsolved ends the run: in a splash a few solves may fail
MOST_UNSOLVED = 10


class FluidFailures:
    """Finds failures: crowded neighbour lists, leaks, runaway particles, and equations that are not solved.

    Args:
        step: The step of the fluids.
    """

    def __init__(self, step: FluidStep) -> None:
        self._step, self._model, self._state = step, step.model, step.state
        # solves that had failed before the last step, and steps in a row that added to them
        self._failed = self._unsolved = 0

    def state(self) -> np.ndarray:
        """Solves that had failed, and steps in a row that added to them, for a checkpoint, shape [2]."""
        return np.array([self._failed, self._unsolved], float)

    def assign(self, state: np.ndarray) -> None:
        """Continue from what `state` returned.

        Raises:
            ValueError: A counter is no whole number of 0 or more.
        """
        self._failed, self._unsolved = whole_numbers(state)

    def trouble(self) -> str | None:
        """Why the run cannot go on, if it cannot."""
        return self._find_overflow() or self._find_leak()

    def after_step(self, left: int) -> str | None:
        """Why no further step makes sense, if none does; to be asked once after every step.

        Args:
            left: Steps that are left up to the time that they go towards.
        """
        if (trouble := self._find_overflow() or self._find_unsolved()) is not None:
            return trouble
        if left > LARGEST_SPEED * max(self._state.interval / self._step.time_step.longest, 1.0):
            return self.find_runaway()
        return None

    def find_runaway(self) -> str | None:
        """Which particle makes the time step collapse, if one does."""
        speeds, w = np.linalg.norm(self._state.u.numpy().astype(float), axis=1), self._model.walls
        k = w + int(np.argmax(speeds[w:]))
        usual = max(
            self._model.courant * self._model.spacing / self._step.time_step.longest, speeds[:w].max(initial=0.0)
        )
        if speeds[k] <= LARGEST_SPEED * usual:
            return None
        return f"{self._describe_speed(k)}: it runs away, the flow has collapsed there, and time steps with it"

    def describe_fastest(self) -> str:
        """The fastest particle of all, and how fast it is."""
        return self._describe_speed(int(np.argmax(np.abs(self._state.u.numpy()).max(axis=1))))

    def describe(self, place: int) -> str:
        """The particle at a place in the arrays, and where it is."""
        return f"{self.name(place)} at ({', '.join(f'{c:.4g}' for c in self._state.x.numpy()[place])}) m"

    def name(self, place: int) -> str:
        """The particle at a place in the arrays."""
        w = self._model.walls
        return self._model.particles.describe(int(place if place < w else w + self._state.order.numpy()[place - w]))

    def _describe_speed(self, place: int) -> str:
        # the squares of very large velocities overflow
        speed = math.hypot(*self._state.u.numpy()[place].astype(float))
        return f"{self.describe(place)} moves at {speed:.4g} m/s"

    def _find_overflow(self) -> str | None:
        """Where more particles crowd than neighbour lists may have room for, if they do."""
        lists = self._step.neighbours
        if lists.can_grow or (particle := lists.overflowed()) is None:
            return None
        middle = self.describe(particle)
        return f"more particles crowd about {middle} than a neighbour list holds: the flow has collapsed there"

    def _find_leak(self) -> str | None:
        """A particle that has left the domain, if too many have, or that has a position which is not finite."""
        w = self._model.walls
        lost = w + np.flatnonzero(self._state.lost.numpy()[w:])
        wrong = lost[~np.isfinite(self._state.x.numpy()[lost]).all(axis=1)]
        if len(wrong):
            return f"the position of {self.name(wrong[0])} is not finite: the flow has collapsed there"
        if len(lost) <= LARGEST_LOSS * self._model.count:
            return None
        return f"{len(lost)} of {self._model.count} fluid particles have left the domain{self._describe_exits(lost)}"

    def _describe_exits(self, lost: np.ndarray) -> str:
        """By which ends of the domain particles left it, and what would keep them, as an end of a sentence."""
        model, x = self._model, self._state.x.numpy()[lost].astype(float)
        exits = []
        for axis, letter in enumerate(model.axes):
            for name, beyond in (("low", x[:, axis] < model.low[axis]), ("high", x[:, axis] > model.high[axis])):
                if beyond.any():
                    first = self.describe(lost[np.argmax(beyond)])
                    exits.append(f"{beyond.sum()} at its {name} {letter} end, as {first}")
        remedy = "close the tank on that side, or give flow.domain (mps:domainLow, mps:domainHigh) more room there"
        return f": {'; '.join(exits)}: {remedy}"

    def _find_unsolved(self) -> str | None:
        """Count the steps in a row in which an equation was not solved, and say where, once they are too many."""
        failed = self._step.count_unsolved()
        self._unsolved = self._unsolved + 1 if failed > self._failed else 0
        self._failed = failed
        if self._unsolved < MOST_UNSOLVED:
            return None
        name, solver = max(self._step.solvers.items(), key=lambda item: item[1].count_unsolved())
        worst = self.describe(self._model.walls + solver.worst_row())
        residual = f"{solver.read_statistics().last_residual:.3g} of its right-hand side (asked: {solver.tolerance:g})"
        return (
            f"the equation of the {name} was not solved in {self._unsolved} steps in a row: its residual is {residual},"
            f" and largest at {worst}"
        )

"""What ends a run of fluids: why no further step makes sense, and at which particle."""

import math

import numpy as np

from warp_mps.fluid.readings import FluidReadings

# share of the fluid that may leave the domain
LARGEST_LOSS = 0.01
# times the speed that the longest step is for, and the walls': what is faster has run away, and steps collapse with it
LARGEST_SPEED = 1000.0
# steps in a row after which an equation that stays unsolved ends the run: a splash may fail one, and is soon over
MOST_UNSOLVED = 10


class FluidFailures(FluidReadings):
    """The failures of `warp_mps.fluid.fluids.Fluids`, which owns what they look at."""

    # solves that had failed before the last step, and steps in a row that added to them
    _failed = 0
    _unsolved = 0

    def trouble(self) -> str | None:
        """Why the run cannot go on, if it cannot."""
        return self._crowd() or (self._leak() if self.lost() else None)

    def failure(self, left: int) -> str | None:
        """Why no further step makes sense, if none does.

        Args:
            left: Steps that are left up to the time that they go towards.
        """
        if (trouble := self._crowd() or self._stuck()) is not None:
            return trouble
        if left > LARGEST_SPEED * max(self._interval / self._longest, 1.0):
            return self.runaway()
        return None

    def runaway(self) -> str | None:
        """Which particle makes the steps collapse, if one does."""
        speeds, w = np.linalg.norm(self.state.u.numpy().astype(float), axis=1), self._walls
        k = w + int(np.argmax(speeds[w:]))
        usual = max(self._courant * self._spacing / self._longest, speeds[:w].max(initial=0.0))
        if speeds[k] <= LARGEST_SPEED * usual:
            return None
        return f"{self._moving(k)}: it runs away, the flow has collapsed there, and time steps with it"

    def fastest(self) -> str:
        """The fastest particle of all, and how fast it is."""
        return self._moving(int(np.argmax(np.abs(self.state.u.numpy()).max(axis=1))))

    def _crowd(self) -> str | None:
        """Where more particles crowd than neighbour lists may have room for, if they do."""
        if self.lists.can_grow or (particle := self.lists.overflowed()) is None:
            return None
        middle = f"{self._which(particle)} at {self._where(particle)}"
        return f"more particles crowd about {middle} than a neighbour list holds: the flow has collapsed there"

    def _leak(self) -> str | None:
        """Which particle has left the domain, if too many have, or one whose place is no number."""
        lost = self._walls + np.flatnonzero(self.state.lost.numpy()[self._walls :])
        wrong = lost[~np.isfinite(self.state.x.numpy()[lost]).all(axis=1)]
        if len(wrong):
            return f"the position of {self._which(wrong[0])} is not finite: the flow has collapsed there"
        if len(lost) <= LARGEST_LOSS * self._m:
            return None
        first = f"{self._which(lost[0])} at {self._where(lost[0])}"
        return f"{len(lost)} of {self._m} fluid particles have left the domain, as {first}: there is a leak"

    def _stuck(self) -> str | None:
        """Count the steps in a row in which an equation was not solved, and say where, once they are too many."""
        failed = self._unsolved_solves()
        self._unsolved = self._unsolved + 1 if failed > self._failed else 0
        self._failed = failed
        if self._unsolved < MOST_UNSOLVED:
            return None
        name, solver = max(self.solvers.items(), key=lambda item: item[1].count_unsolved())
        k = self._walls + solver.worst_row()
        residual = f"{solver.read_statistics().last_residual:.3g} of its right-hand side (asked: {solver.tolerance:g})"
        return (
            f"the equation of the {name} was not solved in {self._unsolved} steps in a row: its residual is {residual},"
            f" and largest at {self._which(k)} at {self._where(k)}"
        )

    def _which(self, place: int) -> str:
        """The particle at a place in the arrays."""
        w = self._walls
        return self._particles.describe(int(place if place < w else w + self.state.order.numpy()[place - w]))

    def _moving(self, place: int) -> str:
        # squares of what has exploded would be no numbers any more
        speed = math.hypot(*self.state.u.numpy()[place].astype(float))
        return f"{self._which(place)} at {self._where(place)} moves at {speed:.4g} m/s"

    def _where(self, place: int) -> str:
        """Where the particle at a place in the arrays is."""
        return f"({', '.join(f'{c:.4g}' for c in self.state.x.numpy()[place])}) m"

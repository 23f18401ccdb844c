"""How elastic bodies answer to pressure in a step, for the pressure equation to know about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.kit import Kit
from warp_mps.coupling.markers import Markers

# steps after which it is measured anew, passes of a step that ask for it, and relative change of the step that does
STEPS, PASSES, CHANGE = 100, 8, 0.25
# of the forces that act: a part of them that is small and far above rounding
PROBED = 0.1
# of a free particle's mobility: a body that does not give at all must not make the equation blind
LEAST = 1e-3


class Mobility:
    """Acceleration per force of the markers of each body, under a pressure that is uniform over what of it is wet.

    A value too large costs passes; one that is some times too small lets the iteration diverge.

    Attributes:
        array: Mobility of each marker [1/kg], real [markers].

    Args:
        markers: The markers.
        kit: Number types.
        device: Warp device.
    """

    def __init__(self, markers: Markers, *, kit: Kit, device: Any) -> None:
        self._bodies, self._free = markers.bodies, 1.0 / markers.masses
        self.array = wp.array(self._free, dtype=kit.real, device=device)
        self._dt = 0.0
        self._steps = STEPS

    def due(self, dt: float) -> bool:
        """Count a step of a length [s], and say whether it should begin with a measurement."""
        self._steps += 1
        if self._steps > STEPS or abs(dt - self._dt) > CHANGE * self._dt:
            self._dt, self._steps = dt, 1
            return True
        return False

    def heed(self, passes: int) -> None:
        """Look at how many passes a step took."""
        if passes > PASSES:
            self._steps = STEPS

    def measure(self, answer: Callable[[np.ndarray], np.ndarray], uniform: np.ndarray, forces: np.ndarray) -> None:
        """Measure it.

        Args:
            answer: Gives the accelerations of the markers under forces [m/s^2], shapes [markers, d].
            uniform: Forces of a uniform pressure, of any size [N], shape [markers, d].
            forces: Forces that act [N], shape [markers, d].
        """
        norm = float(np.linalg.norm(uniform))
        if norm == 0.0:  # nothing is wet
            return
        weight = float(np.linalg.norm(1.0 / self._free))
        more = (PROBED * (float(np.linalg.norm(forces)) or weight) / norm) * uniform
        change = answer(forces + more) - answer(forces)
        count = self._bodies.max() + 1
        work = np.bincount(self._bodies, np.sum(change * more, axis=1), count)
        square = np.bincount(self._bodies, np.sum(more**2, axis=1), count)
        mean = np.divide(work, square, out=np.full(count, np.inf), where=square > 0.0)[self._bodies]
        self.array.assign(np.clip(mean, LEAST * self._free, self._free))

    def arrays(self) -> dict[str, np.ndarray]:
        """What evolves, for a checkpoint."""
        return {"mobility": self.array.numpy().copy(), "mobility_step": np.array([self._dt, self._steps])}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.array.assign(arrays["mobility"])
        self._dt, self._steps = float(arrays["mobility_step"][0]), int(arrays["mobility_step"][1])

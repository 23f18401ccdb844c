"""How elastic bodies answer to pressure in a step, for the pressure equation to know about."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.interface import Markers

# steps after which it is measured anew, passes of a step that ask for it, and relative change of the step that does
STEPS, PASSES, CHANGE = 100, 8, 0.25
# of the forces that act: a part of them that is small and far above rounding
PROBED = 0.1
# of a free particle's mobility: a body that does not give at all must not make the equation blind
LEAST = 1e-3


class Mobility:
    """Acceleration per force of the markers of each body, under the pressures that move it most.

    A value too large costs passes; one that is some times too small lets the iteration diverge. A uniform pressure
    bends a plate that is wet on one side, but only squeezes a body that is in the midst of the water: what moves that
    are pressures that grow along an axis.

    Attributes:
        array: Mobility of each marker [1/kg], real [markers].

    Args:
        markers: The markers.
        types: Number types.
        device: Warp device.
    """

    def __init__(self, markers: Markers, *, types: NumericTypes, device: Any) -> None:
        self._bodies, self._free = markers.bodies, 1.0 / markers.masses
        self.array = wp.array(self._free, dtype=types.real, device=device)
        self._dt = 0.0
        self._steps = STEPS

    def is_due(self, dt: float) -> bool:
        """Count a step of a length [s], and say whether it should begin with a measurement."""
        self._steps += 1
        if self._steps > STEPS or abs(dt - self._dt) > CHANGE * self._dt:
            self._dt, self._steps = dt, 1
            return True
        return False

    def note_passes(self, passes: int) -> None:
        """Measure at the next step if a step took too many passes."""
        if passes > PASSES:
            self._steps = STEPS

    def measure(
        self, answer: Callable[[np.ndarray], np.ndarray], patterns: Sequence[np.ndarray], forces: np.ndarray
    ) -> None:
        """Measure it: for each body, the largest that it shows under any of some patterns of force.

        Args:
            answer: Gives the accelerations of the markers under forces [m/s^2], shapes [markers, d].
            patterns: Forces of some pressures, of any size, that of a uniform one first [N], shapes [markers, d].
            forces: Forces that act [N], shape [markers, d].
        """
        whole = float(np.linalg.norm(forces)) or float(np.linalg.norm(1.0 / self._free))
        at_rest, known = answer(forces), list[np.ndarray]()
        # what is dry has the mobility of its markers
        found = np.where(self._sum(patterns[0], patterns[0]) > 0.0, 0.0, np.inf)
        for pattern in patterns:
            own = pattern.copy()
            for other in known:
                own -= self._ratio(own, other)[self._bodies, None] * other
            if (norm := float(np.linalg.norm(own))) == 0.0:
                continue
            known.append(own)
            more = (PROBED * whole / norm) * own
            found = np.maximum(found, self._ratio(answer(forces + more) - at_rest, more))
        self.array.assign(np.clip(found[self._bodies], LEAST * self._free, self._free))

    def _sum(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Products of vectors on the markers of each body together, shape [bodies]."""
        return np.bincount(self._bodies, np.sum(a * b, axis=1), self._bodies.max() + 1)

    def _ratio(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """How much of b there is in a, body by body; 0 where there is no b, shape [bodies]."""
        square = self._sum(b, b)
        return np.divide(self._sum(a, b), square, out=np.zeros(len(square)), where=square > 0.0)

    def arrays(self) -> dict[str, np.ndarray]:
        """What evolves, for a checkpoint."""
        return {"mobility": self.array.numpy().copy(), "mobility_step": np.array([self._dt, self._steps])}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.array.assign(arrays["mobility"])
        self._dt, self._steps = float(arrays["mobility_step"][0]), int(arrays["mobility_step"][1])

"""Mobility of the markers: the response of elastic bodies to pressure in a step, for the Robin term.

It is the inverse of the mass that pressures feel, and what the added mass of the fluid is weighed against.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.interface import Markers

# it is measured again after so many steps, after a step of more passes, and when the time step has changed by this part
STEPS, PASSES, CHANGE = 100, 8, 0.25
# probing forces in units of those that act: small, and far above rounding
PROBED = 0.1
# lower bound, in units of a free marker's mobility: also for a body that does not move at all
LEAST = 1e-3


class Mobility:
    """Acceleration per force of the markers of each body, under the pressures that move it most.

    A value that is too large costs passes; one that is several times too small lets the passes diverge. A uniform
    pressure bends a plate that is wet on one side, but only compresses a body that is surrounded by fluid: pressures
    that grow along an axis move such a body.

    Attributes:
        array: Mobility b of each marker [1/kg], real [e].

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
        """Count a step of a length [s], and return whether it should begin with a measurement."""
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
        """Measure the mobility of each body: the largest under any of some patterns of force.

        Args:
            answer: Gives the accelerations of the markers under forces [m/s^2], shapes [e, d].
            patterns: Forces of some pressures, of any size, that of a uniform one first [N], shapes [e, d].
            forces: Forces that act [N], shape [e, d].
        """
        whole = float(np.linalg.norm(forces)) or float(np.linalg.norm(1.0 / self._free))
        at_rest, known = answer(forces), list[np.ndarray]()
        # a dry body has the mobility of free markers
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
        """Scalar products of vectors on the markers of each body, shape [bodies]."""
        return np.bincount(self._bodies, np.sum(a * b, axis=1), self._bodies.max() + 1)

    def _ratio(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Coefficients a . b / b . b of each body, 0 where b is 0, shape [bodies]."""
        square = self._sum(b, b)
        return np.divide(self._sum(a, b), square, out=np.zeros(len(square)), where=square > 0.0)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        return {"mobility": self.array.numpy().copy(), "mobility_step": np.array([self._dt, self._steps])}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.array.assign(arrays["mobility"])
        self._dt, self._steps = float(arrays["mobility_step"][0]), int(arrays["mobility_step"][1])

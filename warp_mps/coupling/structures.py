"""How the elastic bodies take a step of the water, under a force that is constant in it: implicitly or in sub-steps.

The coupling knows no more of them than this: the state at the end of a step from where it was saved, under `external`.
"""

from __future__ import annotations

import functools
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_mps.core.replay import Replay
from warp_mps.core.snapshot import Snapshot
from warp_mps.core.types import NumericTypes
from warp_mps.coupling.interface_kernels import marker_kernels
from warp_mps.elastic.explicit.solid import Solid
from warp_mps.elastic.implicit.theta_rule import ImplicitSolid
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# residual of an implicit step in passes that are not the last, relative to its forces: far below what passes agree to,
# for what it leaves is noise to them
TRIAL_TOLERANCE = 1e-6


class Structure(Protocol):
    """Elastic bodies under forces of water.

    Attributes:
        external: Forces of the water on their particles, constant over a step [N], vec [n].
    """

    external: wp.array

    @property
    def solid(self) -> Solid:
        """The bodies."""

    def fit(self, dt: float, rest: float) -> tuple[float, int]:
        """The next step that can be taken [s], and how many of it are left, of a wish and the time that is left [s]."""

    def save(self) -> None:
        """Keep the present state: every step starts from it."""

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take the step that `fit` gave, to a time [s], from the state that was kept; as a trial, less exactly.

        Raises:
            RunError: The step could not be solved.
        """

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""


class ImplicitStructure:
    """Bodies that take a step of the water as one of the theta rule.

    Attributes:
        solid: The bodies.
        external: Forces of the water on their particles [N], vec [n].

    Args:
        solid: The bodies.
    """

    def __init__(self, solid: ImplicitSolid) -> None:
        self.solid, self.external = solid, solid.external

    def fit(self, dt: float, rest: float) -> tuple[float, int]:
        """The wish."""
        return dt, max(1, round(rest / dt))

    def save(self) -> None:
        """Keep the present state."""
        self.solid.save()

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take a step."""
        self.solid.restore()
        exact = self.solid.newton.tolerance
        self.solid.advance(time, tolerance=max(TRIAL_TOLERANCE, exact) if trial else exact)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves."""
        return self.solid.arrays()

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.solid.assign(arrays)


class SubsteppedStructure:
    """Bodies that take a step of the water as many explicit steps of one length.

    Attributes:
        solid: The bodies.
        external: Forces of the water on their particles [N], vec [n].
        dt: Time step of the bodies [s].

    Args:
        scene: The case without its fluids.
        particles: Its particles without those of fluids.
        dt: Time step of the bodies [s].
        retardation_time: Of a numerical viscosity, beside that of the materials [s].
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        dt: float,
        retardation_time: float,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
    ) -> None:
        options: dict[str, Any] = {"types": types, "device": device}
        self.solid = Solid(scene, particles, dt=dt, loaded=True, retardation_time=retardation_time, **options)
        assert self.solid.external is not None
        self.external, self.dt = self.solid.external, dt
        self._kernels, self._device = marker_kernels(types), device
        self._replay = Replay(device=device, graphs=graphs)
        # what of the external force the total force holds at present
        self._carried = wp.zeros_like(self.external)
        self._snapshot = Snapshot([*self.solid.evolving(), self._carried])
        self._count = 1

    def fit(self, dt: float, rest: float) -> tuple[float, int]:
        """As many of the bodies' steps as fit into the wish, and at least one."""
        total = max(1, round(rest / self.dt))
        left = -(-total // max(1, int(dt / self.dt * (1.0 + 1e-9))))
        self._count = -(-total // left)
        return self._count * self.dt, left

    def save(self) -> None:
        """Keep the present state."""
        self._replay("save", self._snapshot.save)

    def restore(self) -> None:
        """Return to the state that was kept, the total force of which then holds the present external force."""
        self._replay("restore", self._restore)

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take the sub-steps; the force that the first one starts with is already that of this step."""
        self.restore()
        rest, block = self._count, 1
        # as few graphs as any number of steps needs: one for each power of two
        while rest:
            if rest & 1:
                self._replay(f"{block} steps", functools.partial(self._steps, block))
            rest, block = rest >> 1, block << 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves."""
        return {**self.solid.arrays(), "carried_force": self._carried.numpy().copy()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.solid.assign(arrays)
        for array in (self._carried, self.external):  # what is shown of a moment knows the force of its step
            array.assign(arrays["carried_force"])

    def _restore(self) -> None:
        self._snapshot.restore()
        inputs, outputs = [self.external], [self._carried, self.solid.state.force]
        wp.launch(self._kernels.load, len(self.external), inputs, outputs, device=self._device)

    def _steps(self, count: int) -> None:
        for _ in range(count):
            self.solid.step()

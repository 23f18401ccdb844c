"""The structure solver of the coupling: elastic bodies over a step of the fluid, implicitly or in explicit sub-steps.

The forces of the fluid are constant over the step. The coupling knows no more of the bodies than this: their state at
the end of a step that begins with the saved state, under the forces `external`.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_mps.core.replay import Replay
from warp_mps.core.snapshot import Snapshot
from warp_mps.core.types import NumericTypes
from warp_mps.coupling.interface_kernels import interface_kernels
from warp_mps.elastic.explicit.solid import Solid
from warp_mps.elastic.explicit.step_graphs import take_steps
from warp_mps.elastic.implicit.solid import ImplicitSolid
from warp_mps.elastic.system import ElasticSystem
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# residual of an implicit step in fixed-point passes, relative to its forces: far below the tolerance of the passes, to
# which it is noise
TRIAL_TOLERANCE = 1e-6
# largest residual of an implicit step as a share of the forces that act: a tenth of what the passes converge to
LARGEST_RESIDUAL = 1e-4


class Structure(Protocol):
    """Elastic bodies under forces of the fluid.

    Attributes:
        external: Forces of the fluid on the n particles, constant over a step [N], vec [n].
    """

    external: wp.array

    @property
    def solid(self) -> ElasticSystem:
        """The bodies."""

    def fit_time_step(self, dt: float, rest: float) -> tuple[float, int]:
        """The time step that the bodies can take [s], and the number of such steps left.

        Args:
            dt: Time step that the fluid asks for [s].
            rest: Time that is left [s].
        """

    def save(self) -> None:
        """Save the present state: every pass starts from it."""

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take the step that `fit_time_step` gave, from the saved state.

        Args:
            time: Time at its end [s].
            trial: Whether it is a pass that may be solved less exactly.

        Raises:
            RunError: The step could not be solved.
        """

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""


class ImplicitStructure:
    """Bodies that take a step of the fluid as one step of the theta rule.

    Attributes:
        solid: The bodies.
        external: Forces of the fluid on the n particles [N], vec [n].

    Args:
        solid: The bodies.
    """

    def __init__(self, solid: ImplicitSolid) -> None:
        self.solid, self.external = solid, solid.external

    def fit_time_step(self, dt: float, rest: float) -> tuple[float, int]:
        """The time step that the fluid asks for: the theta rule takes any."""
        return dt, max(1, round(rest / dt))

    def save(self) -> None:
        """Save the present state."""
        self.solid.save()

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take the step from the saved state."""
        self.solid.restore()
        exact = self.solid.newton.tolerance
        self.solid.advance(time, tolerance=max(TRIAL_TOLERANCE, exact) if trial else exact, share=LARGEST_RESIDUAL)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves."""
        return self.solid.arrays()

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.solid.assign(arrays)


class SubsteppedStructure:
    """Bodies that take a step of the fluid as a number of explicit sub-steps of one length.

    Attributes:
        solid: The bodies.
        external: Forces of the fluid on the n particles [N], vec [n].
        dt: Time step of the bodies [s].

    Args:
        scene: The case without its fluids.
        particles: Its particles without those of fluids.
        dt: Time step of the bodies [s].
        retardation_time: Retardation time of a numerical viscosity, beside that of the materials [s].
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
        self._kernels, self._device = interface_kernels(types), device
        self._replay = Replay(device=device, graphs=graphs)
        # external force that the total force includes at present
        self._included = wp.zeros_like(self.external)
        self._snapshot = Snapshot([*self.solid.evolving(), self._included])
        self._count = 1

    def fit_time_step(self, dt: float, rest: float) -> tuple[float, int]:
        """As many sub-steps as fit into the time step that the fluid asks for, and at least one."""
        total = max(1, round(rest / self.dt))
        left = -(-total // max(1, int(dt / self.dt * (1.0 + 1e-9))))
        self._count = -(-total // left)
        return self._count * self.dt, left

    def save(self) -> None:
        """Save the present state."""
        self._replay("save", self._snapshot.save)

    def restore(self) -> None:
        """Return to the saved state, whose total force then includes the present external force."""
        self._replay("restore", self._restore)

    def advance(self, time: float, *, trial: bool = False) -> None:
        """Take the sub-steps from the saved state; the first one starts with the force of this step already."""
        self.restore()
        rest, block = self._count, 1
        # one graph for each power of two makes any number of sub-steps
        while rest:
            if rest & 1:
                take_steps(self.solid, self._replay, block)
            rest, block = rest >> 1, block << 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves."""
        return {**self.solid.arrays(), "carried_force": self._included.numpy().copy()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        self.solid.assign(arrays)
        for array in (self._included, self.external):  # readings between two steps include the force of the last
            array.assign(arrays["carried_force"])

    def _restore(self) -> None:
        self._snapshot.restore()
        inputs, outputs = [self.external], [self._included, self.solid.state.force]
        wp.launch(self._kernels.replace_force, len(self.external), inputs, outputs, device=self._device)

"""The elastic bodies of a scene, advanced by explicit steps: parts, state, step and readings together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.explicit.lagged_damping import LaggedDamping
from warp_mps.elastic.explicit.step import ExplicitStep, Phase
from warp_mps.elastic.parts import SolidParts
from warp_mps.elastic.readings import SolidReadings
from warp_mps.elastic.solid_state import SolidState
from warp_mps.elastic.system import ElasticSystem
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class Solid(ElasticSystem):
    """The elastic bodies of a scene and the walls that they touch, advanced by velocity Verlet.

    Args:
        scene: The case.
        particles: Its particles.
        dt: Time step [s].
        types: Number types.
        device: Warp device.
        loaded: Whether there are external forces beside those of the scene.
        retardation_time: That of a numerical viscosity proportional to the stiffness, whatever the model [s]; 0 for
            none. See `warp_mps.elastic.explicit.lagged_damping`.
    """

    def __init__(
        self,
        scene: Scene,
        particles: Particles,
        *,
        dt: float,
        types: NumericTypes,
        device: Any,
        loaded: bool = False,
        retardation_time: float = 0.0,
    ) -> None:
        parts = SolidParts(scene, particles, dt=dt, types=types, device=device, loaded=loaded)
        lagged = LaggedDamping(parts, retardation_time) if retardation_time else None
        super().__init__(parts, SolidState(parts, lagged), SolidReadings(parts))
        self._step = ExplicitStep(parts, lagged)

    @property
    def phases(self) -> list[Phase]:
        """The phases of a step, in order."""
        return self._step.phases

    def start(self) -> None:
        """Evaluate the forces of the initial state, with which the first step begins."""
        self._step.start()

    def step(self) -> None:
        """Launch one time step."""
        self._step.launch(self.phases)

    def launch(self, phases: Sequence[Phase]) -> None:
        """Launch phases of a step over all particles."""
        self._step.launch(phases)

    def sections(self) -> list[list[Phase]]:
        """The phases of a step in groups: threads must wait for each other between two groups."""
        return self._step.sections()

"""The boundary conditions of a scene on its particles: held axes, moving supports and loads."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.counters import whole_numbers
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.boundary.boundary_kernels import boundary_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.errors import InputError
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import is_clamp, select_held
from warp_mps.scene import HarmonicMotion, Load, Scene, Support, TableMotion
from warp_mps.scene.spline import clamped_slopes
from warp_mps.scene.validation.scene import place


@dataclass(kw_only=True)
class _Action:
    """A moving support or a load on the device.

    Attributes:
        particles: Its particles.
        arguments: Its own arguments of the kernels.
        last: For each particle, of the last step: the displacement of a support [m], or the power of a load [W].
        work: Its work so far on each particle [J].
    """

    particles: wp.array
    arguments: list[Any]
    last: wp.array
    work: wp.array


class BoundaryConditions:
    """Supports and loads of the elastic bodies; gravity and body forces are not among them.

    Attributes:
        held: Whether each axis of each particle is held, shape [n, d].
        held_rotation: Whether the rotation of each particle is held, shape [n].
    """

    def __init__(self, scene: Scene, particles: Particles, *, dt: float, types: NumericTypes, device: Any) -> None:
        self._types, self._device, self._dt = types, device, dt
        self._kernels = boundary_kernels(types)
        self.steps = wp.zeros(1, dtype=wp.int32, device=device)
        # the kernels take a time as a number of steps of dt: here one step of the length t
        self._once = wp.ones(1, dtype=wp.int32, device=device)
        self.held = np.zeros((particles.count, particles.dimension), bool)
        self.held_rotation = np.zeros(particles.count, bool)
        self._driven: list[_Action] = []
        driven = np.zeros_like(self.held)
        for support in scene.supports:
            self._hold(support, particles, driven)
        most = max((len(action.particles) for action in self._driven), default=0)
        self._spare = wp.empty(most, dtype=types.vec, device=device), wp.zeros(most, dtype=wp.float64, device=device)
        self._pushed = [self._load(load, particles) for load in scene.loads]

    @property
    def moving(self) -> bool:
        """Whether anything here depends on time or does work."""
        return bool(self._driven or self._pushed)

    @property
    def supports_move(self) -> bool:
        """Whether any support moves."""
        return bool(self._driven)

    def move_supports(self, state: ElasticState, mass: wp.array) -> None:
        """Impose the motion of the moving supports at the time of the step."""
        for action in self._driven:
            axes, motion = action.arguments[0], action.arguments[1:]
            inputs = [action.particles, axes, self._dt, *motion, mass, self.steps, state.force]
            outputs = [state.u, state.v, state.driven, action.last, action.work]
            self._launch(self._kernels.move_supports, action, inputs, outputs)

    def supports_at(self, u: wp.array, v: wp.array, acceleration: wp.array, mass: wp.array, time: float) -> None:
        """Write displacements, velocities and accelerations of the moving supports at a time [s]; no work is added."""
        for action in self._driven:
            axes, motion = action.arguments[0], action.arguments[1:]
            inputs = [action.particles, axes, time, *motion, mass, self._once, acceleration]
            # the work that the kernel adds is discarded
            spare = [self._spare[0][: len(action.last)], self._spare[1][: len(action.work)]]
            self._launch(self._kernels.move_supports, action, inputs, [u, v, acceleration, *spare])

    def add_loads(self, force: wp.array, mass: wp.array, time: float | None = None) -> None:
        """Add the loads to the forces on the particles: those of the present step, or of a time [s]."""
        dt, steps = (self._dt, self.steps) if time is None else (time, self._once)
        for action in self._pushed:
            inputs = [action.particles, dt, *action.arguments, mass, steps]
            self._launch(self._kernels.add_loads, action, inputs, [force])

    def add_work(self, state: ElasticState, mass: wp.array, dt: float) -> None:
        """Add the work of a step; with dt = 0 only store the power, which the next step needs."""
        for action in self._driven:
            self._launch(
                self._kernels.support_work, action, [action.particles, state.force, action.last], [action.work]
            )
        for action in self._pushed:
            # the load's value needs the time, so this kernel takes the true time step as well
            inputs = [action.particles, self._dt, dt, *action.arguments, mass, self.steps, state.v]
            self._launch(self._kernels.load_work, action, inputs, [action.last, action.work])

    def work(self) -> float:
        """Work done so far [J]."""
        return float(sum(np.sum(action.work.numpy()) for action in self._actions()))

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves."""
        return [self.steps, *(array for action in self._actions() for array in (action.last, action.work))]

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name, for a checkpoint."""
        arrays = {"steps": self.steps.numpy().copy()}
        for k, action in enumerate(self._actions()):
            arrays[f"last_{k}"] = action.last.numpy().copy()
            arrays[f"work_{k}"] = action.work.numpy().copy()
        return arrays

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave.

        Raises:
            ValueError: The number of steps is below 0.
        """
        whole_numbers(arrays["steps"])
        self.steps.assign(arrays["steps"])
        for k, action in enumerate(self._actions()):
            action.last.assign(arrays[f"last_{k}"])
            action.work.assign(arrays[f"work_{k}"])

    def _actions(self) -> list[_Action]:
        return [*self._driven, *self._pushed]

    def _hold(self, support: Support, particles: Particles, driven: np.ndarray) -> None:
        found = select_held(particles, support)
        axes = np.array(sorted(support.axes) or range(particles.dimension))
        here = np.ix_(found, axes)
        if driven[here].any() or (support.motion is not None and self.held[here].any()):
            reason = "holds particles along an axis along which another support moves or holds them"
            raise InputError(place(support, "support"), "motion", reason)
        self.held[here] = True
        self.held_rotation[found] |= support.hold_rotation or is_clamp(support, particles.dimension)
        if support.motion is None:
            return
        driven[here] = True
        mask = np.zeros(particles.dimension)
        mask[axes] = 1.0
        self._driven.append(
            self._action(found, [self._types.vec(*mask), *self._motion(support.motion)], self._types.vec)
        )

    def _motion(self, motion: HarmonicMotion | TableMotion) -> list[Any]:
        """Arguments of the `move_supports` kernel: amplitude, frequency, phase, times, table and slopes."""
        vec = self._types.vec
        empty = np.zeros((2, self._types.dimension))
        if isinstance(motion, HarmonicMotion):
            numbers = [vec(*motion.amplitude), motion.frequency, motion.phase]
            times, rows, slopes = np.array([0.0, 1.0]), empty, empty[:0]
        else:
            numbers = [vec(), 0.0, 0.0]
            times, rows = np.asarray(motion.times, float), np.asarray(motion.displacements, float)
            slopes = clamped_slopes(times, rows) if motion.interpolation == "cubic" else empty[:0]
        return [
            *numbers,
            wp.array(times, dtype=wp.float64, device=self._device),
            wp.array(rows, dtype=vec, device=self._device),
            wp.array(slopes, dtype=vec, device=self._device),
        ]

    def _load(self, load: Load, particles: Particles) -> _Action:
        found = select_held(particles, load)
        acceleration = np.zeros(particles.dimension)
        if load.acceleration is not None:
            acceleration += load.acceleration
        if load.force is not None:
            acceleration += np.asarray(load.force, float) / particles.masses[found].sum()
        return self._action(found, [self._types.vec(*acceleration), load.frequency, load.phase], self._types.real)

    def _action(self, found: np.ndarray, arguments: list[Any], kind: Any) -> _Action:
        return _Action(
            particles=wp.array(found, dtype=wp.int32, device=self._device),
            arguments=arguments,
            last=wp.zeros(len(found), dtype=kind, device=self._device),
            work=wp.zeros(len(found), dtype=wp.float64, device=self._device),
        )

    def _launch(self, kernel: Any, action: _Action, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, len(action.particles), inputs, outputs, device=self._device)

"""An explicit time step of elastic bodies, as a sequence of named phases (velocity Verlet, kick-drift-kick)."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import warp as wp

from warp_mps.elastic.contact.model import Contacts
from warp_mps.elastic.explicit.kernels import motion_kernels
from warp_mps.elastic.explicit.lagged_damping import LaggedDamping
from warp_mps.elastic.parts import SolidParts


class Phase(NamedTuple):
    """A part of a step.

    Attributes:
        name: Its name, for measurements of speed.
        launch: Launches it over `count` particles from `first` on; over all of them where it does not split.
        splits: Whether threads can share its particles.
        follows: Whether it needs nothing of other particles that the phase before it writes, so that a thread can go
            on to it without waiting for the others.
        on_host: Whether it runs on the host, so that no graph can hold it.
    """

    name: str
    launch: Callable[[int, int], None]
    splits: bool = False
    follows: bool = False
    on_host: bool = False


class ExplicitStep:
    """The phases of a step, in order. A phase that a scene does not need is left out.

    A phase reads nothing back and allocates nothing, unless it is `on_host`: it can be launched or captured.

    Attributes:
        phases: The phases.

    Args:
        parts: The parts of the bodies.
        lagged: Their numerical viscosity, if any.
    """

    def __init__(self, parts: SolidParts, lagged: LaggedDamping | None = None) -> None:
        self._parts, self._lagged = parts, lagged
        self._state, self._dt, self._device = parts.state, parts.dt, parts.device
        self._kernels = motion_kernels(parts.types)
        damp = [Phase("damp", lambda *_: self._damp())] if parts.damping else []
        # the work of a step is that of the velocities at its two ends, after the damping
        work = [Phase("work", lambda *_: self._add_work(self._dt))] if parts.does_work else []
        self.phases = [*damp, *self._predict(), *self._forces(), *self._correct(), *damp, *work]

    def start(self) -> None:
        """Evaluate the forces of the initial state, with which the first step begins."""
        parts, state = self._parts, self._state
        self._move_prescribed()
        if parts.contacts:
            parts.contacts.initialize(state)
        parts.evaluate_model()
        if parts.viscosity:
            for _, launch in parts.viscosity.passes(0.0):
                launch(state, 0, parts.count)
        if self._lagged:
            self._lagged.start()
        if parts.contacts:
            self._add_contact(parts.contacts)
        parts.boundary.add_loads(state.force, parts.mass)
        if parts.body_forces:
            parts.body_forces.apply(state, 0.0, state.force)
        self._kick(0.0, 0, parts.count)
        self._add_work(0.0)

    def launch(self, phases: Sequence[Phase]) -> None:
        """Launch phases over all particles."""
        for phase in phases:
            phase.launch(0, self._parts.count)

    def sections(self) -> list[list[Phase]]:
        """The phases in groups: threads must wait for each other between two groups."""
        groups: list[list[Phase]] = []
        for phase in self.phases:
            if groups and (phase.follows or not phase.splits) and groups[-1][-1].splits == phase.splits:
                groups[-1].append(phase)
            else:
                groups.append([phase])
        return groups

    def _predict(self) -> list[Phase]:
        """Half a kick and the drift, then whatever moves as prescribed."""
        phases = [Phase("drift", self._drift, splits=True)]
        if rotation := self._parts.model.rotation:
            launch = functools.partial(rotation.drift, self._dt)
            phases.append(Phase("rotation drift", launch, splits=True, follows=True))
        if self._parts.does_work:
            phases.append(Phase("prescribed motion", lambda *_: self._advance_prescribed()))
        return phases

    def _forces(self) -> list[Phase]:
        """Contact candidates, elastic and viscous forces, contact and loads."""
        parts, state = self._parts, self._state
        contacts, boundary = parts.contacts, parts.boundary
        phases = []
        if contacts:
            phases.append(Phase("contact search", lambda *_: contacts.locate(state)))
        phases += self._material_forces()
        if self._lagged:
            phases.append(Phase("lagged damping", self._lagged.launch, splits=True, follows=True))
        if contacts:
            phases.append(Phase("contact", lambda *_: self._add_contact(contacts)))
        if boundary.moving:
            phases.append(Phase("loads", lambda *_: boundary.add_loads(state.force, parts.mass)))
        if parts.external is not None:
            phases.append(Phase("external", lambda *_: self._add_external()))
        return phases + self._body_forces()

    def _material_forces(self) -> list[Phase]:
        """The passes of the elastic model, each followed by the viscous one, which needs its result alone."""
        state, parts = self._state, self._parts
        phases = [Phase(name, functools.partial(launch, state), splits=True) for name, launch in parts.model.passes]
        if parts.viscosity:
            launches = [(name, functools.partial(launch, state)) for name, launch in parts.viscosity.passes(self._dt)]
            viscous = [Phase(name, launch, splits=True, follows=True) for name, launch in launches]
            phases = [phase for pair in zip(phases, viscous, strict=True) for phase in pair]
        return phases

    def _body_forces(self) -> list[Phase]:
        """Body forces at the new places, Python functions first."""
        if not (forces := self._parts.body_forces):
            return []
        state, steps, dt = self._state, self._parts.boundary.steps, self._dt

        def evaluate(*_: int) -> None:
            forces.evaluate(state, float(steps.numpy()[0]) * dt)

        on_host = [Phase("body force on the host", evaluate, on_host=True)] if forces.on_host else []
        return [*on_host, Phase("body force", lambda *_: forces.launch(state, steps, dt, state.force))]

    def _correct(self) -> list[Phase]:
        """The second half of the kick."""
        phases = [Phase("kick", functools.partial(self._kick, self._dt), splits=True, follows=True)]
        if rotation := self._parts.model.rotation:
            launch = functools.partial(rotation.kick, self._dt)
            phases.append(Phase("rotation kick", launch, splits=True, follows=True))
        return phases

    def _drift(self, first: int, count: int) -> None:
        inputs = [first, self._dt, self._parts.inverse_mass, self._state.force]
        wp.launch(self._kernels.drift, count, inputs, [self._state.u, self._state.v], device=self._device)

    def _kick(self, dt: float, first: int, count: int) -> None:
        inputs = [first, dt, self._parts.gravity, self._parts.mass, self._parts.inverse_mass]
        wp.launch(self._kernels.kick, count, inputs, [self._state.force, self._state.v], device=self._device)

    def _advance_prescribed(self) -> None:
        wp.launch(self._kernels.count_step, 1, [self._parts.boundary.steps], device=self._device)
        self._move_prescribed()

    def _move_prescribed(self) -> None:
        """Place moving supports and walls."""
        self._parts.boundary.move_supports(self._state, self._parts.mass)
        if self._parts.walls:
            self._parts.walls.move(self._state, self._parts.boundary.steps)

    def _add_contact(self, contacts: Contacts) -> None:
        if self._parts.walls:
            self._parts.walls.clear_forces(self._state)
        contacts.launch_force(self._state)

    def _add_external(self) -> None:
        inputs, outputs = [self._parts.external], [self._state.force]
        wp.launch(self._kernels.add_force, self._parts.count, inputs, outputs, device=self._device)

    def _add_work(self, dt: float) -> None:
        """Add the work of supports, loads, body forces and walls over a step."""
        parts = self._parts
        parts.boundary.add_work(self._state, parts.mass, dt)
        if parts.body_forces:
            parts.body_forces.add_work(self._state.v, dt)
        if parts.walls:
            parts.walls.add_work(self._state)

    def _damp(self) -> None:
        """Mass-proportional damping over half a step."""
        parts, state = self._parts, self._state
        factor = float(np.exp(-0.5 * parts.damping * self._dt))
        inputs = [factor, parts.mass, parts.inverse_mass]
        wp.launch(self._kernels.damp, parts.count, inputs, [state.v, state.dissipated], device=self._device)
        if parts.model.rotation:
            parts.model.rotation.damp(factor, state.dissipated)

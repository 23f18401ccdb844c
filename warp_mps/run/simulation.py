"""The clock of a run: particles, time step, replayed graphs, and observers called with what they may see."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_mps.core.interrupts import hold_interrupts
from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, closing
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import Energy
from warp_mps.run.schedule import Clock
from warp_mps.run.system import PacedSystem, System
from warp_mps.scene import Scene

if TYPE_CHECKING:
    from warp_mps.elastic.explicit.solid import Solid
    from warp_mps.fluid.fluids import Fluids

# steps in a graph that is replayed as one: long enough that the launch from Python does not count
BLOCK = 32


class Simulation:
    """A scene on a device, at one moment of its run.

    ``Simulation(scene).run()`` computes the scene; `advance` does so by a number of steps. What it shows of itself
    (`positions`, `energy`, ...) is what observers see, see `warp_mps.observers.base.View`.

    Args:
        scene: The case.
        device: ``cpu``, or a CUDA device such as ``cuda:0``.
        precision: ``float64`` or ``float32``.
        graphs: Whether steps are replayed as graphs; else every kernel is launched by itself, with the same result.
        threads: Threads of the CPU device that share the particles, with the same result; worth it from some
            thousands on.
        announce: Called with a message when kernels have to be compiled first.

    Raises:
        InputError: The scene's bodies, supports, loads or domain do not fit its particles, or there is no such device
            or precision, or the device takes no threads.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        device: str = "cpu",
        precision: str = "float64",
        graphs: bool = True,
        threads: int = 1,
        announce: Callable[[str], None] | None = None,
    ) -> None:
        # Warp is imported with the first simulation, not with the package
        from warp_mps.core.device import open_device
        from warp_mps.core.replay import Replay
        from warp_mps.core.types import PRECISIONS, numeric_types

        if threads < 1:
            raise InputError("", "threads", f"is {threads}, must be 1 or more")
        if precision not in PRECISIONS:
            raise InputError("", "precision", f"is {precision!r}, must be one of: {', '.join(PRECISIONS)}")
        self._device = open_device(device)
        if threads > 1 and not self._device.is_cpu:
            raise InputError("", "threads", f"is {threads} on {device}; threads are for the CPU device")
        if threads > 1 and (scene.fluids or scene.implicit):
            what = "fluids take" if scene.fluids else "a static analysis and implicit steps take"
            raise InputError("", "threads", f"is {threads}; {what} one")
        self.scene = scene
        self.precision = precision
        self.clock = Clock(scene)
        self.particles: Particles = fill_scene(scene)
        self.step = 0
        numbers = numeric_types(scene.dimension, precision)
        made = self._make_system(numbers, graphs, announce)
        self._system: System = made
        self._system.start()
        self._replay = Replay(device=self._device, graphs=graphs)
        self._threads = threads
        self._team = self._make_team() if threads > 1 else None
        self._paced: PacedSystem | None = made if scene.fluids or scene.implicit else None
        self._seen: dict[str, Any] = {}

    def _make_system(self, numbers: Any, graphs: bool, announce: Callable[[str], None] | None) -> Any:
        """The scene's elastic bodies or its fluids, with their kernels loaded."""
        from warp_mps.core.device import load_modules
        from warp_mps.elastic.explicit.solid import Solid, declare_kernels
        from warp_mps.elastic.implicit.kernels import declare_implicit
        from warp_mps.elastic.implicit.static import StaticSolid
        from warp_mps.elastic.implicit.theta_rule import ImplicitSolid
        from warp_mps.fluid import fluids
        from warp_mps.walls.poses import declare_rigid

        if self.scene.fluids and self.scene.bodies:
            return self._make_hydroelastic(numbers, graphs, announce)
        if self.scene.fluids:
            load_modules(fluids.declare_kernels(numbers), self._device, announce)
            return fluids.Fluids(self.scene, self.particles, types=numbers, device=self._device, graphs=graphs)
        modules = declare_kernels(numbers)
        if self.scene.walls:
            modules.append(declare_rigid(numbers))
        if self.scene.implicit:
            modules += declare_implicit(numbers)
        load_modules(modules, self._device, announce)
        if self.scene.analysis == "static":
            return StaticSolid(self.scene, self.particles, types=numbers, device=self._device, graphs=graphs)
        if self.scene.implicit:
            dt = self.clock.dt
            return ImplicitSolid(self.scene, self.particles, dt=dt, types=numbers, device=self._device, graphs=graphs)
        return Solid(self.scene, self.particles, dt=self.clock.dt, types=numbers, device=self._device)

    def _make_hydroelastic(self, numbers: Any, graphs: bool, announce: Callable[[str], None] | None) -> Any:
        """The scene's elastic bodies and its fluids."""
        from warp_mps.core.device import load_modules
        from warp_mps.coupling import hydroelastic
        from warp_mps.elastic.explicit import solid
        from warp_mps.elastic.implicit.kernels import declare_implicit
        from warp_mps.fluid import fluids

        modules = [*fluids.declare_kernels(numbers), *solid.declare_kernels(numbers), *declare_implicit(numbers)]
        modules += hydroelastic.declare_kernels(numbers)
        load_modules(list(dict.fromkeys(modules)), self._device, announce)
        options: dict[str, Any] = {"types": numbers, "device": self._device, "graphs": graphs}
        return hydroelastic.Hydroelastic(self.scene, self.particles, interval=self.clock.dt, **options)

    @property
    def solid(self) -> Solid:
        """The elastic bodies.

        Raises:
            TypeError: The scene has none.
        """
        from warp_mps.elastic.explicit.solid import Solid

        made = getattr(self._system, "solid", self._system)
        if not isinstance(made, Solid):
            raise TypeError(f"the scene {self.scene.name!r} has no elastic bodies")
        return made

    @property
    def fluids(self) -> Fluids:
        """The fluids.

        Raises:
            TypeError: The scene has none.
        """
        from warp_mps.fluid.fluids import Fluids

        made = getattr(self._system, "fluids", self._system)
        if not isinstance(made, Fluids):
            raise TypeError(f"the scene {self.scene.name!r} has no fluids")
        return made

    @property
    def device(self) -> str:
        """Name of the device."""
        return str(self._device)

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return self.clock.dt

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time(self.step)

    @property
    def total_steps(self) -> int:
        """Number of steps of the whole run."""
        return self.clock.steps

    @property
    def steps_done(self) -> int:
        """Number of time steps done, of fluids those within the intervals."""
        return int(self.fluids.state.steps.numpy()[0]) if self.scene.fluids else self.step

    @property
    def longest_step(self) -> tuple[float, float]:
        """The longest time step that may be taken, and what is stable [s]."""
        if self.scene.fluids:
            limit = self.fluids.model.step_limit
            return min(self.scene.time_step or limit, limit), limit
        return self.clock.dt, self.clock.dt_limit

    def record(self) -> dict[str, dict[str, float]]:
        """Statistics of the solvers, by the field of `warp_mps.results.summary.RunSummary` that holds them."""
        return self._paced.record() if self._paced else {}

    def advance(self, steps: int) -> None:
        """Advance by a number of time steps.

        An interrupt (Ctrl-C) takes effect between two blocks of steps, so that `step` is that of the state.

        Raises:
            RunError: A step, or an equilibrium, could not be solved, or a fluid particle ran away.
            RuntimeError: An earlier failure within a step has ended the threads; `restore` starts new ones.
        """
        self._seen.clear()
        blocks, rest = divmod(steps, BLOCK) if not self._paced else (0, steps)
        for block in itertools.chain(itertools.repeat(BLOCK, blocks), itertools.repeat(1, rest)):
            with hold_interrupts():
                self._take(block)
                self.step += block

    def synchronize(self) -> None:
        """Wait for the device to finish what it was given."""
        import warp as wp

        wp.synchronize_device(self._device)

    def run(self, observers: Sequence[Observer] = ()) -> None:
        """Advance to the end, showing the run to observers on the way; they are closed whatever happens.

        Raises:
            RunError: The run cannot go on, as the simulation or an observer has found.
        """
        with closing(observers):
            self._show(observers)
            while self.step < self.total_steps:
                due = min((o.every - self.step % o.every for o in observers), default=self.total_steps)
                self.advance(min(due, self.total_steps - self.step))
                self._show(observers)

    @property
    def displacements(self) -> np.ndarray:
        """Displacements u = x - X [m], shape [n, d]."""
        return self._once("u", self._system.displacements)

    @property
    def positions(self) -> np.ndarray:
        """Positions x [m], shape [n, d]."""
        return self._once("x", lambda: self.particles.positions + self.displacements)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], shape [n, d]."""
        return self._once("v", self._system.velocities)

    @property
    def rotations(self) -> np.ndarray:
        """Rotation vectors [rad], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("q", self._system.rotations)

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the particles' own rotation [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("omega", self._system.angular_velocities)

    @property
    def pressures(self) -> np.ndarray:
        """Pressures [Pa], shape [n]."""
        return self._once("p", self._system.pressures)

    @property
    def number_densities(self) -> np.ndarray:
        """Number densities of fluids in units of a full lattice's, else 1 [-], shape [n]."""
        return self._once("n", self._system.number_densities)

    @property
    def volumes(self) -> np.ndarray:
        """Volumes that particles of fluids take up, else 0 [m^d], shape [n]; see `warp_mps.fluid.volumes`."""
        return self._once("volumes", self._system.volumes)

    @property
    def stresses(self) -> np.ndarray:
        """Cauchy stresses along the scene's axes [Pa], shape [n, 3, 3]; see `warp_mps.elastic.output.stresses`."""
        return self._once("stress", self._system.stress_fields).stresses

    @property
    def strains(self) -> np.ndarray:
        """Green-Lagrange strains along the scene's axes [-], shape [n, 3, 3]."""
        return self._once("stress", self._system.stress_fields).strains

    @property
    def von_mises(self) -> np.ndarray:
        """Von Mises stresses [Pa], shape [n]."""
        from warp_mps.elastic.output.stresses import von_mises

        return self._once("von Mises", lambda: von_mises(self.stresses))

    @property
    def strain_energy_densities(self) -> np.ndarray:
        """Strain energy per reference volume [J/m^3], shape [n]."""
        return self._once("density", self._system.energy_densities)

    @property
    def contact_forces(self) -> np.ndarray:
        """Contact forces on the particles [N], shape [n, d]."""
        return self._once("contact", self._system.contact_forces)

    @property
    def internal_forces(self) -> np.ndarray:
        """Elastic and contact forces: the total force less weight and loads [N], shape [n, d]."""
        return self._once("internal", self._system.internal_forces)

    @property
    def elastic_forces(self) -> np.ndarray:
        """Elastic forces, and those of the material's damping, on the particles [N], shape [n, d]."""
        return self._once("elastic", lambda: self.internal_forces - self.contact_forces)

    @property
    def elastic_torques(self) -> np.ndarray:
        """Elastic torques on the particles' own rotation [N m], shape [n, 1] in 2-D and [n, 3] in 3-D."""
        return self._once("torques", self._system.elastic_torques)

    @property
    def reactions(self) -> np.ndarray:
        """Forces that the supports exert on the particles [N], shape [n, d]."""
        return self._once("reactions", self._system.reactions)

    @property
    def energy(self) -> Energy:
        """Energies of all particles [J], in 2-D [J/m]."""
        return self._once("energy", self._system.energy)

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, as host copies; `restore` continues from them to the same bits."""
        return {"step": np.array(self.step), **self._system.arrays()}

    def restore(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `state_arrays` gave in a simulation of the same scene."""
        if self._team and self._team.closed:
            self._team = self._make_team()
        self._seen.clear()
        self._system.assign(arrays)
        self.step = int(arrays["step"])

    def _take(self, steps: int) -> None:
        """Run some steps, of elastic bodies as one graph."""
        if self._paced:
            for step in range(self.step, self.step + steps):
                self._paced.advance(self.clock.time(step + 1))
        elif self._team:
            self._team.run(steps)
        else:
            self._replay(f"{steps} steps", lambda: _repeat(self.solid.step, steps))

    def _make_team(self) -> Any:
        """Threads with a graph each for every section of a step; sections that do not split are the first thread's."""
        import warp as wp

        from warp_mps.core.replay import capture
        from warp_mps.core.threads import Team, shares

        def task(section: Sequence[Any], share: tuple[int, int]) -> Callable[[], None]:
            def launch() -> None:
                for phase in section:
                    phase.launch(*share)

            return functools.partial(wp.capture_launch, capture(launch, self._device))

        count, threads = self.particles.elastic, self._threads
        sections = [
            [task(section, share) for share in (shares(count, threads) if section[0].splits else [(0, count)])]
            for section in self.solid.sections()
        ]
        return Team([tasks + [None] * (threads - len(tasks)) for tasks in sections], threads)

    def _show(self, observers: Sequence[Observer]) -> None:
        # before the observers, so that nothing is recorded of a state that is not one
        if (trouble := self._system.trouble()) is not None:
            raise RunError(f"at t = {self.time:.6g} s: {trouble}")
        last = self.step == self.total_steps
        for observer in observers:
            if last or self.step % observer.every == 0:
                observer.observe(self)

    def _once(self, name: str, evaluate: Callable[[], Any]) -> Any:
        if name not in self._seen:
            self._seen[name] = evaluate()
        return self._seen[name]


def _repeat(launch: Callable[[], None], times: int) -> None:
    for _ in range(times):
        launch()

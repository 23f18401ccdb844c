"""A time step of the semi-implicit MPS method, phase by phase.

A step moves the particles to its midpoint, predicts velocities without the pressure, solves the pressure Poisson
equation there for the pressure that keeps the density, corrects the velocities by its gradient, and moves the particles
on to the end (`warp_mps.fluid.time_integration`):

    x^ = x + dt/2 u
    u* = u + dt (nu lap u + g + f)
    lap p = rho/dt div u* + density error
    u' = u* - dt grad p / rho
    x' = x^ + dt/2 u'

with gravity g and the body forces f of the scene, if any. Walls are where they are at the midpoint. Schemes other than
`conservative`, and every scheme beside elastic bodies, evaluate the pressure at predicted positions x* = x + dt u*
instead; `FluidModel.midpoint` says why.

References:
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import ConjugateGradient
from warp_mps.core.replay import Replay
from warp_mps.fluid.adaptive_step import AdaptiveTimeStep
from warp_mps.fluid.body_forces import make_body_forces
from warp_mps.fluid.implicit_viscosity import ImplicitViscosity
from warp_mps.fluid.kernels import fluid_kernels
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.neighbour_room import expected_neighbours
from warp_mps.fluid.neighbours import NeighbourLists
from warp_mps.fluid.pressure.equation import PressureEquation
from warp_mps.fluid.pressure_forces import PressureForces
from warp_mps.fluid.state import initial_state
from warp_mps.fluid.wall_motion import WallMotion
from warp_mps.scene import Scene

# name of a phase and the method that launches it
Phase = tuple[str, Callable[[], None]]


class FluidStep:
    """The phases of a time step, and the arrays that they work in.

    A phase is the same Python whether it is run eagerly or captured in a graph: it reads nothing back from the device
    and allocates nothing.

    Attributes:
        model: Constants of the run.
        state: State of the fluid.
        neighbours: Neighbour lists.
        time_step: Length of the step, found on the device.
        wall_motion: Prescribed motion of the walls.
        pressure: Pressure Poisson equation.
        forces: Forces of the pressure.
        body_forces: Forces that depend on place and time, None if there are none.
        implicit_viscosity: Solver of the viscous velocities, None if viscosity is explicit.
        viscous_acceleration: Viscous accelerations, of wall particles the reaction's; of fluid particles with those by
            body forces [m/s^2], vec [n].
        ghost_velocity: Velocities of walls for viscosity, mirrored at walls without slip [m/s], vec [w].
        velocity_change: Last change of velocity of fluid particles, by pressure or collisions [m/s], vec [m].
        shift: Shifts of fluid particles [m], vec [m].
        replay: Replays launches under a name; forgets them when arrays are replaced.

    Args:
        scene: The case.
        model: Constants of the run.
        graphs: Whether steps are replayed as graphs.
    """

    def __init__(self, scene: Scene, model: FluidModel, *, graphs: bool = True) -> None:
        self.model, types, device = model, model.types, model.device
        d, n, w, m = types.dimension, model.particles.count, model.walls, model.count
        self.neighbours = NeighbourLists(
            n, walls=w, low=model.low, high=model.high, periodic=model.periodic, radius=model.operators.radius,
            spacing=model.spacing, neighbours=expected_neighbours(d, scene.flow.radius(d)), types=types, device=device,
        )  # fmt: skip
        self.state = initial_state(model, self.neighbours)
        self.time_step = AdaptiveTimeStep(model, self.state)
        self.wall_motion = WallMotion(scene, model, self.state)
        self.body_forces = make_body_forces(scene, model, self.state)
        self.pressure = PressureEquation(model, self.state, self.neighbours)
        self.forces = PressureForces(model, self.state, self.neighbours, self.pressure)
        self.implicit_viscosity = (
            ImplicitViscosity(n, w, self.pressure.matrix, types=types, device=device)
            if model.implicit_viscosity
            else None
        )
        self.viscous_acceleration = wp.zeros(n, dtype=types.vec, device=device)
        self.ghost_velocity = wp.zeros(max(w, 1), dtype=types.vec, device=device)
        self.velocity_change, self.shift = (wp.zeros(m, dtype=types.vec, device=device) for _ in range(2))
        self.replay = Replay(device=device, graphs=graphs)
        self._kernels = fluid_kernels(types)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phases of a step in their order: name and method."""
        return (*self.opening, *self.prediction, *self.solution)

    @property
    def opening(self) -> tuple[Phase, ...]:
        """The phases before body forces are evaluated."""
        moves: tuple[Phase, ...] = (("drift", self.drift), ("neighbour lists", self.update_neighbours))
        return (("time step", self.set_time_step), *(moves if self.model.midpoint else ()))

    @property
    def prediction(self) -> tuple[Phase, ...]:
        """The phases that lead to the velocities and positions of the pressure Poisson equation."""
        lists: tuple[Phase, ...] = (("neighbour lists", self.update_neighbours),)
        steps = (("viscosity", self.apply_viscosity), ("predictor", self.predict))
        return (*steps, *(() if self.model.midpoint else lists))

    @property
    def solution(self) -> tuple[Phase, ...]:
        """The phases from the assembly of the equation to the end of the step."""
        return (
            ("assembly", self.assemble),
            ("pressure solve", self.solve_pressure),
            ("corrector", self.correct),
            ("collisions", self.collide),
            ("clock", self.advance_clock),
        )

    def take(self) -> None:
        """Take a step towards the target time, as one graph; body forces are evaluated between two."""
        if self.body_forces:
            self.replay("open step", lambda: launch(self.opening))
            self.evaluate_body_forces()
            self.replay("end step", lambda: launch(self.prediction + self.solution))
        else:
            self.replay("step", lambda: launch(self.phases))

    def set_time_step(self) -> None:
        """Choose the time step by the CFL condition."""
        self.time_step.choose()

    def drift(self) -> None:
        """Move the fluid over the first half of the step, and the walls to its midpoint."""
        model, state = self.model, self.state
        model.launch(self._kernels.drift, model.count, [model.constants, self.time_step.dt, state.u], [state.x])
        self.wall_motion.place_midway(self.time_step.middle, self.time_step.end)

    def evaluate_body_forces(self) -> None:
        """Evaluate body forces given as Python functions, on the host; after the opening of a step."""
        if self.body_forces:
            self.body_forces.evaluate(self._force_time)

    def apply_viscosity(self) -> None:
        """Find the accelerations of the predictor beside gravity: viscous ones, and those by body forces."""
        if self.body_forces:
            self.body_forces.launch(self._force_time)
        self._find_viscous_accelerations()
        if self.body_forces:
            viscous = self.model.viscosity > 0.0
            self.body_forces.add_to(self.viscous_acceleration, self.time_step.dt, keep=viscous)

    def _find_viscous_accelerations(self) -> None:
        """Find viscous accelerations nu lap u, with implicit viscosity of the velocities at the end of the step."""
        model, state, lists = self.model, self.state, self.neighbours
        if model.viscosity == 0.0:
            return
        constants, table, u = model.constants, lists.table, state.u
        inputs = [constants, table, model.no_slip, state.x, u, state.lost]
        model.launch(self._kernels.ghost_velocity, model.walls, inputs, [self.ghost_velocity])
        if self.implicit_viscosity:
            driven = self.body_forces.velocity_with_force(self.time_step.dt) if self.body_forces else u
            now = [self.time_step.dt, state.x, driven, state.lost, self.ghost_velocity]
            self.implicit_viscosity.solve(constants, [constants, table, model.no_slip, *now], u)
            u = self.implicit_viscosity.u
        inputs = [constants, table, model.no_slip, state.x, u, state.lost, self.ghost_velocity]
        model.launch(self._kernels.viscous_acceleration, len(state.x), inputs, [self.viscous_acceleration])

    def predict(self) -> None:
        """Predict velocities u* without the pressure; and positions x* and walls at the end without a drift."""
        model, state = self.model, self.state
        inputs = [model.constants, self.time_step.dt, self.viscous_acceleration, state.lost]
        outputs = [state.x, state.u, state.impulse, state.work]
        model.launch(self._kernels.predict, len(state.x), inputs, outputs)
        if model.midpoint:
            self._subtract_forces_from_walls()
        else:
            self._place_walls(self.time_step.end)

    def update_neighbours(self) -> None:
        """Renew the neighbour lists if a particle has moved by half of their margin."""
        self.neighbours.update(self.state.x, self.state.lost)

    def assemble(self) -> None:
        """Assemble the pressure Poisson equation."""
        self.pressure.assemble(self.time_step.dt)

    def solve_pressure(self) -> None:
        """Solve for the pressure, and find its slopes along walls."""
        self.pressure.solve()
        self.forces.find_slopes()

    def correct(self) -> None:
        """Correct velocities and positions by the gradient of the pressure, and sum up its impulse on the walls."""
        model, state, dt = self.model, self.state, self.time_step.dt
        self.forces.accelerate(dt, self.velocity_change)
        self.forces.add_wall_impulse(model.walls, dt, state.impulse, state.work)
        inputs = [model.constants, dt, self.velocity_change]
        model.launch(self._kernels.correct, model.count, inputs, [state.x, state.u])
        if model.midpoint:
            self._place_walls(self.time_step.end)

    def collide(self) -> None:
        """Shift particles, let those that come too close collide, and mark those that have left the domain."""
        model, state, lists, kernels = self.model, self.state, self.neighbours, self._kernels
        constants, table, m = model.constants, lists.table, model.count
        if model.shifting:
            inputs = [constants, table, state.x, self.time_step.displacement, self.pressure.surface]
            model.launch(kernels.shift_particles, m, inputs, [self.shift])
        inputs = [constants, table, model.collision_share, state.x, state.u]
        model.launch(kernels.collide, m, [*inputs, self.shift], [self.velocity_change])
        model.launch(kernels.collide_walls, model.walls, inputs, [state.impulse, state.work])
        inputs = [constants, self.time_step.dt, self.velocity_change, self.shift]
        model.launch(kernels.end_step, m, inputs, [state.x, state.u, state.lost, state.fallen, state.stale])

    def advance_clock(self) -> None:
        """End the step: advance the time, and count the step."""
        if self.body_forces:
            self.body_forces.end_step(self.time_step.dt)
        self.time_step.advance_clock()

    def renew_neighbours(self) -> None:
        """Renew the neighbour lists, whether or not they are stale."""
        self.neighbours.renew(self.state.x, self.state.lost)

    def grow_neighbours(self) -> None:
        """Give neighbour lists, and the rows of the equations, more room where particles crowd."""
        lists = self.neighbours
        if not (lists.crowded() and lists.can_grow):
            return
        while lists.crowded() and lists.can_grow:
            lists.grow()
            self.renew_neighbours()
        self.pressure.resize()
        if self.implicit_viscosity:
            self.implicit_viscosity.use(self.pressure.matrix)
        self.replay.forget()

    def sort_particles(self) -> None:
        """Put the fluid particles in the order of cells."""
        self.state.sort(self.model.low, 2.0 * self.model.operators.radius)
        self.renew_neighbours()

    def is_closed(self) -> bool:
        """Whether the fluid has no free surface now."""
        shown = wp.clone(self.state.n)
        self.time_step.dt.fill_(self.time_step.longest)
        self.assemble()
        wp.copy(self.state.n, shown)
        assert self.pressure.matrix.singular is not None
        return bool(self.pressure.matrix.singular.numpy()[0])

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `FluidState.arrays` gave: the lists are made where they were made then."""
        state = self.state
        state.assign({**arrays, "x": arrays["x_listed"]})
        self.renew_neighbours()
        self.grow_neighbours()
        state.x.assign(arrays["x"])
        state.stale.assign(arrays["stale"])
        if self.body_forces:
            self.body_forces.assign(arrays)
        self._place_walls(state.time)

    @property
    def solvers(self) -> dict[str, ConjugateGradient]:
        """The solvers of a step, by what they solve for."""
        viscous = {"velocities": self.implicit_viscosity.solver} if self.implicit_viscosity else {}
        return {"pressures": self.pressure.solver, **viscous}

    def _place_walls(self, time: wp.array) -> None:
        """Launch the positions, velocities and accelerations of the walls at a time [s], float64 [1]."""
        self.wall_motion.place(time)
        self._subtract_forces_from_walls()

    def _subtract_forces_from_walls(self) -> None:
        if self.body_forces:
            self.body_forces.subtract_from_walls()

    @property
    def _force_time(self) -> wp.array:
        """Time at which body forces act in a step [s], float64 [1]."""
        return self.time_step.middle if self.model.midpoint else self.state.time

    def count_unsolved(self) -> int:
        """Number of solves so far that ended above their tolerance."""
        return sum(solver.count_unsolved() for solver in self.solvers.values())


def launch(phases: tuple[Phase, ...]) -> None:
    """Launch phases one by one."""
    for _, phase in phases:
        phase()

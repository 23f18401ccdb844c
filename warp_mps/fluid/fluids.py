"""The fluids of a scene on a device, between its walls: one step of them, and what can be asked of them."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Matrix
from warp_mps.core.linear.conjugate_gradient import declare_kernels as declare_solver
from warp_mps.core.multigrid.preconditioner import Multilevel
from warp_mps.core.multigrid.preconditioner import declare_kernels as declare_multilevel
from warp_mps.core.replay import Replay
from warp_mps.core.types import NumericTypes
from warp_mps.errors import RunError
from warp_mps.fluid.failures import FluidFailures
from warp_mps.fluid.gradient import gradient_kernels
from warp_mps.fluid.limits import domain, step_limit
from warp_mps.fluid.lists import METHOD, NeighbourLists, even_neighbours, list_kernels
from warp_mps.fluid.motion import COLLISION, KEPT_APART, motion_kernels
from warp_mps.fluid.operators import operators
from warp_mps.fluid.planes import plane_kernels
from warp_mps.fluid.pressure import CONSERVATIVE, CORRECTED, KOSHIZUKA_OKA, pressure_kernels
from warp_mps.fluid.state import FluidState, initial_state
from warp_mps.fluid.viscous import ImplicitViscosity, viscous_kernels
from warp_mps.fluid.volumes import volume_kernels
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene
from warp_mps.walls.poses import Poses, declare_rigid, moving_runs

SCHEMES = {"conservative": CONSERVATIVE, "corrected": CORRECTED, "koshizuka_oka": KOSHIZUKA_OKA}
# particles that one thread goes through when a maximum is sought
CHUNK = 512
# steps after which the particles are put in the order of the cells that they have come to
SORT_EVERY = 100
MAX_ITERATIONS = 2000


def declare_kernels(types: NumericTypes) -> list[str]:
    """Declare every kernel that fluids need, and return the names of their modules."""
    for declare in (
        list_kernels,
        plane_kernels,
        pressure_kernels,
        gradient_kernels,
        motion_kernels,
        viscous_kernels,
        volume_kernels,
    ):
        declare(types)
    return [types.module(METHOD), *declare_solver(types), *declare_multilevel(types), declare_rigid(types)]


class Fluids(FluidFailures):
    """The fluids of a scene and the walls that hold them.

    A step is the same Python whether it is run eagerly or captured: it reads nothing back and allocates nothing. Its
    length is found on the device, so that an interval takes as many steps as the fastest particle asks for.

    Attributes:
        state: Everything that evolves, in the order of the cells that the particles are in.
        operators: Factors of the operators.
        lists: Neighbour lists.
        step_limit: Longest step that the fluid at its start may take [s]; see `warp_mps.fluid.limits.step_limit`.

    Args:
        scene: The case.
        particles: Its particles; walls come first, fluids last.
        types: Number types.
        device: Warp device.
        graphs: Whether steps are replayed as graphs.

    Raises:
        InputError: The domain of the scene does not hold its fluids.
    """

    def __init__(
        self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any, graphs: bool = True
    ) -> None:
        self._particles, self._device, self._d = particles, device, types.dimension
        self._replay = Replay(device=device, graphs=graphs)
        self._m = particles.liquid
        self._walls = particles.count - self._m
        fluid, flow = scene.fluids[0], scene.flow
        self._spacing, self._density, self._viscosity = fluid.spacing, fluid.liquid.density, fluid.liquid.viscosity
        self.operators = operators(types.dimension, fluid.spacing, flow.radius(types.dimension))
        self._gravity_host = np.asarray(scene.gravity if len(scene.gravity) else np.zeros(types.dimension), float)
        self._gravity = types.vec(*self._gravity_host)
        self._scheme = SCHEMES[flow.scheme]
        self._clip = int(flow.negative_pressure == "clipped")
        self._shifts = int(self._scheme == CORRECTED or (self._scheme == CONSERVATIVE and not self._clip))
        self._collision = KEPT_APART if self._scheme == CONSERVATIVE else COLLISION
        self._volume = fluid.spacing**types.dimension
        self._low, self._high = domain(scene, particles)
        self.lists = NeighbourLists(
            particles.count, walls=self._walls, low=self._low, high=self._high, periodic=flow.periodic,
            radius=self.operators.radius, spacing=fluid.spacing, types=types, device=device,
            neighbours=even_neighbours(types.dimension, flow.radius(types.dimension)),
        )  # fmt: skip
        original = self._scheme == KOSHIZUKA_OKA
        self._slope = self.operators.original_gradient if original else self.operators.gradient
        n0 = self.operators.number_density
        self.state: FluidState = initial_state(particles, self.lists, n0, types=types, device=device)
        self.step_limit, implicit = step_limit(scene, particles)
        self._longest = min(self.step_limit, scene.time_step or math.inf)
        self._courant = flow.courant
        self._kit = types
        self._kernels = (pressure_kernels(types), gradient_kernels(types), motion_kernels(types))
        self._allocate(scene, flow.tolerance)
        n, m = self._walls + self._m, self._matrix
        self._implicit = ImplicitViscosity(n, self._walls, m, types=types, device=device) if implicit else None
        self._velocities_before, self._interval = particles.velocities, math.inf

    def _allocate(self, scene: Scene, tolerance: float) -> None:
        """Arrays that a step works in, the solver, and the walls' poses."""
        types, device, m, n = self._kit, self._device, self._m, self._particles.count

        def zeros(length: int, kind: Any) -> wp.array:
            return wp.zeros(length, dtype=kind, device=device)

        width = self.lists.listed.shape[1]
        self._matrix = Matrix(
            rows=wp.array([m], dtype=wp.int32, device=device),
            first=zeros(m, wp.int32), count=zeros(m, wp.int32), index=zeros(m * width, wp.int32),
            value=zeros(m * width, types.real), diagonal=zeros(m, types.real), active=zeros(m, wp.int32),
            singular=zeros(1, wp.int32),
        )  # fmt: skip
        self._rhs = zeros(m, wp.float64)
        x, periodic = self._particles.positions, scene.flow.periodic
        wraps = np.isin(np.arange(self._d), periodic)
        preconditioner = Multilevel(
            self.state.x[self._walls :], low=np.where(wraps, self._low, np.maximum(x.min(axis=0), self._low)),
            high=np.where(wraps, self._high, np.minimum(x.max(axis=0), self._high)),
            reach=self.operators.radius, types=types, device=device, periodic=periodic,
        )  # fmt: skip
        self._solver = ConjugateGradient(
            m,
            types=types,
            device=device,
            tolerance=tolerance,
            max_iterations=MAX_ITERATIONS,
            preconditioner=preconditioner,
        )
        self._du, self._shift, self._surface = zeros(m, types.vec), zeros(m, types.vec), zeros(m, wp.int32)
        self._acceleration, self._mirrored = zeros(n, types.vec), zeros(max(n - m, 1), types.vec)
        # beside walls: normals, distances from their faces, what images count, and slopes of the pressure
        self._normal, self._depth, self._tilt, self._along = (
            zeros(m, kind) for kind in (types.vec, types.real, types.vec, types.vec)
        )
        self._scale = wp.ones(m, dtype=types.real, device=device)
        self._floors = zeros(-(-m // CHUNK), wp.float64)
        self._speeds = zeros(-(-n // CHUNK), types.real)
        self._dt, self._way, self._target, self._time_after = (zeros(1, wp.float64) for _ in range(4))
        self._left = zeros(1, wp.int32)
        self._poses = Poses(scene, types=types, device=device) if scene.walls else None
        self._runs = moving_runs(scene, self._particles)
        self._wall = wp.array(self._particles.walls, dtype=wp.int32, device=device)
        self._reference = wp.array(
            self._particles.positions, dtype=wp.types.vector(length=self._d, dtype=wp.float64), device=device
        )
        stick = np.array([wall.slip == "no" for wall in scene.walls] or [False])[self._particles.walls]
        stick[: self._particles.elastic] = False
        stick |= np.arange(n) >= self._walls
        # a wall stops what meets it; a marker of an elastic body takes its part of the momentum
        firmness, elastic = np.ones(max(n - m, 1)), self._particles.elastic
        masses = self._particles.masses[:elastic]
        firmness[:elastic] = masses / (masses + self._density * self._volume)
        self._firmness = wp.array(firmness, dtype=types.real, device=device)
        self._sticks = wp.array(stick.astype(np.int32), dtype=wp.int32, device=device)

    def start(self) -> None:
        """Find the neighbours of the initial state."""
        self._place(self.state.time)
        self.lists.renew(self.state.x, self.state.lost)

    def is_closed(self) -> bool:
        """Whether the fluid has no free surface as it starts."""
        shown = wp.clone(self.state.n)
        self._dt.fill_(self._longest)
        self._assemble()
        wp.copy(self.state.n, shown)
        assert self._matrix.singular is not None
        return bool(self._matrix.singular.numpy()[0])

    def advance(self, time: float) -> int:
        """Advance to a time [s], and return the number of steps that it took.

        Raises:
            RunError: A particle is so fast that the time would take more steps than can be waited for, or an equation
                was not solved for too many steps in a row.
        """
        before = float(self.state.time.numpy()[0])
        self.aim(time)
        self.state.impulse.zero_()
        first = int(self.state.steps.numpy()[0])
        self._velocities_before, self._interval = self.velocities(), time - before
        self._make_room()
        while True:
            self._take_step()
            self._make_room()
            left = int(self._left.numpy()[0])
            if (failure := self.failure(left)) is not None:
                raise RunError(f"at t = {self.time:.6g} s: {failure}")
            if left <= 1:
                break
        steps = int(self.state.steps.numpy()[0])
        self.state.forces.assign(self.state.impulse.numpy() / self._interval)
        if steps // SORT_EVERY > first // SORT_EVERY:
            self._sort()
        return steps - first

    def _make_room(self) -> None:
        """Give the neighbour lists, and the rows that follow them, more room where particles crowd."""
        if not (self.lists.crowded() and self.lists.can_grow):
            return
        while self.lists.crowded() and self.lists.can_grow:
            self.lists.grow()
            self.lists.renew(self.state.x, self.state.lost)
        room = self._m * self.lists.listed.shape[1]
        index = wp.zeros(room, dtype=wp.int32, device=self._device)
        value = wp.zeros(room, dtype=self._kit.real, device=self._device)
        self._matrix = self._matrix._replace(index=index, value=value)
        if self._implicit:
            self._implicit.use(self._matrix)
        self._replay.forget()

    def aim(self, time: float) -> None:
        """Set the time that steps go towards [s]."""
        self._target.assign([time])

    def _take_step(self) -> None:
        """Take one step towards the target time."""
        self._replay("step", self.step)

    def step(self) -> None:
        """Advance by one step towards the target time."""
        for _, launch in self.phases:
            launch()

    @property
    def phases(self) -> tuple[tuple[str, Callable[[], None]], ...]:
        """What a step does, in order: the name of the part of the method, and what launches it."""
        return (
            ("rest", self._plan),
            ("viscosity", self._slow),
            ("rest", self._move),
            ("search", lambda: self.lists.update(self.state.x, self.state.lost)),
            ("assembly", self._assemble),
            ("pressure solve", self._project),
            ("forces", self._push),
            ("collisions", self._collide),
            ("rest", self._finish),
        )

    def _plan(self) -> None:
        state, motion = self.state, self._kernels[2]
        self._launch(motion.fastest, len(self._speeds), [CHUNK, state.u], [self._speeds])
        inputs = [self._longest, self._courant * self._spacing, self._speeds, self._target, state.time]
        self._launch(motion.plan, 1, inputs, [self._dt, self._way, self._left, self._time_after])

    def _slow(self) -> None:
        """Viscous accelerations."""
        state, motion, lists = self.state, self._kernels[2], self.lists
        if self._viscosity > 0.0:
            factor = self._viscosity * self.operators.laplacian
            inputs = [lists.period, self.operators.radius, self._sticks, *self._listed(), state.x, state.u, state.lost]
            self._launch(motion.mirror, self._walls, inputs, [self._mirrored])
            head, tail = [self._walls, lists.period, self.operators.radius, factor], [self._sticks, *self._listed()]
            u = state.u
            if self._implicit:
                now = [self._dt, state.x, u, state.lost, self._mirrored]
                self._implicit.solve([*head, self._gravity, *tail], now, u)
                u = self._implicit.u
            inputs = [*head, *tail, state.x, u, state.lost, self._mirrored]
            self._launch(motion.viscosity, len(state.x), inputs, [self._acceleration])

    def _move(self) -> None:
        """The predictor, and the moving walls."""
        state, mass = self.state, self._density * self._volume
        inputs = [self._walls, self._gravity, mass, self._dt, self._acceleration, state.lost]
        outputs = [state.x, state.u, state.impulse, state.work]
        self._launch(self._kernels[2].predict, len(state.x), inputs, outputs)
        self._place(self._time_after)

    def _place(self, time: wp.array) -> None:
        """Place the moving walls."""
        if self._runs and self._poses:
            self._poses.evaluate(time)
            for first, count in self._runs:
                state = self.state
                self._poses.place(first, count, self._wall, self._reference, state.x, state.u, state.a)

    def _assemble(self) -> None:
        """The pressure Poisson equation."""
        state, ops, matrix = self.state, self.operators, self._matrix
        pressure = self._kernels[0]
        assert matrix.singular is not None
        matrix.singular.fill_(1)
        numbers = [ops.radius, self._spacing, ops.number_density, float(ops.neighbours), ops.divergence, ops.laplacian]
        numbers.append(self._slope)
        self._find_planes()
        inputs = [
            self._walls, self._scheme, self.lists.period, *numbers, self._density, self._gravity, *ops.beyond,
            self._relaxation, *self._listed(), self._dt, state.x, state.u, state.a, state.p, self._normal, self._depth,
        ]  # fmt: skip
        rows = [matrix.first, matrix.count, matrix.index, matrix.value, matrix.diagonal, matrix.active]
        outputs = [state.n, self._scale, *rows, self._rhs, self._surface, self._tilt, matrix.singular]
        self._launch(pressure.assemble, self._m, inputs, outputs)

    def _find_planes(self) -> None:
        """The faces of walls that fluid particles are beside, as far as the scheme looks at them."""
        if self._scheme == CONSERVATIVE:
            inputs = [self._walls, self.lists.period, self.operators.radius, self._spacing, *self._listed()]
            outputs = [self._normal, self._depth]
            self._launch(plane_kernels(self._kit).find_planes, self._m, [*inputs, self.state.x], outputs)

    def _project(self) -> None:
        """Pressures that keep the fluid's density, and their slopes along walls."""
        state, matrix = self.state, self._matrix
        self._solver.solve(matrix, self._rhs, state.p)
        self._lift(matrix.singular)
        self._find_slopes()

    def _lift(self, singular: wp.array | None) -> None:
        """Clip pressures, or make the least one 0."""
        state, pressure = self.state, self._kernels[0]
        self._launch(pressure.least, len(self._floors), [CHUNK, state.p], [self._floors])
        self._launch(pressure.lift, self._m, [self._clip, singular, self._floors], [state.p])

    @property
    def _relaxation(self) -> float:
        """Time in which the density is restored [s]."""
        g = float(np.linalg.norm(self._gravity_host))
        return 3.0 * math.sqrt(self._spacing / g) if g > 0.0 else 150.0 * self._longest

    def _push(self) -> None:
        """Velocities and positions by the pressure."""
        state, ops, lists = self.state, self.operators, self.lists
        _, gradient, motion = self._kernels
        head = [self._scheme, self._clip, lists.period, ops.radius, self._slope, self._density]
        inputs = [self._walls, *head, self._gravity, *self._listed(), self._dt, state.x, state.a, state.p, self._scale]
        inputs.append(self._along)
        self._launch(gradient.push, self._m, inputs, [self._du])
        self._push_walls(self._walls, self._dt, [state.impulse, state.work])
        self._launch(motion.apply, self._m, [self._walls, self._dt, self._du], [state.x, state.u])

    def _find_slopes(self) -> None:
        """Slopes of the pressure along walls."""
        state, ops = self.state, self.operators
        inputs = [self._walls, self.lists.period, ops.radius, self._slope, self._density, self._gravity]
        inputs += [*self._listed(), state.x, state.a, state.p, self._normal, self._depth]
        if self._scheme == CONSERVATIVE:
            self._launch(self._kernels[1].find_slopes, self._m, inputs, [self._along])

    def _push_walls(self, count: int, dt: wp.array, outputs: list[wp.array]) -> None:
        """Impulses on the first walls' particles in a time, and the walls' work, added to what there is."""
        state, ops = self.state, self.operators
        inputs = [self._walls, self._scheme, self._clip, self.lists.period, ops.radius, self._slope, self._density]
        inputs += [self._volume, self._gravity, *self._listed(), dt, state.x, state.u, state.a, state.p, self._scale]
        inputs.append(self._along)
        self._launch(self._kernels[1].push_walls, count, inputs, outputs)

    def _collide(self) -> None:
        """Shifts and collisions, which `_finish` applies."""
        state, ops, lists, motion = self.state, self.operators, self.lists, self._kernels[2]
        mass, reach = self._density * self._volume, self._collision * self._spacing
        if self._shifts:
            inputs = [self._walls, lists.period, ops.radius, self._spacing, ops.number_density, *self._listed()]
            self._launch(motion.move_apart, self._m, [*inputs, state.x, self._way, self._surface], [self._shift])
        tail = [self._firmness, *self._listed(), state.x, state.u]
        inputs = [self._walls, lists.period, self._spacing, reach, *tail, self._shift]
        self._launch(motion.collide, self._m, inputs, [self._du])
        inputs = [lists.period, self._spacing, mass, *tail]
        self._launch(motion.collide_walls, self._walls, inputs, [state.impulse, state.work])

    def _finish(self) -> None:
        """Collisions, shifts, periods and losses, and the clock."""
        state, motion = self.state, self._kernels[2]
        low, high = self._kit.vec(*self._low), self._kit.vec(*self._high)
        inputs = [self._walls, low, high, self.lists.period, self._gravity, self._dt, self._du, self._shift]
        outputs = [state.x, state.u, state.lost, state.stale, state.fallen]
        self._launch(motion.finish, self._m, inputs, outputs)
        self._launch(motion.tick, 1, [self._time_after], [state.time, state.steps])

    def _sort(self) -> None:
        """Put the fluid's particles in the order of the cells that they are in: what is near is then near in memory."""
        state, w = self.state, self._walls
        x = state.x.numpy()[w:].astype(float)
        cells = np.floor((x - self._low) / (2.0 * self.operators.radius)).astype(np.int64)
        new = np.lexsort((*x.T[::-1], *cells.T[::-1]))
        for array in (state.order, state.p, state.n):
            array.assign(array.numpy()[new])
        for array in (state.x, state.u, state.lost):
            values = array.numpy().copy()
            values[w:] = values[w:][new]
            array.assign(values)
        self.lists.renew(state.x, state.lost)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves, for a checkpoint."""
        before = {"u_before": self._velocities_before, "interval": np.array(self._interval)}
        return {**self.state.arrays(), **before}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave: the lists are made where they were made then."""
        self._velocities_before, self._interval = arrays["u_before"].copy(), float(arrays["interval"])
        present = arrays["x"]
        self.state.assign({**arrays, "x": arrays["x_listed"]})
        self.lists.renew(self.state.x, self.state.lost)
        self._make_room()
        self.state.x.assign(present)
        self.state.stale.assign(arrays["stale"])
        self._place(self.state.time)

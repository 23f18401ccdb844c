"""The body forces of a scene on its fluids: forces per mass that depend on place and time.

They are taken at the midpoint of a step where the pressure is evaluated there, and at its beginning where that is at
predicted positions (`warp_mps.fluid.time_integration`). Kernels that relate the pressure beyond a wall
to g - a, a the acceleration of the wall, find in `FluidState.a` of wall particles a less the body force there.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_mps.core.body_forces import BodyForces
from warp_mps.core.device import load_modules
from warp_mps.errors import InputError
from warp_mps.fluid.body_force_kernels import METHOD, body_force_kernels
from warp_mps.fluid.model import FluidModel
from warp_mps.fluid.state import FluidState
from warp_mps.scene import Scene
from warp_mps.walls.poses import moving_runs

# longest step under a force, in units of sqrt(l0/|f|) (Monaghan, Annu. Rev. Astron. Astrophys. 30 (1992) 543)
FORCE_STEP = 0.25


def make_body_forces(scene: Scene, model: FluidModel, state: FluidState) -> FluidBodyForces | None:
    """The body forces on the fluids of a scene, or None if none acts on them."""
    names = {fluid.name for fluid in scene.fluids}
    chosen = [force for force in scene.body_forces if not force.acts_on or names.intersection(force.acts_on)]
    if not chosen:
        return None
    rows = np.ones((len(chosen), model.particles.count), bool)
    forces = BodyForces(chosen, rows, types=model.types, device=model.device)
    return FluidBodyForces(scene, model, state, forces)


class FluidBodyForces:
    """Body forces on m fluid particles, and where w wall particles are.

    Args:
        scene: The case.
        model: Constants of the run.
        state: State of the fluid.
        forces: The body forces, at all n particles.
    """

    def __init__(self, scene: Scene, model: FluidModel, state: FluidState, forces: BodyForces) -> None:
        self._model, self._state, self._forces = model, state, forces
        self._kernels = body_force_kernels(model.types)
        load_modules([model.types.module(METHOD)], model.device)
        moving = np.zeros(max(model.walls, 1), np.int32)
        for first, count in moving_runs(scene, model.particles):
            moving[first : first + count] = 1
        self._moving = wp.array(moving, dtype=wp.int32, device=model.device)
        self._given = wp.ones_like(self._moving)
        vec64 = wp.types.vector(length=model.types.dimension, dtype=wp.float64)
        # impulse in the present interval, and work so far, at each place of the fluid's arrays
        self._impulse = wp.zeros(model.count, dtype=vec64, device=model.device)
        self._work = wp.zeros(model.count, dtype=wp.float64, device=model.device)
        self._velocity = wp.zeros_like(state.u)
        # mean acceleration by the forces over the last interval, in the order of the scene
        self.mean_acceleration = np.zeros((model.count, model.types.dimension))

    def start(self) -> float:
        """Evaluate the forces of the initial state, and return the longest step that they allow [s].

        Raises:
            InputError: They are not finite.
        """
        self.evaluate(self._state.time)
        self.launch(self._state.time)
        self.subtract_from_walls()
        largest = self.largest()
        if not np.isfinite(largest):
            raise InputError("", "body_forces", f"give {largest:g} m/s^2 at the start, must be finite")
        return FORCE_STEP * float(np.sqrt(self._model.spacing / largest)) if largest > 0.0 else np.inf

    def largest(self) -> float:
        """Largest force per mass on a fluid particle, as last evaluated [m/s^2]."""
        accelerations = self._forces.accelerations.numpy()[self._model.walls :].astype(float)
        return float(np.sqrt(np.max(np.sum(accelerations**2, axis=1))))

    def evaluate(self, time: wp.array) -> None:
        """Evaluate the Python functions, if any, at the present positions and a time [s], float64 [1]; no graph."""
        if self._forces.on_host:
            self._forces.evaluate(self._state.x.numpy(), float(time.numpy()[0]))

    def launch(self, time: wp.array) -> None:
        """Launch the accelerations at the present positions and a time [s], float64 [1]."""
        self._forces.launch(self._state.x, time)

    def velocity_with_force(self, dt: wp.array) -> wp.array:
        """Launch the velocities u + dt f [m/s], vec [n], for an implicit step of viscosity."""
        inputs = [self._model.walls, dt, self._forces.accelerations, self._state.u]
        self._model.launch(self._kernels.add_to_velocity, len(self._state.u), inputs, [self._velocity])
        return self._velocity

    def add_to(self, acceleration: wp.array, dt: wp.array, *, keep: bool) -> None:
        """Launch the addition to accelerations of the fluid [m/s^2], vec [n], and the first half of the work.

        Args:
            acceleration: The accelerations.
            dt: Time step [s], float64 [1].
            keep: Whether they hold other accelerations, and are not only replaced.
        """
        model, state = self._model, self._state
        inputs = [model.walls, float(keep), model.mass, dt, self._forces.accelerations, state.u, state.lost]
        model.launch(self._kernels.add_acceleration, model.count, inputs, [acceleration, self._impulse, self._work])

    def subtract_from_walls(self, count: int | None = None) -> None:
        """Launch the subtraction of the forces from the accelerations of wall particles.

        Args:
            count: Number of first wall particles, all with new accelerations; None is all wall particles, of which
                only those of moving walls have new ones.
        """
        model, moving = self._model, self._moving
        if count is not None:
            moving = self._given
        inputs = [moving, self._forces.accelerations]
        model.launch(
            self._kernels.subtract_from_walls, model.walls if count is None else count, inputs, [self._state.a]
        )

    def end_step(self, dt: wp.array) -> None:
        """Launch the second half of the work, with the velocities at the end of the step."""
        model, state = self._model, self._state
        inputs = [model.walls, model.mass, dt, self._forces.accelerations, state.u, state.lost]
        model.launch(self._kernels.add_work, model.count, inputs, [self._work])

    def begin_interval(self) -> None:
        """Begin the mean over an interval between two samples."""
        self._impulse.zero_()

    def end_interval(self, interval: float) -> None:
        """Find the mean over an interval [s]; before particles are sorted."""
        mean = self._state.fluid_in_scene_order(self._impulse.numpy())
        self.mean_acceleration = mean / (interval * self._model.mass)

    def work(self) -> float:
        """Work on the fluids so far [J], in 2-D [J/m]."""
        return float(np.sum(self._work.numpy()))

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that evolves here, for a checkpoint."""
        own = {"body_force": self._forces.accelerations, "body_force_work": self._work}
        copies = {name: array.numpy().copy() for name, array in own.items()}
        return {**copies, "body_force_mean": self.mean_acceleration}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave, after moving walls have been placed."""
        self._forces.accelerations.assign(arrays["body_force"])
        self._work.assign(arrays["body_force_work"])
        self.mean_acceleration = arrays["body_force_mean"].copy()

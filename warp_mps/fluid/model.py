"""Constants of a run of fluids."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.fluid.collisions import COLLISION, KEPT_APART
from warp_mps.fluid.constants import fluid_constants_struct
from warp_mps.fluid.domain import domain
from warp_mps.fluid.operator_constants import Operators, gradient_factor, operators
from warp_mps.fluid.schemes import CONSERVATIVE, CORRECTED, KOSHIZUKA_OKA, SCHEMES
from warp_mps.fluid.still_water import RADIUS, missing_heights
from warp_mps.fluid.time_step import step_limit
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# time in which the density is restored [sqrt(l0/g)], at the midpoint and at predicted positions: evaluated there, the
# divergence makes water swell by what spatial errors take from it; see `warp_mps.fluid.pressure.rows`
RELAXATION_AT_MIDPOINT, RELAXATION = 2.0, 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class FluidModel:
    """Constants of a run: n particles, the first w of them walls and markers of bodies, the last m fluid.

    Attributes:
        particles: The particles, in the order of the scene.
        types: Number types of the kernels.
        device: Warp device.
        walls: Number of wall particles w.
        count: Number of fluid particles m.
        operators: Factors of the MPS operators.
        spacing: Particle spacing l0 [m].
        density: Density rho [kg/m^3].
        viscosity: Kinematic viscosity nu [m^2/s].
        gravity: Gravity [m/s^2], shape [d].
        scheme: Discretization: `CONSERVATIVE`, `CORRECTED` or `KOSHIZUKA_OKA`.
        gradient_factor: Factor of the scheme's gradient [-].
        clip: 1 if negative pressures are set to 0, else 0.
        shifting: Whether particles are shifted towards an even distribution.
        collision_distance: Distance below which fluid particles collide [m].
        courant: CFL number: share of the spacing that the fastest particle moves in a step [-].
        step_limit: Longest time step that the fluid at its start may take [s]; see `warp_mps.fluid.time_step`.
        longest_step: That, or the time step of the scene where it is shorter [s].
        implicit_viscosity: Whether viscosity is implicit.
        tolerance: Residual of the pressure solve relative to its right-hand side [-].
        low: Lowest corner of the domain [m], shape [d].
        high: Its highest corner [m], shape [d].
        periodic: Its periodic axes.
        axes: Names of the axes, for messages.
        no_slip: 1 for fluid particles and for walls without slip, else 0, int32 [n].
        collision_share: Part of a collision's change of velocity that a fluid particle takes from a wall particle [-]:
            1 from a wall, less from a marker of an elastic body, which takes its own part; real [w].
    """

    particles: Particles
    types: NumericTypes
    device: Any
    walls: int
    count: int
    operators: Operators
    spacing: float
    density: float
    viscosity: float
    gravity: np.ndarray
    scheme: int
    gradient_factor: float
    clip: int
    shifting: bool
    collision_distance: float
    courant: float
    step_limit: float
    longest_step: float
    implicit_viscosity: bool
    tolerance: float
    low: np.ndarray
    high: np.ndarray
    periodic: tuple[int, ...]
    axes: str
    no_slip: wp.array
    collision_share: wp.array

    @property
    def midpoint(self) -> bool:
        """Whether the pressure is evaluated at the midpoint of a step, and not at predicted positions at its end.

        At the midpoint the original scheme runs away, and still water of the corrected scheme has twice the scatter of
        the pressure: both need the damping of the predicted positions. So do elastic bodies: a plate under a column of
        water was found to swing 2 % farther from period to period.
        """
        return self.scheme == CONSERVATIVE and self.particles.elastic == 0

    @property
    def volume(self) -> float:
        """Volume of a fluid particle, l0^d [m^d]."""
        return self.spacing**self.types.dimension

    @property
    def mass(self) -> float:
        """Mass of a fluid particle [kg], in 2-D [kg/m]."""
        return self.density * self.volume

    @property
    def relaxation_time(self) -> float:
        """Time in which the density is restored [s]."""
        g = float(np.linalg.norm(self.gravity))
        factor = RELAXATION_AT_MIDPOINT if self.midpoint else RELAXATION
        return factor * math.sqrt(self.spacing / g) if g > 0.0 else 150.0 * self.longest_step

    @functools.cached_property
    def constants(self) -> Any:
        """The constants as kernels take them, a `FluidConstants` of `warp_mps.fluid.constants`."""
        constants, ops, vec = fluid_constants_struct(self.types)(), self.operators, self.types.vec
        constants.walls, constants.scheme, constants.clip = self.walls, self.scheme, self.clip
        constants.midpoint = int(self.midpoint)
        constants.markers = self.particles.elastic
        wraps = np.isin(np.arange(self.types.dimension), self.periodic)
        constants.period = vec(*np.where(wraps, self.high - self.low, 0.0))
        constants.low, constants.high, constants.gravity = vec(*self.low), vec(*self.high), vec(*self.gravity)
        constants.radius, constants.spacing = ops.radius, self.spacing
        constants.number_density, constants.smooth_density = ops.number_density, ops.smooth_density
        constants.lattice_neighbours = float(ops.neighbours)
        constants.divergence, constants.laplacian = ops.divergence, ops.laplacian
        constants.gradient = self.gradient_factor
        dimension, reach = self.types.dimension, ops.radius / self.spacing
        still = min(RADIUS, reach)
        constants.still_radius, constants.still_gradient = still * self.spacing, gradient_factor(dimension, still)
        constants.missing_first, constants.missing_second = missing_heights(dimension, reach)
        constants.head = self.density * float(np.linalg.norm(self.gravity)) * self.spacing
        constants.beyond_first, constants.beyond_second = ops.beyond
        constants.density, constants.volume, constants.mass = self.density, self.volume, self.mass
        constants.viscous_factor = self.viscosity * ops.laplacian
        constants.relaxation_time = self.relaxation_time
        constants.collision_distance = self.collision_distance
        return constants

    def launch(self, kernel: Any, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        """Launch a kernel over `count` particles of the run, if there are any."""
        if count:
            wp.launch(kernel, count, inputs, outputs, device=self.device)


def fluid_model(scene: Scene, particles: Particles, *, types: NumericTypes, device: Any) -> FluidModel:
    """The constants of a scene's fluids.

    Args:
        scene: The case.
        particles: Its particles; walls come first, fluids last.
        types: Number types.
        device: Warp device.

    Raises:
        InputError: The domain of the scene does not hold its fluids.
    """
    fluid, flow = scene.fluids[0], scene.flow
    scheme, clip = SCHEMES[flow.scheme], int(flow.negative_pressure == "clipped")
    ops = operators(types.dimension, fluid.spacing, flow.radius(types.dimension))
    limit, implicit = step_limit(scene, particles)
    low, high = domain(scene, particles)
    mass = fluid.liquid.density * fluid.spacing**types.dimension
    return FluidModel(
        particles=particles,
        types=types,
        device=device,
        walls=particles.count - particles.liquid,
        count=particles.liquid,
        operators=ops,
        spacing=fluid.spacing,
        density=fluid.liquid.density,
        viscosity=fluid.liquid.viscosity,
        gravity=scene.gravity_vector,
        scheme=scheme,
        gradient_factor=ops.original_gradient if scheme == KOSHIZUKA_OKA else ops.gradient,
        clip=clip,
        shifting=scheme == CORRECTED or (scheme == CONSERVATIVE and not clip),
        collision_distance=(KEPT_APART if scheme == CONSERVATIVE else COLLISION) * fluid.spacing,
        courant=flow.courant,
        step_limit=limit,
        longest_step=min(limit, scene.time_step or math.inf),
        implicit_viscosity=implicit,
        tolerance=flow.tolerance,
        low=low,
        high=high,
        periodic=flow.periodic,
        axes=scene.frame.axes,
        no_slip=wp.array(_no_slip(scene, particles), dtype=wp.int32, device=device),
        collision_share=wp.array(_collision_share(particles, mass), dtype=types.real, device=device),
    )


def _no_slip(scene: Scene, particles: Particles) -> np.ndarray:
    """1 for fluid particles and for walls without slip, shape [n]; elastic bodies have slip."""
    no_slip = np.array([wall.slip == "no" for wall in scene.walls] or [False])[particles.walls]
    no_slip[: particles.elastic] = False
    no_slip |= np.arange(particles.count) >= particles.count - particles.liquid
    return no_slip.astype(np.int32)


def _collision_share(particles: Particles, mass: float) -> np.ndarray:
    """Shares of the fluid particles of a mass [kg] in collisions with walls and markers, shape [max(w, 1)]."""
    shares, elastic = np.ones(max(particles.count - particles.liquid, 1)), particles.elastic
    masses = particles.masses[:elastic]
    shares[:elastic] = masses / (masses + mass)
    return shares

"""The interface of fluid and elastic bodies: markers at the spacing of the fluid, which are wall particles to it.

Where a body's particles are finer than the fluid's, by a whole factor k, a marker stands for those in a cell of the
fluid's spacing, k^d of them, at their mean position and with their mean velocity; otherwise it stands for one particle.
Where a body is no whole number of cells thick, a cell in its middle holds fewer. A force on a marker is distributed
evenly to its particles, which conserves the force and its moment about the mean position.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.interface_kernels import interface_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles

# rounding of a lattice against its cells, in spacings
ROUNDING = 1e-6
# tolerance of the distance of lattice neighbours from a spacing, and of their angle from a right one
CLOSE = 1e-3


class Markers:
    """The markers of the elastic particles of a scene.

    Attributes:
        count: Number of markers.
        of_particle: Marker of each elastic particle, shape [elastic].
        elastic: Number of elastic particles.
        particles: The particles of the scene with the markers in the place of the elastic ones.
        bodies: Index of the body of each marker, shape [count].
        masses: Masses of the markers [kg], shape [count].
        densities: Densities of their bodies [kg/m^3], shape [count].

    Args:
        particles: The particles of the scene.
        spacing: Particle spacing of the fluid [m].
        types: Number types.
        device: Warp device.
    """

    def __init__(self, particles: Particles, spacing: float, *, types: NumericTypes, device: Any) -> None:
        self._kernels, self._device = interface_kernels(types), device
        of_particle = _cells(particles, spacing)
        members = np.argsort(of_particle, kind="stable")
        sizes = np.bincount(of_particle)
        self.of_particle, self._sizes = of_particle, sizes
        self.count, self.elastic = len(sizes), particles.elastic
        first = np.concatenate(([0], np.cumsum(sizes)))
        self.particles = _gathered(particles, members, first, spacing)
        self.bodies, self.masses = self.particles.bodies[: self.count], self.particles.masses[: self.count]
        cells = particles.masses[: self.elastic] / particles.spacings[: self.elastic] ** types.dimension
        self.densities = np.add.reduceat(cells[members], first[:-1]) / sizes
        vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)

        def array(values: Any, dtype: Any) -> wp.array:
            return wp.array(values, dtype=dtype, device=device)

        self._rows = [array(first, wp.int32), array(members, wp.int32)]
        self._reference = array(particles.positions[: particles.elastic], vec64)
        self._mass = array(particles.masses[: particles.elastic], wp.float64)

    def transfer_motion(self, state: ElasticState, ahead: wp.array, x: wp.array, u: wp.array) -> None:
        """Launch positions and velocities of the markers.

        Args:
            state: State of the bodies.
            ahead: Time by which they are moved on with their velocities [s], float64 [1].
            x: Positions of wall particles and fluid [m], vec; the first ones are written.
            u: Their velocities [m/s], vec; the first ones are written.
        """
        self._launch("transfer_motion", [*self._rows, self._reference, ahead, state.u, state.v], [x, u])

    def find_accelerations(self, dt: wp.array, before: wp.array, state: ElasticState, a: wp.array) -> None:
        """Launch the mean accelerations of the markers over a step.

        Args:
            dt: Time step [s], float64 [1].
            before: Velocities of the bodies' particles before it [m/s], vec.
            state: State of the bodies after it.
            a: Accelerations of wall particles [m/s^2], vec; the first ones are written.
        """
        self._launch("accelerate", [*self._rows, dt, before, state.v], [a])

    def transfer_forces(self, force: wp.array, external: wp.array) -> None:
        """Launch the transfer of forces on the markers to the bodies' particles.

        Args:
            force: Forces on the markers [N], vec64 [count].
            external: Forces on the particles [N], vec; the elastic ones are written.
        """
        self._launch("transfer_forces", [*self._rows, force], [external])

    def apply_collisions(
        self,
        state: ElasticState,
        works: list[wp.array],
        *,
        free: wp.array,
        dt: wp.array,
        impulses: tuple[wp.array, wp.array],
        external: wp.array,
        u_before: wp.array,
    ) -> None:
        """Launch the change of the particles' velocities by collisions, and the works of a step.

        Args:
            state: State of the bodies after the step; its velocities are changed.
            works: Works of pressures, and of collisions on free and on held axes [J], float64 [count]; added to.
            free: 1 on axes that are free, 0 on those that a support holds, vec [elastic].
            dt: Time step [s], float64 [1].
            impulses: Impulses on the markers before and after the step, collisions included [N s], vec64 [count].
            external: Forces of the fluid on the particles in the step [N], vec.
            u_before: Displacements of the particles before the step [m], vec.
        """
        inputs = [*self._rows, self._mass, free, dt, *impulses, external, u_before, state.u]
        self._launch("apply_collisions", inputs, [state.v, *works])

    def distribute(self, values: np.ndarray) -> np.ndarray:
        """Values of the markers distributed evenly to their particles, shape [elastic, d]."""
        return (values / self._sizes[:, None])[self.of_particle]

    def _launch(self, name: str, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(getattr(self._kernels, name), self.count, inputs, outputs, device=self._device)


def _cells(particles: Particles, spacing: float) -> np.ndarray:
    """Marker of each elastic particle, numbered from 0 in the order in which the particles come, shape [elastic]."""
    markers = np.zeros(particles.elastic, np.int64)
    count = 0
    for first, last in particles.ranges[: particles.elastic_bodies]:
        x, own = particles.positions[first:last], float(particles.spacings[first])
        cells = _cells_of(x @ _axes(x, own), own, spacing) if own < (1.0 - ROUNDING) * spacing else x
        _, begin, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        # numbered by their first particle, so that neighbours in space are near in memory
        rank = np.argsort(np.argsort(begin))
        markers[first:last] = count + rank[inverse.ravel()]
        count += len(begin)
    return markers


def _cells_of(x: np.ndarray, own: float, spacing: float) -> np.ndarray:
    """The cell of each particle of a body, shape [n, d]: whole ones on its faces, the remainder in the middle.

    The fluid must see every face half a spacing before the first markers: a cell of fewer particles there would have
    its marker so near to the fluid that it repels it.
    """
    low = x.min(axis=0) - 0.5 * own
    extent = (x.max(axis=0) + 0.5 * own - low) / spacing
    whole = np.floor(extent + ROUNDING)
    rest = np.maximum(extent - whole, 0.0)
    places = (x - low) / spacing
    beyond = places > np.ceil(0.5 * whole) + rest
    return np.floor(places + np.where(beyond, 1.0 - rest, 0.0) + ROUNDING).astype(np.int64)


def _axes(x: np.ndarray, spacing: float) -> np.ndarray:
    """Directions of the lattice that particles lie on, in columns; those of the scene if they lie on none."""
    dimension = x.shape[1]
    arms = (x - x[0]) / spacing
    found: list[np.ndarray] = []
    for arm in arms[np.abs(np.linalg.norm(arms, axis=1) - 1.0) < CLOSE]:
        if all(abs(arm @ other) < CLOSE for other in found):
            found.append(arm)
    if len(found) == dimension - 1 and dimension == 2:  # a single row
        found.append(np.array([-found[0][1], found[0][0]]))
    if len(found) < dimension:
        return np.eye(dimension)
    return np.array(found[:dimension]).T


def _gathered(particles: Particles, members: np.ndarray, first: np.ndarray, spacing: float) -> Particles:
    """The particles of a scene with markers in the place of the elastic ones."""
    elastic, count, starts = particles.elastic, len(first) - 1, first[:-1]
    sizes = np.diff(first)
    rows: dict[str, Any] = {}
    for item in fields(particles):
        values = getattr(particles, item.name)
        if item.name in ("names", "ranges", "elastic", "liquid", "displaced"):
            continue
        own = values[members]
        if item.name in ("positions", "velocities", "angular_velocities"):
            own = np.add.reduceat(own, starts) / sizes[:, None]
        else:
            own = np.add.reduceat(own, starts) if item.name == "masses" else own[starts]
        rows[item.name] = np.concatenate((own, values[elastic:]))
    rows["spacings"][:count] = spacing
    ends = np.cumsum(np.bincount(rows["bodies"], minlength=len(particles.names)))
    ranges = np.column_stack((np.concatenate(([0], ends[:-1])), ends))
    return replace(particles, elastic=count, ranges=ranges, **rows)

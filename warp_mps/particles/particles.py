"""The particles of a scene in their reference configuration."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Particles:
    """The particles of a scene in their reference configuration, body after body, each sorted by cell.

    The elastic bodies come first, then the walls, then the fluids; all count as bodies here.

    Attributes:
        names: Names of the bodies, in order.
        ranges: First and one past the last particle of each body, shape [bodies, 2].
        elastic: Number of elastic particles, the first ones.
        liquid: Number of fluid particles, the last ones; those in between are of walls.
        positions: Reference positions X [m], shape [n, dimension].
        velocities: Initial velocities [m/s], shape [n, dimension].
        angular_velocities: Initial angular velocities [rad/s], shape [n, 1] in 2-D and [n, 3] in 3-D.
        masses: Masses [kg], in 2-D [kg/m], shape [n]; of walls nominal ones, by `NOMINAL_DENSITY`.
        spacings: Particle spacing l0 [m], shape [n].
        bodies: Index of the body of each particle, shape [n].
        materials: Index of the material of each particle in those of the scene, -1 for walls, shape [n].
        groups: Index of the group of bonded bodies of each particle, shape [n]; all walls are one.
        ids: Identifiers, unique in the scene and independent of the order, shape [n].
        displaced: Name of a fluid, name of a body or wall, and number of particles of the fluid that gave way to it.
    """

    names: tuple[str, ...]
    ranges: np.ndarray
    elastic: int
    liquid: int
    positions: np.ndarray
    velocities: np.ndarray
    angular_velocities: np.ndarray
    masses: np.ndarray
    spacings: np.ndarray
    bodies: np.ndarray
    materials: np.ndarray
    groups: np.ndarray
    ids: np.ndarray
    displaced: tuple[tuple[str, str, int], ...] = ()

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.positions)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[1])

    @property
    def elastic_bodies(self) -> int:
        """Number of elastic bodies."""
        return int(np.sum(self.ranges[:, 1] <= self.elastic))

    @property
    def walls(self) -> np.ndarray:
        """Index in `Scene.walls` of the wall of each particle, -1 for others, shape [n]."""
        walls = np.maximum(self.bodies - self.elastic_bodies, -1)
        walls[self.count - self.liquid :] = -1
        return walls

    def describe(self, index: int) -> str:
        """Description of a particle: its identifier, its body and its reference position."""
        place = ", ".join(f"{value:.6g}" for value in self.positions[index])
        return f"particle {int(self.ids[index])} of body '{self.names[int(self.bodies[index])]}' (from ({place}) m)"

    def remarks(self) -> list[str]:
        """A line for each solid that a fluid was drawn into, with the number of particles that gave way."""
        return [
            f"{fluid}: {count} particle{'s give' if count > 1 else ' gives'} way to {solid}, which it was drawn into"
            for fluid, solid, count in self.displaced
        ]

    def elastic_part(self) -> Particles:
        """The elastic particles alone."""
        return self._first(self.elastic)

    def dry_part(self) -> Particles:
        """The elastic particles and those of walls."""
        return self._first(self.count - self.liquid)

    def _first(self, count: int) -> Particles:
        """The first bodies, of so many particles, which are not of fluids."""
        if count == self.count:
            return self
        bodies = int(np.sum(self.ranges[:, 1] <= count))
        rows = {item.name: getattr(self, item.name)[:count] for item in fields(self) if item.name not in _WHOLE}
        return Particles(names=self.names[:bodies], ranges=self.ranges[:bodies], elastic=self.elastic, liquid=0, **rows)


# fields without one row per particle
_WHOLE = ("names", "ranges", "elastic", "liquid", "displaced")

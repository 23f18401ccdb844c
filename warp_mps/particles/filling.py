"""Particles: what the shapes of a scene become when they are filled on a lattice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.velocity_fields import velocity
from warp_mps.scene import Body, Fluid, Load, Scene, Support, Wall
from warp_mps.scene.validation.scene import place
from warp_mps.shapes import Points, Shape, contains, fill, particle_count

# a face of a region holds the particles that lie on it, whatever the rounding
REGION_TOLERANCE = 1e-6
# in particle spacings: bodies that touch put no particle deeper than this below each other's surface, and none closer
# to another's particle than half a spacing
SURFACE = 1e-3
OVERLAP = 0.499
# of walls, whose mass is never felt: it only lets them be weighted as bodies are
NOMINAL_DENSITY = 1000.0


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
        ids: Identifiers, stable whatever the order, unique in the scene, shape [n].
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
        """What a person calls a particle: its identifier, its body, and where it comes from."""
        place = ", ".join(f"{value:.6g}" for value in self.positions[index])
        return f"particle {int(self.ids[index])} of body '{self.names[int(self.bodies[index])]}' (from ({place}) m)"

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


# what has no row a particle
_WHOLE = ("names", "ranges", "elastic", "liquid")


def count_particles(scene: Scene) -> dict[str, int]:
    """Number of particles of each body, wall and fluid, at most, found without filling anything."""
    return {
        item.name: particle_count(
            item.shape, item.spacing, scene.dimension, item.node_axes, where=place(item, kind_of(item))
        )
        for item in scene.filled
    }


def fill_scene(scene: Scene) -> Particles:
    """Fill the bodies, the walls and the fluids of a scene with particles.

    Raises:
        InputError: A body or a wall is thinner than one particle, a body overlaps another or a wall, or a part holds
            no particle.
    """
    bodies = [_fill_body(scene, body) for body in scene.bodies]
    parts = [*bodies, *_fill_walls(scene), *(_fill_body(scene, fluid) for fluid in scene.fluids)]
    counts = np.array([len(positions) for positions, _, _ in parts])
    ends = np.cumsum(counts)
    of_body = np.repeat(np.arange(len(parts)), counts)
    spacings = np.array([item.spacing for item in scene.filled])[of_body]
    positions = np.concatenate([positions for positions, _, _ in parts])
    materials = _materials(scene, positions, of_body)
    # the last is that of the walls
    densities = np.array([*(material.density for material in scene.materials), NOMINAL_DENSITY])[materials]
    for fluid, (first, last) in zip(scene.fluids[::-1], np.column_stack((ends - counts, ends))[::-1], strict=False):
        densities[first:last] = fluid.liquid.density
    particles = Particles(
        names=tuple(item.name for item in scene.filled),
        ranges=np.column_stack((ends - counts, ends)),
        elastic=int(counts[: len(scene.bodies)].sum()),
        liquid=int(counts[len(counts) - len(scene.fluids) :].sum()),
        positions=positions,
        velocities=np.concatenate([velocities for _, velocities, _ in parts]),
        angular_velocities=np.concatenate([spins for _, _, spins in parts]),
        masses=densities * spacings**scene.dimension,
        spacings=spacings,
        bodies=of_body,
        materials=materials,
        groups=_groups(scene)[of_body],
        ids=np.arange(int(ends[-1])),
    )
    _refuse_overlap(scene, particles)
    _refuse_loose_bonds(scene, particles)
    return particles


def select(particles: Particles, region: Shape, bodies: tuple[str, ...] = ()) -> np.ndarray:
    """Indices of the elastic particles whose reference position lies in a region.

    Args:
        particles: The particles.
        region: The region; its faces belong to it.
        bodies: Names of the bodies to look at, all when empty.
    """
    part = slice(particles.elastic)
    inside = contains(region, particles.positions[part], REGION_TOLERANCE * float(particles.spacings[part].min()))
    if bodies:
        inside &= np.isin(particles.bodies[part], [particles.names.index(name) for name in bodies])
    return np.flatnonzero(inside)


def select_held(particles: Particles, item: Support | Load) -> np.ndarray:
    """Indices of the particles that a support holds or a load acts on.

    Raises:
        InputError: There is none.
    """
    found = select(particles, item.region, item.bodies)
    if len(found) == 0:
        kind = "support" if isinstance(item, Support) else "load"
        raise InputError(
            place(item, kind), "region", f"the {kind} holds no particle: its region must reach into a body"
        )
    return found


def _fill_body(scene: Scene, body: Body | Fluid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, velocities and angular velocities of the particles of a body or a fluid."""
    where = place(body, kind_of(body))
    positions = fill(body.shape, body.spacing, scene.dimension, node_axes=body.node_axes, where=where)
    velocities = np.zeros_like(positions)
    if isinstance(body.shape, Points) and body.shape.velocities is not None:
        velocities += np.asarray(body.shape.velocities, float)[:, : scene.dimension]
    if body.velocity is not None:
        velocities += np.asarray(body.velocity, float)
    if body.velocity_field is not None:
        velocities += velocity(body.velocity_field, positions)
    spins = np.zeros((len(positions), 2 * scene.dimension - 3))
    if body.angular_velocity is not None:
        spins += np.atleast_1d(np.asarray(body.angular_velocity, float))
        velocities += _spin_velocity(spins, positions - positions.mean(axis=0))
    order = _cell_order(positions, body.spacing * scene.elasticity.effective_radius)
    return positions[order], velocities[order], spins[order]


def _fill_walls(scene: Scene) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """As of bodies, at rest; where a wall shares space with earlier ones, their particles stay and its own go."""
    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for wall in scene.walls:
        where = place(wall, "wall")
        positions = fill(wall.shape, wall.spacing, scene.dimension, node_axes=wall.node_axes, where=where)
        for other, (others, _, _) in zip(scene.walls, parts, strict=False):
            same = contains(Points(others), positions, OVERLAP * 0.5 * (wall.spacing + other.spacing))
            positions = positions[~same]
            if not len(positions):
                raise InputError(where, "shape", f"lies inside {place(other, 'wall')}: nothing of it is left")
        positions = positions[_cell_order(positions, wall.spacing * scene.elasticity.effective_radius)]
        parts.append((positions, np.zeros_like(positions), np.zeros((len(positions), 2 * scene.dimension - 3))))
    return parts


def _materials(scene: Scene, positions: np.ndarray, of_body: np.ndarray) -> np.ndarray:
    """Index of the material of each particle: its body's, or that of the last part that it lies in; else -1.

    Raises:
        InputError: A part is left without a particle.
    """
    counts = [len(body.materials) for body in scene.bodies]
    firsts = np.cumsum([0, *counts[:-1]])
    materials = np.append(firsts, np.full(len(scene.walls) + len(scene.fluids), -1))[of_body]
    for own, body in enumerate(scene.bodies):
        numbered = list(enumerate(body.parts, start=int(firsts[own]) + 1))
        for number, part in numbered:
            inside = contains(part.region, positions, REGION_TOLERANCE * body.spacing)
            materials[inside & (of_body == own)] = number
        for number, part in numbered:
            if number not in materials:
                reason = f"the part holds no particle of body {body.name!r}, or later parts cover it"
                raise InputError(place(part, "part"), "region", reason)
    return materials


def _spin_velocity(spins: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Velocity omega x r, in 2-D with omega along the normal."""
    if arms.shape[1] == 2:
        return spins * np.column_stack((-arms[:, 1], arms[:, 0]))
    return np.cross(spins, arms)


def _cell_order(positions: np.ndarray, cell: float) -> np.ndarray:
    """Order by cells of a few neighbours' width: what is near in space is then near in memory."""
    cells = np.floor((positions - positions.min(axis=0)) / (2.0 * cell) + 1e-9).astype(np.int64)
    return np.lexsort((*positions.T[::-1], *cells.T[::-1]))


def _groups(scene: Scene) -> np.ndarray:
    """Index of the group of each body: those that are bonded share one, so do all walls, and all fluids."""
    names = [body.name for body in scene.bodies]
    groups = np.arange(len(names))
    for i, body in enumerate(scene.bodies):
        for name in body.bonded_to:
            j = names.index(name)
            if not np.isclose(scene.bodies[j].spacing, body.spacing, rtol=1e-9, atol=0.0):
                raise InputError(
                    place(body, "body"), "spacing", f"differs from that of {name!r}, which it is bonded to"
                )
            groups[groups == groups[j]] = groups[i]
    n = len(names)
    return np.concatenate((groups, np.full(len(scene.walls), n), np.full(len(scene.fluids), n + 1)))


def _refuse_loose_bonds(scene: Scene, particles: Particles) -> None:
    """Refuse a bond between bodies that have no two particles within the effective radius of each other."""
    for i, body in enumerate(scene.bodies):
        for name in body.bonded_to:
            j = particles.names.index(name)
            here, there = (particles.positions[slice(*particles.ranges[k])] for k in (i, j))
            reach = scene.elasticity.effective_radius * body.spacing
            if i == j or not contains(Points(there), here, reach).any():
                reason = f"names {name!r}, which it does not touch: no two particles are within {reach:.3g} m"
                raise InputError(place(body, "body"), "bonded_to", reason)


def _refuse_overlap(scene: Scene, particles: Particles) -> None:
    """Refuse a particle inside another body, or on top of another body's particle; walls may share space."""
    for a, b in _near(scene, particles):
        one, other = scene.filled[a], scene.filled[b]
        if isinstance(one, Wall) and isinstance(other, Wall):
            continue
        positions = particles.positions[slice(*particles.ranges[a])]
        others = particles.positions[slice(*particles.ranges[b])]
        mean_spacing = 0.5 * (one.spacing + other.spacing)
        near = np.all((positions > others.min(0) - mean_spacing) & (positions < others.max(0) + mean_spacing), axis=1)
        positions = positions[near]
        bad = contains(other.shape, positions, -SURFACE * mean_spacing)
        bad |= contains(Points(others), positions, OVERLAP * mean_spacing)
        if bad.any():
            at = ", ".join(f"{c:.6g}" for c in positions[np.argmax(bad)])
            reason = f"overlaps {place(other, kind_of(other))} at ({at}) m; bodies may touch but not share space"
            if Fluid in (type(one), type(other)):
                reason += "; a fluid about something is made of several that leave it out"
            raise InputError(place(one, kind_of(one)), "shape", reason)


def _near(scene: Scene, particles: Particles) -> Iterator[tuple[int, int]]:
    """Pairs of different bodies the boxes about whose particles come as near as a particle is wide."""
    parts = [particles.positions[slice(*bounds)] for bounds in particles.ranges]
    low, high = np.array([part.min(axis=0) for part in parts]), np.array([part.max(axis=0) for part in parts])
    spacings = np.array([item.spacing for item in scene.filled])
    for a, spacing in enumerate(spacings):
        margin = 0.5 * (spacing + spacings)[:, None]
        for b in np.flatnonzero(np.all((high[a] > low - margin) & (low[a] < high + margin), axis=1)):
            if a != b:
                yield a, int(b)


def kind_of(item: Body | Wall | Fluid) -> str:
    """What errors call it."""
    return "wall" if isinstance(item, Wall) else "fluid" if isinstance(item, Fluid) else "body"

"""Filling the bodies, walls and fluids of a scene with particles on regular lattices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warp_mps.errors import InputError
from warp_mps.particles.displaced_fluid import Solid, kept_of_fluid
from warp_mps.particles.met_faces import Fits
from warp_mps.particles.overlaps import OVERLAP, refuse_loose_bonds, refuse_overlap
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import REGION_TOLERANCE
from warp_mps.particles.velocity_fields import velocity
from warp_mps.scene import Body, Fluid, Scene, Wall
from warp_mps.scene.validation.rules import kind_of, place
from warp_mps.shapes import Points, contains, fill, particle_count

# density of wall particles [kg/m^3]: the mass of a wall has no effect, it only lets walls be weighted as bodies are
NOMINAL_DENSITY = 1000.0

# positions [m], velocities [m/s] and angular velocities [rad/s] of the particles of a body, wall or fluid
Filled = tuple[np.ndarray, np.ndarray, np.ndarray]


def count_particles(scene: Scene, *, exact: bool = False) -> dict[str, int]:
    """Number of particles of each body, wall and fluid, without keeping them.

    What gives way to others, of walls and fluids, is counted too.

    Args:
        scene: The case.
        exact: Whether shapes are filled, a few layers at a time; else the lattices that cover them are counted.
    """
    fits = Fits(scene)
    return {
        item.name: particle_count(
            item.shape,
            item.spacing,
            scene.dimension,
            item.node_axes,
            fit=fits.of(item),
            where=place(item, kind_of(item)),
            exact=exact,
        )
        for item in scene.filled
    }


def fill_scene(scene: Scene) -> Particles:
    """Fill the bodies, the walls and the fluids of a scene with particles.

    Fluids give way to the bodies and walls that they overlap.

    Raises:
        InputError: A body, wall or fluid is thinner than one particle, a body overlaps another or a wall, fluids
            overlap, nothing of a fluid is left beside bodies and walls, or a part holds no particle.
    """
    fits = Fits(scene)
    dry = [*(_fill_body(scene, body, fits) for body in scene.bodies), *_fill_walls(scene, fits)]
    solids: list[Body | Wall] = [*scene.bodies, *scene.walls]
    wet, displaced = _fill_fluids(scene, [(solid, part[0]) for solid, part in zip(solids, dry, strict=True)], fits)
    parts = [*dry, *wet]
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
        angular_velocities=np.concatenate([rates for _, _, rates in parts]),
        masses=densities * spacings**scene.dimension,
        spacings=spacings,
        bodies=of_body,
        materials=materials,
        groups=_groups(scene)[of_body],
        ids=np.arange(int(ends[-1])),
        displaced=displaced,
    )
    refuse_overlap(scene, particles)
    refuse_loose_bonds(scene, particles)
    return particles


def _lattice(scene: Scene, item: Body | Wall | Fluid, fits: Fits) -> np.ndarray:
    """Positions of the particles that fill a shape [m], shape [n, dimension]."""
    where = place(item, kind_of(item))
    return fill(item.shape, item.spacing, scene.dimension, node_axes=item.node_axes, fit=fits.of(item), where=where)


def _fill_body(scene: Scene, body: Body, fits: Fits) -> Filled:
    """Fill an elastic body."""
    positions = _lattice(scene, body, fits)
    return _started(scene, body, positions, np.ones(len(positions), bool))


def _fill_fluids(
    scene: Scene, solids: Sequence[Solid], fits: Fits
) -> tuple[list[Filled], tuple[tuple[str, str, int], ...]]:
    """Fill the fluids, which give way to solids; and which particles of them did, as in `Particles.displaced`."""
    parts, displaced = [], []
    for fluid in scene.fluids:
        positions = _lattice(scene, fluid, fits)
        kept, rows = kept_of_fluid(fluid, positions, solids)
        parts.append(_started(scene, fluid, positions, kept))
        displaced += rows
    return parts, tuple(displaced)


def _started(scene: Scene, item: Body | Fluid, positions: np.ndarray, kept: np.ndarray) -> Filled:
    """The particles of a body or a fluid that are kept, at their initial velocities, sorted by cell."""
    positions = positions[kept]
    velocities = np.zeros_like(positions)
    if isinstance(item.shape, Points) and item.shape.velocities is not None:
        velocities += np.asarray(item.shape.velocities, float)[kept, : scene.dimension]
    if item.velocity is not None:
        velocities += np.asarray(item.velocity, float)
    if item.velocity_field is not None:
        velocities += velocity(item.velocity_field, positions)
    rates = np.zeros((len(positions), 2 * scene.dimension - 3))
    if item.angular_velocity is not None:
        rates += np.atleast_1d(np.asarray(item.angular_velocity, float))
        velocities += _rotation_velocity(rates, positions - positions.mean(axis=0))
    order = _cell_order(positions, item.spacing * scene.elasticity.effective_radius)
    return positions[order], velocities[order], rates[order]


def _fill_walls(scene: Scene, fits: Fits) -> list[Filled]:
    """Fill the walls, at rest; where a wall shares space with earlier ones, their particles stay and its own go."""
    parts: list[Filled] = []
    for wall in scene.walls:
        positions = _lattice(scene, wall, fits)
        for other, (others, _, _) in zip(scene.walls, parts, strict=False):
            same = contains(Points(others), positions, OVERLAP * 0.5 * (wall.spacing + other.spacing))
            positions = positions[~same]
            if not len(positions):
                raise InputError(
                    place(wall, "wall"), "shape", f"lies inside {place(other, 'wall')}: nothing of it is left"
                )
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


def _rotation_velocity(rates: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Velocity omega x r, in 2-D with omega along the normal."""
    if arms.shape[1] == 2:
        return rates * np.column_stack((-arms[:, 1], arms[:, 0]))
    return np.cross(rates, arms)


def _cell_order(positions: np.ndarray, cell: float) -> np.ndarray:
    """Order by cells a few particles wide, so that neighbours in space are neighbours in memory."""
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

"""How a free body floats: its draught and its stability, by hydrostatics.

    rho V(draught) = M,    GM = KB + I/V - KG

V is the volume below the water line, I the second moment of the water plane about its centroid, K the lowest point,
B the centre of buoyancy, G the centre of gravity. The inside of a hull is dry below its rim: water rises into a place
only over the lowest way that leads to it.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import free_bodies
from warp_mps.scene import Scene

# cells of the box about a body up to which its inside is looked for
MOST_CELLS = 4_000_000
# cells about a body in its box: the outermost ones end the search, water comes from those beside them
MARGIN = 2
# in spacings: precision of the draught
PRECISION = 1e-9


@dataclass(frozen=True, kw_only=True)
class Flotation:
    """The equilibrium of a free body in still water, without turning it; bodies that are bonded float as one.

    Attributes:
        draught: Depth of its lowest point below the water line [m]; None where it sinks.
        drawn: The same as it is drawn, from the highest point of the fluids [m].
        displaced: Displaced volume in equilibrium [m^3], in 2-D area [m^2]; None where it sinks.
        metacentric_height: GM [m], in 3-D the lesser of both axes; below 0 it capsizes; None where it sinks.
    """

    draught: float | None
    drawn: float
    displaced: float | None
    metacentric_height: float | None


def flotations(scene: Scene, particles: Particles) -> dict[str, Flotation]:
    """How the bodies float that are free to, by name."""
    gravity = scene.gravity_vector
    if not scene.fluids or not scene.bodies or not gravity.any():
        return {}
    up = -gravity / np.linalg.norm(gravity)
    spacing = scene.fluids[0].spacing
    level = float((particles.positions[particles.count - particles.liquid :] @ up).max()) + 0.5 * spacing
    density, spacings = scene.fluids[0].liquid.density, {body.name: body.spacing for body in scene.bodies}
    found = {}
    for name, group in free_bodies(scene, particles).items():
        rows = np.isin(particles.bodies, group)
        x, masses = particles.positions[rows], particles.masses[rows]
        found[name] = flotation(x, masses, spacings[name], up, density, level)
    return found


def flotation(
    positions: np.ndarray, masses: np.ndarray, spacing: float, up: np.ndarray, density: float, level: float
) -> Flotation:
    """How particles float as one body.

    Args:
        positions: Positions [m], shape [n, d].
        masses: Masses [kg], in 2-D [kg/m], shape [n].
        spacing: Particle spacing [m].
        up: Unit vector against gravity, shape [d].
        density: Density of the liquid [kg/m^3].
        level: Height of its surface along `up` [m].
    """
    basis = _basis(up)
    x = positions @ basis.T
    keel = float(x[:, -1].min()) - 0.5 * spacing
    cells, floods = _cells(x, spacing)
    bottoms = cells[:, -1] - 0.5 * spacing - keel
    drawn = level - keel
    volume = spacing ** x.shape[1]
    draught = _draught(bottoms, floods - keel, spacing, volume, float(masses.sum()) / density)
    if draught is None:
        return Flotation(draught=None, drawn=drawn, displaced=None, metacentric_height=None)
    dry = floods - keel >= draught - PRECISION * spacing
    wet_part = np.clip((draught - bottoms) / spacing, 0.0, 1.0) * dry
    displaced = float(wet_part.sum()) * volume
    buoyancy = float(wet_part @ (bottoms + 0.5 * spacing * wet_part)) * volume / displaced
    gravity_centre = float(masses @ x[:, -1]) / float(masses.sum()) - keel
    near = 2.0 * PRECISION
    plane = cells[(wet_part > near) & (bottoms + spacing >= draught - near * spacing), :-1]
    moment = _least_moment(plane, spacing)
    height = buoyancy + moment / displaced - gravity_centre
    return Flotation(draught=draught, drawn=drawn, displaced=displaced, metacentric_height=height)


def _basis(up: np.ndarray) -> np.ndarray:
    """Rows of an orthonormal basis, the last one up; the others along axes of the scene where up is one."""
    others = np.eye(len(up))[np.argsort(np.abs(up), kind="stable")[: len(up) - 1]]
    full, _ = np.linalg.qr(np.column_stack((up, others.T)))
    return np.vstack((full.T[1:], up))


def _cells(x: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the cells of a body and of its insides [m], and the heights above which water fills them [m].

    The cells of the body itself are never filled.
    """
    low = x.min(axis=0)
    number = np.round((x - low) / spacing).astype(np.int64)
    shape = tuple((number.max(axis=0) + 1 + 2 * MARGIN).tolist())
    on_lattice = np.abs((x - low) / spacing - number).max() < 0.1
    if np.prod(shape, dtype=float) > MOST_CELLS or not on_lattice:
        return x, np.full(len(x), np.inf)
    solid = np.zeros(shape, bool)
    solid[tuple((number + MARGIN).T)] = True
    spill = _spill_layers(solid)
    inside = np.argwhere(~solid & (spill > np.arange(shape[-1])))
    tops = low[-1] + (spill[tuple(inside.T)] - MARGIN - 0.5) * spacing
    return np.vstack((x, low + (inside - MARGIN) * spacing)), np.concatenate((np.full(len(x), np.inf), tops))


def _spill_layers(solid: np.ndarray) -> np.ndarray:
    """Layer up to which water must rise to reach each cell of a box, its own where it flows in freely.

    Water comes from the sides and from below. Cells that it never reaches have the number of layers; those of the
    outermost layer of the box, which end the search, have 0.
    """
    layers = solid.shape[-1]
    spill = np.full(solid.size, layers)
    outermost, sides = np.ones(solid.shape, bool), np.ones(solid.shape, bool)
    outermost[(slice(1, -1),) * solid.ndim] = False
    sides[(slice(2, -2),) * (solid.ndim - 1) + (slice(2, None),)] = False
    spill[outermost.ravel()] = 0
    reached = (solid | outermost).ravel()
    sources = np.flatnonzero(sides.ravel() & ~reached)
    steps = np.array([sign * stride // solid.itemsize for stride in solid.strides for sign in (-1, 1)])
    waiting: list[list[np.ndarray]] = [[] for _ in range(layers)]
    for layer in range(layers):
        front = np.unique(np.concatenate([sources[sources % layers == layer], *waiting[layer]]))
        front = front[~reached[front]]
        while len(front):
            reached[front], spill[front] = True, layer
            beside = np.unique((front[:, None] + steps).ravel())
            beside = beside[~reached[beside]]
            above = beside[beside % layers > layer]
            # a step leads up by one layer at most
            if len(above):
                waiting[layer + 1].append(above)
            front = beside[beside % layers <= layer]
    return spill.reshape(solid.shape)


def _draught(bottoms: np.ndarray, floods: np.ndarray, spacing: float, volume: float, wanted: float) -> float | None:
    """The least draught at which the cells displace a volume; None where they never do.

    Between two draughts at which a place is flooded, the volume grows with the draught: it is found by bisection.
    """
    top = float(bottoms.max()) + spacing
    ends = np.unique(np.append(floods[floods < top], top))
    for low, high in itertools.pairwise([0.0, *ends.tolist()]):
        dry = bottoms[floods >= high]

        def displaced(draught: float, cells: np.ndarray = dry) -> float:
            return volume * float(np.clip((draught - cells) / spacing, 0.0, 1.0).sum())

        if displaced(high) < wanted * (1.0 - 1e-12):
            continue
        below, above = low, high
        while above - below > PRECISION * spacing:
            middle = 0.5 * (below + above)
            below, above = (middle, above) if displaced(middle) < wanted else (below, middle)
        return above
    return None


def _least_moment(plane: np.ndarray, spacing: float) -> float:
    """Least second moment of a water plane of cells about an axis through its centroid [m^4], in 2-D [m^3]."""
    if not len(plane):
        return 0.0
    arms = plane - plane.mean(axis=0)
    area = spacing ** plane.shape[1]
    tensor = area * (arms.T @ arms + len(plane) * spacing**2 / 12.0 * np.eye(plane.shape[1]))
    return float(np.linalg.eigvalsh(tensor)[0])

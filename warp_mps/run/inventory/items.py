"""What a body, a wall or a fluid of a case is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warp_mps.particles.lattice_fit import LatticeFit, lattice_fit
from warp_mps.particles.met_faces import Fits
from warp_mps.particles.particles import Particles
from warp_mps.run.inventory.flotation import Flotation
from warp_mps.run.inventory.gaps import Gap, gaps
from warp_mps.run.inventory.mass_properties import MassProperties, mass_properties
from warp_mps.scene import Body, Fluid, Scene, Wall
from warp_mps.scene.validation.rules import kind_of, place

ItemKind = Literal["body", "wall", "fluid"]


@dataclass(frozen=True, kw_only=True)
class PartShare:
    """The particles of a body that are of one material.

    Attributes:
        name: Name of the part; that of the body for its own material.
        particles: Number of particles.
        mass: Their mass [kg], in 2-D [kg/m].
    """

    name: str
    particles: int
    mass: float


@dataclass(frozen=True, kw_only=True)
class ItemCheck:
    """A body, a wall or a fluid.

    Attributes:
        name: Its name.
        kind: ``body``, ``wall`` or ``fluid``.
        path: Prim path, or kind and name where it was not read from a stage.
        spacing: Particle spacing l0 [m].
        size: Extent of the drawn shape along the axes of the scene [m], shape [dimension].
        size_in_stage: The same in the unit of length of the stage, None where that is the metre.
        low: Least coordinates of the drawn shape [m], shape [dimension].
        particles: Number of particles.
        mass: Its mass properties.
        parts: Shares of a body's materials, empty unless it has parts.
        lattice: How its particles lie in the drawn shape; None for ready-made particles.
        flotation: How it floats, if it is a free body in a scene of fluids with gravity, else None.
        gaps: Gaps to neighbours within two spacings, one for each side; walls are no neighbours of walls.
    """

    name: str
    kind: ItemKind
    path: str
    spacing: float
    size: tuple[float, ...]
    size_in_stage: tuple[float, ...] | None
    low: tuple[float, ...]
    particles: int
    mass: MassProperties
    parts: tuple[PartShare, ...]
    lattice: LatticeFit | None
    flotation: Flotation | None
    gaps: tuple[Gap, ...]

    @property
    def wet_sides(self) -> tuple[str, ...]:
        """Sides on which it is in touch with a fluid: ``-x``, ``+x``, ``-y``, ..."""
        return tuple(sorted({gap.side for gap in self.gaps if gap.wet}, key=lambda side: (side[1], side[0] == "+")))


def check_items(scene: Scene, particles: Particles, floating: Mapping[str, Flotation]) -> tuple[ItemCheck, ...]:
    """Bodies, walls and fluids of a scene, in the order of its particles; `floating` is how free bodies float."""
    fits, beside = Fits(scene), gaps(particles)
    return tuple(
        _item(scene, particles, number, item, fits, floating.get(item.name), beside[number])
        for number, item in enumerate(scene.filled)
    )


def _item(
    scene: Scene,
    particles: Particles,
    number: int,
    item: Body | Wall | Fluid,
    fits: Fits,
    floats: Flotation | None,
    beside: tuple[Gap, ...],
) -> ItemCheck:
    rows = slice(*particles.ranges[number])
    masses = None if isinstance(item, Wall) else particles.masses[rows]
    bounds = np.array([item.shape.interval(axis) for axis in np.eye(3)[: scene.dimension]])
    size, unit = bounds[:, 1] - bounds[:, 0], scene.frame.meters_per_unit
    return ItemCheck(
        name=item.name,
        kind=kind_of(item),
        path=place(item, kind_of(item)),
        spacing=item.spacing,
        size=tuple(size.tolist()),
        size_in_stage=None if unit == 1.0 else tuple((size / unit).tolist()),
        low=tuple(bounds[:, 0].tolist()),
        particles=int(rows.stop - rows.start),
        mass=mass_properties(particles.positions[rows], masses, particles.spacings[rows]),
        parts=_parts(scene, particles, item),
        lattice=lattice_fit(item, fits, particles.positions[rows]),
        flotation=floats if isinstance(item, Body) else None,
        gaps=beside,
    )


def _parts(scene: Scene, particles: Particles, item: Body | Wall | Fluid) -> tuple[PartShare, ...]:
    """Shares of the materials of a body that has several."""
    if not isinstance(item, Body) or not item.parts:
        return ()
    first = sum(len(body.materials) for body in scene.bodies[: scene.bodies.index(item)])
    shares = []
    for number, name in enumerate((item.name, *(part.name for part in item.parts)), start=first):
        masses = particles.masses[particles.materials == number]
        shares.append(PartShare(name=name, particles=len(masses), mass=float(masses.sum())))
    return tuple(shares)

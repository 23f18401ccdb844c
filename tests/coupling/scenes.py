"""Small scenes of water with elastic bodies in it that several tests share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tests.fluid.scenes import L0, LAYERS, box, walls_about
from warp_mps.core.device import load_modules, open_device
from warp_mps.core.types import numeric_types
from warp_mps.coupling import hydroelastic
from warp_mps.elastic import declare_kernels as elastic
from warp_mps.elastic.implicit.kernels import declare_implicit
from warp_mps.fluid import fluids
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Body, Contact, Fluid, Material, Scene, Support, TableMotion
from warp_mps.shapes import Box, Points, contains

SOFT = Material(1000.0, 5e5, 0.3)
ALONE = Contact(between="none")
# the two ways in which bodies follow the water, with what the implicit one needs
EXPLICIT: dict[str, Any] = {"integrator": "explicit"}
IMPLICIT: dict[str, Any] = {"integrator": "implicit", "contact": ALONE}
WAYS = (EXPLICIT, IMPLICIT)
RUBBING: dict[str, Any] = {"integrator": "explicit", "contact": Contact(between="all", friction=0.3)}


def lump(low: list[int], cells: list[int], *, ratio: int = 1, **fields: Any) -> Body:
    """A block of soft material on the lattice of the water.

    Args:
        low: Its lowest corner, in spacings of the water.
        cells: Its lengths, in spacings of the water.
        ratio: Particles along a spacing of the water.
        fields: Fields of the body.
    """
    shape = box(L0 * np.array(low), L0 * (np.array(low) + cells))
    return Body(**{"name": "lump", "shape": shape, "material": SOFT, "spacing": L0 / ratio, **fields})


def pool(*bodies: Body, cells: tuple[int, ...] = (10, 8), room: tuple[int, ...] | None = None, **fields: Any) -> Scene:
    """A tank with water in its corner at the origin wherever bodies are not, gravity along -y.

    Args:
        bodies: The bodies.
        cells: Particles of the water along each axis, if there were no bodies.
        room: Particles that the tank has room for along each axis, by default as many, and four more above.
        fields: Fields of the scene.
    """
    d = len(cells)
    x = np.stack(np.meshgrid(*(L0 * (np.arange(n) + 0.5) for n in cells), indexing="ij"), -1).reshape(-1, d)
    for body in bodies:
        x = x[~contains(body.shape, x, 1e-6 * L0)]
    water = Fluid(name="water", shape=Points(x), spacing=L0)
    size = L0 * np.array(room or [n + 4 * (axis == 1) for axis, n in enumerate(cells)], float)
    walls = walls_about(size, layers=LAYERS[d])
    given = {"gravity": (0.0, -9.81, 0.0)[:d], "dimension": d, "duration": 0.2, "frame_rate": 100.0, **fields}
    return Scene(bodies=bodies, walls=walls, fluids=(water,), **given)


def hung(dimension: int = 2, *, ratio: int = 1, **fields: Any) -> Scene:
    """A block in water whose upper rows are held: it is pushed and gives."""
    cells = (10, 9) if dimension == 2 else (7, 7, 5)
    low, size = ([3, 3], [3, 5]) if dimension == 2 else ([2, 2, 1], [3, 4, 3])
    body = lump(low, size, ratio=ratio)
    top = L0 * (low[1] + size[1])
    held = Box(size=[1.0] * dimension, center=[0.0, top + 0.5 - 1.01 * L0, 0.0][:dimension])
    return pool(body, cells=cells, supports=(Support(name="rod", region=held),), **fields)


def bed(dimension: int = 2, *, ratio: int = 1, **fields: Any) -> Scene:
    """A block all along the floor of a tank, the upper face of which is flat."""
    cells, size = ((14, 8), [14, 3]) if dimension == 2 else ((7, 6, 7), [7, 2, 7])
    return pool(lump([0] * dimension, size, ratio=ratio), cells=cells, **fields)


def afloat(density: float = 500.0, *, dimension: int = 2, material: Material = SOFT, **fields: Any) -> Scene:
    """A free block in still water."""
    cells, low, size = ((12, 8), [4, 3], [4, 3]) if dimension == 2 else ((6, 6, 6), [2, 2, 2], [2, 2, 2])
    body = lump(low, size, material=Material(density, material.youngs_modulus, material.poissons_ratio))
    return pool(body, cells=cells, **fields)


def busy(**fields: Any) -> Scene:
    """A heavy and a light block in a shaken tank: steps of all lengths, and contact where it is asked for."""
    heavy = lump([2, 1], [2, 3], name="heavy", material=Material(3000.0, 5e5, 0.3), velocity=(2.5, 0.0))
    light = lump([6, 4], [3, 4], ratio=2, name="light", material=Material(400.0, 5e5, 0.3))
    scene = pool(heavy, light, cells=(11, 7), **fields)
    times = np.linspace(0.0, 1.0, 41)
    shake = np.column_stack((0.02 * np.sin(25.0 * times), 0.0 * times))
    motion = TableMotion(times=times, displacements=shake, interpolation="cubic")
    return replace(scene, walls=tuple(replace(wall, motion=motion) for wall in scene.walls))


def system_of(scene: Scene, *, precision: str = "float64", graphs: bool = True) -> hydroelastic.Hydroelastic:
    """The water and the bodies of a scene on the CPU, started."""
    numbers, device = numeric_types(scene.dimension, precision), open_device("cpu")
    modules = [*fluids.declare_kernels(numbers), *elastic.declare_kernels(numbers), *declare_implicit(numbers)]
    load_modules(list(dict.fromkeys([*modules, *hydroelastic.declare_kernels(numbers)])), device)
    options: dict[str, Any] = {"types": numbers, "device": device, "graphs": graphs}
    made = hydroelastic.Hydroelastic(scene, fill_scene(scene), interval=1.0 / scene.frame_rate, **options)
    made.start()
    return made

"""Small scenes of water that several tests share, and what NumPy makes of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warp_mps.core.device import load_modules, open_device
from warp_mps.core.types import numeric_types
from warp_mps.fluid.fluids import Fluids, declare_kernels
from warp_mps.fluid.mirror_planes import SAME_FACE
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Flow, Fluid, Scene, Wall
from warp_mps.shapes import Box

KINDS = [(dimension, precision) for dimension in (2, 3) for precision in ("float64", "float32")]
SCHEMES = ("conservative", "corrected", "koshizuka_oka")
L0 = 0.02
LAYERS = {2: 4, 3: 3}
# time step of a single step that tests take [s]
DT = 1e-4


def box(low: np.ndarray | list[float], high: np.ndarray | list[float]) -> Box:
    """A box by its corners."""
    a, b = np.asarray(low, float), np.asarray(high, float)
    return Box((b - a).tolist(), (0.5 * (a + b)).tolist())


def water(low: list[float], high: list[float], *, name: str = "water", **fields: object) -> Fluid:
    """A box of water."""
    return Fluid(**{"name": name, "shape": box(low, high), "spacing": L0, **fields})  # type: ignore[arg-type]


def scene_of(*fluids: Fluid, dimension: int = 2, duration: float = 0.1, **fields: object) -> Scene:
    """A scene of some water."""
    return Scene(**{"fluids": fluids, "dimension": dimension, "duration": duration, **fields})  # type: ignore[arg-type]


def walls_about(size: np.ndarray, *, layers: int, lid: bool = False, **fields: object) -> tuple[Wall, ...]:
    """The walls of a tank from the origin to a corner, open above (along y) unless it has a lid."""
    t, dimension = layers * L0, len(size)
    low, high = np.full(dimension, -t), size + t
    walls = []
    for axis in (1, *(axis for axis in range(dimension) if axis != 1)):
        for side in ("low", "high"):
            if axis == 1 and side == "high" and not lid:
                high[1] = size[1]
                continue
            a, b = low.copy(), high.copy()
            a[axis], b[axis] = (-t, 0.0) if side == "low" else (size[axis], size[axis] + t)
            walls.append(Wall(name=f"{'xyz'[axis]}_{side}", shape=box(a, b), spacing=L0, **fields))  # type: ignore[arg-type]
        # what comes next stands between these
        low[axis], high[axis] = 0.0, size[axis]
    return tuple(walls)


def tank(
    cells: tuple[int, ...] = (8, 8),
    *,
    room: tuple[int, ...] | None = None,
    lid: bool = False,
    flow: Flow | None = None,
    wall: dict | None = None,
    fluid: dict | None = None,
    **fields: object,
) -> Scene:
    """A tank with a block of water in its corner at the origin, gravity along -y.

    Args:
        cells: Particles of the water along each axis.
        room: Particles that the tank has room for along each axis, by default as many.
        lid: Whether it is closed above.
        flow: How the water is computed.
        wall: Fields of the walls.
        fluid: Fields of the water.
        fields: Fields of the scene.
    """
    dimension = len(cells)
    body = water([0.0] * dimension, [L0 * n for n in cells], **(fluid or {}))
    walls = walls_about(L0 * np.array(room or cells, float), layers=LAYERS[dimension], lid=lid, **(wall or {}))
    gravity = [0.0, -9.81, 0.0][:dimension]
    return scene_of(
        body, **{"dimension": dimension, "walls": walls, "gravity": gravity, "flow": flow or Flow(), **fields}
    )  # type: ignore[arg-type]


def periodic_box(cells: tuple[int, ...], *, flow: Flow | None = None, **fields: object) -> Scene:
    """A block of water that repeats itself along all axes."""
    high = [L0 * n for n in cells]
    d = len(cells)
    flow = replace(flow or Flow(), domain=([0.0] * d, high), periodic=tuple(range(d)))
    return scene_of(water([0.0] * d, high), dimension=d, flow=flow, **fields)


def small(dimension: int) -> tuple[int, ...]:
    """Particles along the axes of a block that all kernels can be tried on."""
    return (8, 7) if dimension == 2 else (5, 5, 4)


def fluids_of(scene: Scene, *, precision: str = "float64", graphs: bool = True) -> Fluids:
    """The scene's fluids on the CPU, started."""
    numbers, device = numeric_types(scene.dimension, precision), open_device("cpu")
    load_modules(declare_kernels(numbers), device)
    fluids = Fluids(scene, fill_scene(scene), types=numbers, device=device, graphs=graphs)
    fluids.start()
    return fluids


def stir(fluids: Fluids, *, amount: float = 0.05, speed: float = 0.3, seed: int = 0) -> None:
    """Move the fluid's particles by parts of a spacing, and give them velocities [m/s]."""
    rng, w = np.random.default_rng(seed), wall_count(fluids)
    x, u = fluids.state.x.numpy(), fluids.state.u.numpy()
    x[w:] += amount * L0 * rng.uniform(-1.0, 1.0, x[w:].shape)
    u[w:] = speed * rng.uniform(-1.0, 1.0, u[w:].shape)
    fluids.state.x.assign(x)
    fluids.state.u.assign(u)
    fluids.step.renew_neighbours()


def wall_count(fluids: Fluids) -> int:
    """Number of particles of walls."""
    return len(fluids.state.x) - len(fluids.state.p)


def apart(x: np.ndarray, period: np.ndarray) -> np.ndarray:
    """x_ij between all points, the shortest where there is a period, shape [n, n, d]."""
    gap = x[None, :] - x[:, None]
    periodic = period > 0.0
    gap[..., periodic] -= period[periodic] * np.round(gap[..., periodic] / period[periodic])
    return gap


def pairs(fluids: Fluids) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x_ij, r (1 on the diagonal) and w of all particles with each other, 0 between walls, shape [n, n, ...]."""
    x, w = fluids.state.x.numpy().astype(float), wall_count(fluids)
    gap = apart(x, np.array(fluids.step.neighbours.period))
    r = np.linalg.norm(gap, axis=2)
    np.fill_diagonal(r, 1.0)
    weights = np.where(r < fluids.model.operators.radius, fluids.model.operators.radius / r - 1.0, 0.0)
    np.fill_diagonal(weights, 0.0)
    weights[:w, :w] = 0.0
    return gap, r, weights


def slopes(fluids: Fluids, r: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The pair weights of the gradient with its factor, c, of distances and weights that `pairs` gave."""
    ops = fluids.model.operators
    if SCHEMES[fluids.model.scheme] == "koshizuka_oka":
        return ops.original_gradient * weights / r**2
    return np.where(weights > 0.0, ops.gradient * (1.0 - r / ops.radius) ** 3 / ops.radius**2, 0.0)


def images(fluids: Fluids, gap: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Weights w of mirror images, of the planes that the fluids have found, shape [m, m]; `gap` and `r` of `pairs`."""
    w, radius = wall_count(fluids), fluids.model.operators.radius
    normal, depth = fluids.step.pressure.normal.numpy().astype(float), fluids.step.pressure.depth.numpy().astype(float)
    near = (gap[w:, w:] ** 2).sum(axis=2) < radius**2
    same = (depth[:, None] > 0.0) & (depth > 0.0) & (normal @ normal.T >= SAME_FACE)
    away = np.sqrt(r[w:, w:] ** 2 + 4.0 * depth[:, None] * depth)
    np.fill_diagonal(near, val=False)
    return np.where(near & same & (away < radius), radius / np.where(same, away, 1.0) - 1.0, 0.0)


def tolerance(precision: str, double: float = 1e-11, single: float = 2e-4) -> float:
    """What rounding may do in a precision."""
    return double if precision == "float64" else single


def total_momentum(fluids: Fluids, density: float = 1000.0) -> np.ndarray:
    """Momentum of the fluid [kg m/s], shape [d]."""
    d = fluids.state.x.numpy().shape[1]
    return density * L0**d * fluids.state.u.numpy()[wall_count(fluids) :].astype(float).sum(axis=0)


def until(fluids: Fluids, end: float, interval: float, look: Callable[[float], None] | None = None) -> None:
    """Advance to a time by intervals [s], looking after each of them."""
    for k in range(1, round(end / interval) + 1):
        fluids.advance(k * interval)
        if look:
            look(k * interval)


def predicted(fluids: Fluids, dt: float = DT) -> np.ndarray:
    """Acceleration of the fluid in the predictor [m/s^2], shape [m, d]."""
    w = wall_count(fluids)
    before = fluids.state.u.numpy().astype(float)[w:]
    fluids.step.time_step.dt.assign([dt])
    fluids.step.apply_viscosity()
    fluids.step.predict()
    return (fluids.state.u.numpy().astype(float)[w:] - before) / dt


def finished(fluids: Fluids, dt: float = DT) -> np.ndarray:
    """Change of the fluid's velocities in the end of a step, by collisions, shape [m, d]."""
    w = wall_count(fluids)
    before = fluids.state.u.numpy().astype(float)[w:]
    fluids.step.time_step.dt.assign([dt])
    fluids.step.collide()
    fluids.step.advance_clock()
    return fluids.state.u.numpy().astype(float)[w:] - before


def put(fluids: Fluids, rows: dict[int, tuple[list[float], list[float]]]) -> None:
    """Put particles of the fluid at positions, with velocities."""
    x, u, w = fluids.state.x.numpy().copy(), fluids.state.u.numpy().copy(), wall_count(fluids)
    for k, (position, velocity) in rows.items():
        x[w + k], u[w + k] = position, velocity
    fluids.state.x.assign(x)
    fluids.state.u.assign(u)
    fluids.step.renew_neighbours()

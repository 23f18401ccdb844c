"""Long runs of water: rest over many seconds, and dam breaks from many initial lattices."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import box, fluids_of, scene_of, until
from tests.fluid.scenes import wall_count as walls_of
from warp_mps.scene import Flow, Fluid, Scene, Wall

RHO, G = 1000.0, 9.81
GRAVITY = (0.0, -G)


def basin(
    width: float, height: float, spacing: float, water: tuple[list[float], list[float]], **fields: object
) -> Scene:
    """A tank, open above, with a box of water in it."""
    t = 4.0 * spacing
    sides = {"floor": ([-t, -t], [width + t, 0.0]), "left": ([-t, 0.0], [0.0, height])}
    sides["right"] = ([width, 0.0], [width + t, height])
    walls = tuple(Wall(name=name, shape=box(*corners), spacing=spacing) for name, corners in sides.items())
    fluid = Fluid(name="water", shape=box(*water), spacing=spacing)
    return scene_of(fluid, walls=walls, gravity=GRAVITY, **fields)


def still_water(spacing: float, end: float, scheme: str = "conservative") -> dict[str, float]:
    """What water of 0.4 x 0.4 m comes to; everything is the mean over the second half of the time.

    The root mean square error of the pressure over that of the depth, the error of the pressure on the floor, and of
    the force on it, the drift of the centre in spacings, and the kinetic energy per mass over g H.
    """
    depth = 0.4
    fluids = fluids_of(basin(depth, 0.5, spacing, ([0.0, 0.0], [depth, depth]), flow=Flow(scheme=scheme)))
    w, rows = walls_of(fluids), []

    def look(t: float) -> None:
        if t < 0.5 * end:
            return
        x, p, u = fluids.readings.positions(), fluids.pressures(), fluids.velocities()[w:]
        error = p[w:] - RHO * G * (depth - x[w:, 1])
        under = (np.abs(x[:w, 1] + 0.5 * spacing) < 1e-9) & (np.abs(x[:w, 0] - 0.5 * depth) < 0.25 * depth)
        rows.append(
            [
                np.mean(error**2) / (RHO * G * depth) ** 2,
                p[:w][under].mean() / (RHO * G * (depth + 0.5 * spacing)) - 1.0,
                -fluids.contact_forces()[:, 1].sum() / (RHO * G * depth**2) - 1.0,
                x[w:, 1].mean() / spacing - 0.5 * depth / spacing,
                0.5 * np.mean(np.sum(u**2, axis=1)) / (G * depth),
            ]
        )

    until(fluids, end, 0.05, look)
    assert fluids.readings.lost() == 0
    assert fluids.trouble() is None
    square, floor, force, drift, kinetic = np.mean(rows, axis=0)
    return {"rms": np.sqrt(square), "floor": floor, "force": force, "drift": drift, "kinetic": kinetic}


def dam_break(seed: int, scheme: str = "conservative", spacing: float = 0.02, end: float = 1.0) -> dict[str, float]:
    """A column that breaks, from a lattice that does not fit its tank, and what became of its particles.

    How many went through a wall, how many are lost, the largest rise of the energy over that of the column, the largest
    speed over that of a fall through the column's height, and the pressure solves that failed.
    """
    a = 20 * spacing
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.0, spacing, 2)
    high = low + np.array([a, 2.0 * a])
    fluids = fluids_of(basin(4.0 * a, 3.0 * a, spacing, (low.tolist(), high.tolist()), flow=Flow(scheme=scheme)))
    w, start = walls_of(fluids), fluids.energy().total
    outside, fastest, held = np.zeros(len(fluids.state.p), bool), 0.0, [start]

    def look(_: float) -> None:
        nonlocal fastest
        x = fluids.readings.positions()[w:]
        below = x[:, 1] < 3.0 * a
        outside[:] |= (x[:, 1] < 0.0) | (below & ((x[:, 0] < 0.0) | (x[:, 0] > 4.0 * a)))
        fastest = max(fastest, float(np.linalg.norm(fluids.velocities()[w:], axis=1).max()))
        held.append(fluids.energy().total)

    until(fluids, end, 0.01, look)
    course, done = np.array(held), fluids.statistics()
    scale = RHO * 2.0 * a**2 * G * a
    return {
        "through": int(outside.sum()),
        "lost": fluids.readings.lost(),
        "growth": float((course - np.minimum.accumulate(course)).max() / scale),
        "fastest": fastest / np.sqrt(2.0 * G * 2.0 * a),
        "unsolved": done.stagnated + done.exhausted,
    }


@pytest.mark.slow
@pytest.mark.parametrize(("spacing", "rms"), [(0.02, 0.02), (0.01, 0.01)])
def test_water_stays_at_rest_for_ten_seconds(spacing: float, rms: float) -> None:
    found = still_water(spacing, 10.0)
    assert found["rms"] < rms
    assert abs(found["floor"]) < 0.01
    assert abs(found["drift"]) < 0.5
    assert found["kinetic"] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_no_particle_goes_through_a_wall(seed: int) -> None:
    """A splash may fly over one."""
    found = dam_break(seed)
    assert found["through"] == 0
    assert found["lost"] < 5
    assert found["unsolved"] == 0
    assert found["growth"] < 0.01

"""A plate at its draught in water at rest stays where it is, also close to a wall."""

from __future__ import annotations

import pytest

import warp_mps as mps

L0 = 0.01
WIDTH, DEPTH, LENGTH, THICKNESS = 0.2, 0.06, 0.05, 0.03


def drift(left: float, duration: float) -> tuple[float, float]:
    """Motion of a plate a distance from the left wall along the level, and upwards [l0]."""
    walls = mps.tank((0.0, 0.0), (WIDTH, DEPTH + 0.04), L0, layers=4)
    shape = mps.Box.from_corners((left, DEPTH - L0), (left + LENGTH, DEPTH - L0 + THICKNESS))
    foam = mps.Material(density=1000.0 * L0 / THICKNESS, youngs_modulus=1e6, poissons_ratio=0.3)
    scene = mps.Scene(
        name="drift",
        bodies=(mps.Body(name="plate", shape=shape, material=foam, spacing=L0),),
        fluids=(mps.fill_to(DEPTH, walls),),
        walls=walls,
        contact=mps.Contact(between="none"),
        gravity=(0.0, -9.81),
        duration=duration,
    )
    simulation = mps.Simulation(scene)
    plate = slice(0, simulation.particles.elastic)
    start = simulation.positions[plate].mean(axis=0)
    simulation.run()
    x, y = (simulation.positions[plate].mean(axis=0) - start) / L0
    print(f"{left / L0:.0f} l0 from the wall, {duration} s: moved by {x:+.4f}, {y:+.4f} l0")
    return float(x), float(y)


def test_a_plate_beside_a_wall_stays_there() -> None:
    """It drifted by half a spacing in half a second; and its mirror image does the same."""
    x, y = drift(0.03, 0.5)
    assert abs(x) < 0.02
    assert abs(y) < 0.05
    mirrored, _ = drift(WIDTH - 0.03 - LENGTH, 0.5)
    assert mirrored == pytest.approx(-x, abs=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("left", [0.01, 0.03])
def test_a_plate_beside_a_wall_stays_there_for_long(left: float) -> None:
    x, y = drift(left, 5.0)
    assert abs(x) < 0.1
    assert abs(y) < 0.1

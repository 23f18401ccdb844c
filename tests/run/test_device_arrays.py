"""Device arrays of a running simulation, and the order of their rows."""

from __future__ import annotations

import numpy as np

from tests.coupling.scenes import EXPLICIT, lump
from tests.fluid.scenes import L0, scene_of, tank, walls_about, water
from warp_mps.run.simulation import Simulation


def test_rows_of_fluids_are_walls_and_then_what_the_order_says() -> None:
    simulation = Simulation(tank((6, 6)))
    arrays = simulation.device_arrays
    kept = arrays["fluid.positions"]
    while simulation.steps_done < 150:  # the particles have been sorted once
        simulation.advance(1)
    assert simulation.device_arrays["fluid.positions"] is kept
    order = arrays["fluid.order"].numpy()
    walls = simulation.particles.count - len(order)
    assert not np.array_equal(order, np.arange(len(order)))
    np.testing.assert_array_equal(kept.numpy()[:walls], simulation.positions[:walls])
    np.testing.assert_array_equal(kept.numpy()[walls:], simulation.positions[walls:][order])
    np.testing.assert_array_equal(arrays["fluid.velocities"].numpy()[walls:], simulation.velocities[walls:][order])
    np.testing.assert_array_equal(arrays["fluid.pressures"].numpy(), simulation.pressures[walls:][order])


def test_beside_bodies_markers_come_first() -> None:
    scene = scene_of(
        water([0.0, 0.0], [0.2, 0.1]),
        bodies=(lump([2, 7], [2, 2], ratio=2),),
        walls=walls_about(np.array([0.2, 0.2]), layers=4),
        gravity=(0.0, -9.81),
        **EXPLICIT,
    )
    simulation = Simulation(scene)
    simulation.advance(1)
    arrays = simulation.device_arrays
    elastic, fluid = simulation.particles.elastic, simulation.particles.liquid
    np.testing.assert_array_equal(arrays["solid.displacements"].numpy()[:elastic], simulation.displacements[:elastic])
    x = arrays["fluid.positions"].numpy()
    markers = len(x) - (simulation.particles.count - elastic)
    assert markers == elastic // 4
    np.testing.assert_allclose(x[:markers].mean(axis=0), simulation.positions[:elastic].mean(axis=0), atol=1e-3 * L0)
    order = arrays["fluid.order"].numpy()
    np.testing.assert_array_equal(x[-fluid:], simulation.positions[-fluid:][order])

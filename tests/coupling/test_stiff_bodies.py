"""Bodies of steel afloat: as stiff as a rigid body, and free to move."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.coupling.scenes import IMPLICIT, afloat, lump, pool, system_of
from tests.fluid.scenes import L0
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Material, Scene

STEEL = Material(500.0, 2.1e11, 0.3)


def statistics(simulation: Simulation) -> dict[str, Any]:
    """Statistics of the passes and of the bodies' solver."""
    record = simulation.record()
    return {**record["implicit"], **record["coupling"]}


def spinning(scene: Scene, speed: float) -> Scene:
    """A scene whose body turns at a speed [rad/s]."""
    return replace(scene, bodies=tuple(replace(body, angular_velocity=speed) for body in scene.bodies))


def test_steel_floats_as_rubber_does() -> None:
    """For 0.15 s, over which the rounding of its pair forces exceeds 1e-8 of the forces that act."""
    runs = [
        Simulation(afloat(500.0, material=material, **IMPLICIT))
        for material in (STEEL, replace(STEEL, youngs_modulus=1e8))
    ]
    for run in runs:
        run.advance(15)
    steel, rubber = (run.displacements[: run.particles.elastic] for run in runs)
    assert np.abs(steel).max() > 1e-3
    np.testing.assert_allclose(steel, rubber, atol=0.02 * np.abs(rubber).max())
    assert statistics(runs[0])["unconverged"] == 0


def test_the_passes_converge_for_steel_that_turns_fast() -> None:
    """Its step ends with forces of some 1e4 N that cancel: their part must not set the tolerance of the passes."""
    simulation = Simulation(spinning(afloat(500.0, material=STEEL, **IMPLICIT), 4.0))
    simulation.advance(10)
    found = statistics(simulation)
    assert found["unconverged"] == 0
    assert found["passes"] < 4.0
    # at the ends of its steps it is stretched a little, which the next step sheds: that is no energy of its motion
    assert simulation.energy.dissipated < 0.1 * simulation.energy.kinetic


def half_immersed(**fields: Any) -> Scene:
    """A block of steel, half as heavy as water, 4 particles wide and high, with 2 of them in the water."""
    return pool(lump([8, 4], [4, 4], material=STEEL), cells=(20, 6), room=(20, 12), **IMPLICIT, **fields)


def test_what_is_above_the_level_is_not_pushed() -> None:
    """Water at rest pushes nothing that is 1.5 spacings and more above its level, though it is within reach."""
    system = system_of(half_immersed())
    fluid, w = system.fluids.step, system.fluids.model.walls
    level, e = 6.0 * L0, system.markers.count
    fluid.state.p.assign(1000.0 * 9.81 * (level - fluid.state.x.numpy()[w:, 1]))
    fluid.time_step.dt.fill_(1e-3)
    fluid.assemble()
    before = fluid.state.impulse.numpy()[:e].copy()
    fluid.forces.find_slopes()
    fluid.forces.add_wall_impulse(e, fluid.time_step.dt, fluid.state.impulse, fluid.state.work)
    gained = fluid.state.impulse.numpy()[:e] - before
    above = fluid.state.x.numpy()[:e, 1] > level + 1.2 * L0
    assert above.sum() == 4
    assert np.abs(gained[above]).max() < 1e-12 * np.abs(gained).max()
    weight = 500.0 * 9.81 * 16.0 * L0**2
    assert gained[:, 1].sum() / 1e-3 == pytest.approx(weight, rel=0.05)


def level_of(simulation: Simulation) -> float:
    """Level of the water at rest with its present height of the centre of mass, around 8 immersed cells [m]."""
    fluid = slice(simulation.particles.count - simulation.particles.liquid, None)
    width, immersed, mean = 20.0 * L0, 8.0 * L0**2, simulation.positions[fluid, 1].mean()
    # (width level^2/2 - immersed (level - l0)) / (width level - immersed) = mean, the immersed centroid at about -l0
    b, c = -(immersed + mean * width), immersed * (L0 + mean)
    return float((-b + np.sqrt(b**2 - 2.0 * width * c)) / width)


@pytest.mark.long
def test_a_block_of_steel_keeps_its_draught() -> None:
    """For 5 s, in which it rolls over to float on an edge, as such a block does: half of it stays immersed."""
    simulation = Simulation(half_immersed(duration=5.0, frame_rate=20.0))
    part = slice(0, simulation.particles.elastic)
    heights = []
    for _ in range(100):
        simulation.advance(1)
        heights.append((simulation.positions[part, 1].mean() - level_of(simulation)) / L0)
    assert abs(np.mean(heights)) < 0.05
    assert statistics(simulation)["unconverged"] == 0

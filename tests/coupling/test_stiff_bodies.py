"""Bodies of steel afloat: as stiff as a rigid body, and free to move."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tests.coupling.scenes import IMPLICIT, afloat
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

"""Bodies that are too light for the coupling: the cause that is named, its remedy, and the remark beforehand."""

from __future__ import annotations

import pytest

from tests.coupling.scenes import IMPLICIT, afloat
from warp_mps.errors import RunError
from warp_mps.particles.filling import fill_scene
from warp_mps.run.remarks import remarks_on_case
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Material, Scene
from warp_mps.scene.validation.coupling import LEAST_DENSITY


def light(density: float) -> Scene:
    """A stiff block of a density [kg/m^3] in water."""
    return afloat(density, material=Material(density, 1e8, 0.3), **IMPLICIT)


def test_forces_that_run_away_are_the_cause_not_the_step_that_they_spoil() -> None:
    """A block of 0.01 of the water's density: no shorter time step helps, a density of 0.05 does."""
    with pytest.raises(RunError, match=r"coupling of water and bodies .* 0\.01 times as dense .* take 0\.05 or more"):
        Simulation(light(10.0)).advance(3)
    simulation = Simulation(light(1000.0 * LEAST_DENSITY))
    simulation.advance(3)
    assert simulation.record()["coupling"]["worst_residual"] < 0.01


def test_a_light_body_is_remarked() -> None:
    """Below the density from which on the passes converge, and not from there on."""

    def lines(density: float) -> list[str]:
        scene = light(density)
        return [line for line in remarks_on_case(scene, fill_scene(scene)) if "times as dense as the water" in line]

    assert lines(1000.0 * LEAST_DENSITY) == []
    assert lines(10.0)[0].startswith("body 'lump': is 0.01 times as dense as the water")

"""Remarks on fluid that nothing holds."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.particles.test_met_faces import cells, tank
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.unheld_fluid import remarks_on_unheld_fluid
from warp_mps.scene import Flow, Scene


def remarks(scene: Scene) -> list[str]:
    """Remarks on the fluid of a scene."""
    return remarks_on_unheld_fluid(scene, fill_scene(scene))


def with_water(low: list[float], high: list[float]) -> Scene:
    """The tank with other water in it, corners in spacings."""
    scene = tank(3.0, 20.0, 10.0)
    return replace(scene, fluids=(replace(scene.fluids[0], shape=cells(low, high)),))


@pytest.mark.parametrize(
    ("low", "high"), [([0.0, 0.0], [20.0, 10.0]), ([0.0, 0.0], [5.0, 9.0]), ([5.0, 30.0], [12.0, 35.0])]
)
def test_water_in_the_tank_and_a_drop_above_it_are_held(low: list[float], high: list[float]) -> None:
    assert remarks(with_water(low, high)) == []


def test_water_beside_the_tank_falls() -> None:
    (line,) = remarks(with_water([25.0, 0.0], [31.0, 5.0]))
    assert line == "fluid 'water': 30 particles have nothing below them, as at (1.275, 0.025) m: they fall out"


def test_water_across_a_side_is_remarked_outside() -> None:
    falls, runs = remarks(with_water([-9.0, 0.0], [20.0, 5.0]))
    assert "25 particles have nothing below them" in falls
    assert "nothing holds it towards low x" in runs


def test_a_side_that_is_missing_is_remarked_unless_the_domain_repeats_itself() -> None:
    scene = tank(3.0, 20.0, 10.0)
    scene = replace(scene, walls=scene.walls[:2])
    (line,) = remarks(scene)
    assert (
        line == "fluid 'water': nothing holds it towards high x, as at (0.975, 0.025) m: move it, or add a wall there"
    )
    assert remarks(replace(scene, flow=Flow(domain=([0.0, -1.0], [1.0, 2.0]), periodic=(0,)))) == []
    assert remarks(replace(scene, gravity=(0.0, 0.0))) == []

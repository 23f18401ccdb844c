"""Remarks on bodies that do not float as drawn, and on rows that shorten steps."""

from __future__ import annotations

from dataclasses import replace

import pytest

from warp_mps.particles.filling import fill_scene
from warp_mps.run.cost import estimate
from warp_mps.run.inventory.doubts import remarks_on_flotation, remarks_on_missing_contact, remarks_on_rows
from warp_mps.run.inventory.flotation import flotations
from warp_mps.run.remarks import remarks_on_case
from warp_mps.scene import Body, Contact, Fluid, Material, Scene, Support, tank
from warp_mps.shapes import Box

TANK = tank((0.0, 0.0), (0.4, 0.3), 0.01)
WATER = Fluid(name="water", shape=Box.from_corners((0.0, 0.0), (0.4, 0.1)), spacing=0.01)


def afloat(low: tuple[float, float], high: tuple[float, float], density: float) -> Scene:
    wood = Material(density=density, youngs_modulus=1e6, poissons_ratio=0.3)
    plank = Body(name="plank", shape=Box.from_corners(low, high), material=wood, spacing=0.01, path="/World/plank")
    return Scene(bodies=(plank,), fluids=(WATER,), walls=TANK, gravity=(0.0, -9.81), duration=1.0)


def remarks(scene: Scene) -> list[str]:
    particles = fill_scene(scene)
    return remarks_on_flotation(scene, particles, flotations(scene, particles))


def test_a_plank_at_its_draught_is_not_remarked() -> None:
    assert remarks(afloat((0.1, 0.08), (0.3, 0.12), 500.0)) == []


def test_a_plank_off_its_draught_is_remarked() -> None:
    assert remarks(afloat((0.1, 0.06), (0.3, 0.1), 500.0)) == [
        "/World/plank: floats at a draught of 0.02 m, 0.04 m are drawn: it rises by 0.02 m (2.0 spacings)"
    ]
    (line,) = remarks(afloat((0.1, 0.09), (0.3, 0.13), 750.0))
    assert line.endswith("it sinks by 0.02 m (2.0 spacings)")


def test_what_is_not_in_the_water_is_not_remarked() -> None:
    assert remarks(afloat((0.1, 0.2), (0.3, 0.24), 500.0)) == []


def test_a_pillar_is_remarked_to_capsize() -> None:
    (line,) = remarks(afloat((0.18, 0.04), (0.22, 0.16), 500.0))
    assert line.startswith("/World/plank: capsizes: its metacentric height is -0.02")


def unstopped(scene: Scene) -> list[str]:
    particles = fill_scene(scene)
    return remarks_on_missing_contact(scene, particles, flotations(scene, particles))


def test_a_body_that_sinks_without_contact_is_remarked_and_one_that_floats_or_is_held_is_not() -> None:
    stone, none = afloat((0.1, 0.06), (0.3, 0.1), 2000.0), Contact(between="none")
    (line,) = unstopped(replace(stone, contact=none))
    assert line.startswith("/World/plank: sinks, and contact is 'none' (mps:contact): it goes through walls")
    assert line in remarks_on_case(replace(stone, contact=none), fill_scene(stone))
    held = (Support(name="held", region=Box((1.0, 1.0))),)
    assert unstopped(stone) == unstopped(replace(stone, contact=none, supports=held)) == []
    assert unstopped(replace(afloat((0.1, 0.08), (0.3, 0.12), 500.0), contact=none)) == []
    (dry,) = unstopped(replace(stone, contact=none, fluids=()))
    assert dry.startswith("/World/plank: falls")
    assert unstopped(replace(stone, contact=none, fluids=(), walls=())) == []


def test_rows_that_shorten_steps_are_remarked_and_the_remedy_keeps_the_step() -> None:
    scene = Scene(fluids=(WATER,), walls=TANK, gravity=(0.0, -9.81), duration=0.1, frame_rate=100.0)
    particles = fill_scene(scene)
    assert remarks_on_rows(scene, particles) == []
    often = replace(scene, sample_rate=2000.0)
    (line,) = remarks_on_rows(often, particles)
    assert "steps of 0.0005 s, without them 0.001" in line
    assert line in remarks_on_case(often, particles)
    fixed = replace(scene, time_step=0.0005)
    assert remarks_on_rows(replace(often, time_step=0.0005), particles) == []
    steps = [estimate(replace(fixed, sample_rate=rate)).time_step.length for rate in (100.0, 1000.0, 2000.0)]
    assert steps == pytest.approx([0.0005] * 3)

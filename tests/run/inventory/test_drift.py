"""Remarks on bodies that drift in water at rest, and the remedy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.run.inventory.test_doubts import afloat
from warp_mps.particles.filling import fill_scene
from warp_mps.run.inventory.drift import remarks_on_drift
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Contact, Scene, Support
from warp_mps.shapes import Box


def remarks(scene: Scene) -> list[str]:
    return remarks_on_drift(scene, fill_scene(scene))


def plank(density: float = 500.0, low: float = 0.08) -> Scene:
    """A plank of 5 by 4 particles, 3 spacings from a wall."""
    scene = afloat((0.03, low), (0.08, low + 0.04), density)
    return replace(scene, contact=Contact(between="none"), frame_rate=20.0)


def test_a_body_afloat_is_remarked() -> None:
    (line,) = remarks(plank())
    assert line.startswith(
        "/World/plank: floats and is free along the level: water that has moved may move it by 0.0094 m (0.9"
    )


def test_what_sinks_or_is_dry_or_held_is_not() -> None:
    mooring = Support(name="mooring", region=Box.from_corners((0.0501, 0.0901), (0.0599, 0.1099)), axes=(0,))
    held = replace(plank(), supports=(mooring,))
    assert [remarks(scene) for scene in (plank(2000.0), plank(low=0.2), held)] == [[], [], []]


def test_the_support_of_the_remark_keeps_the_place() -> None:
    """On the axis along the level, at the middle: a plank above its draught goes on moving up and down."""
    mooring = Support(name="mooring", region=Box.from_corners((0.0501, 0.0901), (0.0599, 0.1099)), axes=(0,))
    simulation = Simulation(replace(plank(400.0), supports=(mooring,)))
    simulation.advance(8)
    moved = simulation.displacements[: simulation.particles.elastic].mean(axis=0)
    assert np.abs(moved[0]) < 1e-4
    assert np.abs(moved[1]) > 1e-5

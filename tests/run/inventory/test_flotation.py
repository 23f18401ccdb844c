"""Draught and metacentric height of bodies in water."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.coupling.scenes import lump, pool
from warp_mps.particles.filling import fill_scene
from warp_mps.run.inventory.flotation import Flotation, flotation, flotations
from warp_mps.scene import Support
from warp_mps.shapes import Box, Shape, Sphere, fill


def afloat(shape: Shape, spacing: float, density: float, dimension: int, level: float = 0.0) -> Flotation:
    """A shape of a density in water with its surface at a level, y up."""
    positions = fill(shape, spacing, dimension)
    masses = np.full(len(positions), density * spacing**dimension)
    return flotation(positions, masses, spacing, np.eye(dimension)[1], 1000.0, level)


def test_a_plank() -> None:
    """Breadth b, height h, relative density s: draught s h, GM = s h/2 + b^2/(12 s h) - h/2."""
    found = afloat(Box((0.4, 0.1)), 0.01, 600.0, 2, level=0.02)
    assert found.draught == pytest.approx(0.06)
    assert found.drawn == pytest.approx(0.07)
    assert found.displaced == pytest.approx(0.4 * 0.06)
    assert found.metacentric_height == pytest.approx(0.03 + 0.4**2 / (12 * 0.06) - 0.05)


def test_the_draught_lies_between_layers() -> None:
    assert afloat(Box((0.2, 0.1)), 0.02, 333.0, 2).draught == pytest.approx(0.0333)


def test_a_pillar_capsizes_and_lead_sinks() -> None:
    pillar = afloat(Box((0.1, 0.4)), 0.02, 500.0, 2)
    assert pillar.metacentric_height == pytest.approx(0.1 + 0.1**2 / (12 * 0.2) - 0.2)
    assert pillar.metacentric_height < 0.0
    lead = afloat(Box((0.1, 0.4)), 0.02, 11000.0, 2)
    assert (lead.draught, lead.displaced, lead.metacentric_height) == (None, None, None)


def test_a_raft_in_three_dimensions_turns_about_its_long_axis() -> None:
    found = afloat(Box((0.4, 0.1, 0.2)), 0.02, 500.0, 3)
    assert found.draught == pytest.approx(0.05)
    assert found.metacentric_height == pytest.approx(0.025 + 0.2**2 / (12 * 0.05) - 0.05)


def test_a_ball_of_half_the_density_floats_to_its_middle() -> None:
    found = afloat(Sphere(0.5), 0.05, 500.0, 3)
    assert found.draught == pytest.approx(0.5, rel=1e-6)
    # the metacentre of a sphere is its centre
    assert found.metacentric_height == pytest.approx(0.0, abs=0.01)


def test_a_hull_is_dry_below_its_rim() -> None:
    """A box of 0.6 x 0.4 with walls of 0.05 and an open top, of steel: V = M/rho as of the outer box."""
    hull = Box((0.6, 0.4)) - Box((0.5, 0.4), (0.0, 0.05))
    mass = 1000.0 * (0.6 * 0.4 - 0.5 * 0.35)
    found = afloat(hull, 0.025, 1000.0 * 2.0, 2)
    assert found.draught == pytest.approx(2.0 * mass / 1000.0 / 0.6)
    # heavier than what floats at the rim: water comes over it, and it sinks
    assert afloat(hull, 0.025, 4000.0, 2).draught is None


def test_a_hull_with_a_hole_in_its_floor_is_flooded() -> None:
    hull = Box((0.6, 0.4)) - Box((0.5, 0.4), (0.0, 0.05)) - Box((0.1, 1.0))
    assert afloat(hull, 0.025, 2000.0, 2).draught is None
    light = afloat(hull, 0.025, 500.0, 2)
    closed = afloat(Box((0.6, 0.4)) - Box((0.5, 0.4), (0.0, 0.05)), 0.025, 500.0, 2)
    assert light.draught is not None
    assert closed.draught is not None
    assert light.draught > 1.5 * closed.draught


def test_a_closed_cavity_is_dry() -> None:
    found = afloat(Box((0.4, 0.4)) - Box((0.2, 0.2)), 0.02, 1200.0, 2)
    assert found.draught == pytest.approx(1.2 * 0.12 / 0.4)


def test_only_free_bodies_float() -> None:
    block = lump([3, 3], [4, 4])
    scene = pool(block)
    assert list(flotations(scene, fill_scene(scene))) == [block.name]
    held = replace(scene, supports=(Support(name="all", region=Box((100.0, 100.0))),))
    assert flotations(held, fill_scene(held)) == {}
    weightless = replace(scene, gravity=())
    assert flotations(weightless, fill_scene(weightless)) == {}

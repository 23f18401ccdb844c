"""Bodies of two particles across: found in any shape, with the share of the deflection that they show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.elastic.hamiltonian.test_dilatation import deflection
from tests.scenes import HAMILTONIAN, RUBBER, SPRINGS, block, scene_of
from warp_mps.elastic.hamiltonian.thin_bodies import particles_across, remarks_on_thin_bodies, two_particle_bending
from warp_mps.particles.filling import fill_scene
from warp_mps.run.remarks import remarks_on_case
from warp_mps.scene import Scene
from warp_mps.shapes import Box, Sphere


def remarks(scene: Scene) -> list[str]:
    return remarks_on_thin_bodies(scene, fill_scene(scene))


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4, 0.45, 0.49, 0.499])
def test_the_share_that_is_told_is_that_of_the_model(nu: float) -> None:
    scene = scene_of(block(2, (20, 2)), plane="strain", elasticity=HAMILTONIAN)
    told = two_particle_bending(replace(RUBBER, poissons_ratio=nu), scene)
    assert told == pytest.approx(deflection(2, nu), abs=0.01)
    in_plane_stress = two_particle_bending(replace(RUBBER, poissons_ratio=nu), replace(scene, plane="stress"))
    assert in_plane_stress >= told


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_plate_of_two_rows_is_told_and_one_of_three_is_not(dimension: int) -> None:
    material, strained = replace(RUBBER, poissons_ratio=0.49), {"plane": "strain", "elasticity": HAMILTONIAN}
    two, three = (
        scene_of(block(dimension, (20, rows, 12)[:dimension], material=material), dimension=dimension, **strained)
        for rows in (2, 3)
    )
    assert remarks(three) == []
    (line,) = remarks(two)
    for part in ("body 'block'", "about 0.56 of what it should", "a spacing of 0.00667 m"):
        assert part in line
    assert line in remarks_on_case(two, fill_scene(two))
    assert remarks(replace(two, elasticity=SPRINGS)) == []


def test_the_remedy_that_is_told_works() -> None:
    assert deflection(2, 0.49) < 0.6
    assert deflection(3, 0.49) == pytest.approx(0.994, rel=0.03)


def test_a_ring_of_two_rows_is_told_and_a_disc_with_thin_tips_is_not() -> None:
    ring = block(2, shape=Sphere(0.1, (0.0, 0.0)) - Sphere(0.08, (0.0, 0.0)))
    disc = block(2, shape=Sphere(0.1, (0.0, 0.0)))
    assert len(remarks(scene_of(ring, elasticity=HAMILTONIAN))) == 1
    assert remarks(scene_of(disc, elasticity=HAMILTONIAN)) == []


def test_a_layer_of_two_rows_that_is_bonded_to_a_body_is_not_thin() -> None:
    layer = block(2, name="layer", shape=Box((0.2, 0.02), (0.0, 0.01)), bonded_to=("base",))
    base = block(2, name="base", shape=Box((0.2, 0.06), (0.0, -0.03)))
    scene = scene_of(layer, base, elasticity=HAMILTONIAN)
    assert np.unique(particles_across(fill_scene(scene))).tolist() == [8]
    assert remarks(scene) == []

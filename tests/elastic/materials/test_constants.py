"""Lame's constants and wave speeds against their relations to other moduli."""

from __future__ import annotations

import math

import pytest

from warp_mps.elastic.materials.constants import lame_constants, pressure_wave_speed
from warp_mps.scene import Material

RUBBER = Material(1000.0, 1e7, 0.3)


@pytest.mark.parametrize(("dimension", "plane"), [(2, "strain"), (3, "strain"), (3, "stress")])
def test_constants_in_space_and_plane_strain(dimension: int, plane: str) -> None:
    """In 3-D the bulk modulus is E / (3 (1 - 2 nu)); plane strain is a state of 3-D."""
    lame, mu = lame_constants(RUBBER, dimension, plane)
    assert mu == pytest.approx(1e7 / 2.6)
    assert lame + 2 * mu / 3 == pytest.approx(1e7 / (3 * 0.4))


def test_constants_in_plane_stress() -> None:
    """A sheet pulled along x has E = stress / strain, and gets thinner along y by nu."""
    lame, mu = lame_constants(RUBBER, 2, "stress")
    assert mu == pytest.approx(1e7 / 2.6)
    strain = (1e-3, -0.3e-3)
    stress = [lame * sum(strain) + 2 * mu * part for part in strain]
    assert stress == pytest.approx([1e4, 0.0], abs=1e-8)


def test_wave_speed_without_lateral_strain_is_that_of_a_rod() -> None:
    material = Material(2000.0, 8e9, 0.0)
    for dimension, plane in ((2, "stress"), (2, "strain"), (3, "strain")):
        assert pressure_wave_speed(material, dimension, plane) == pytest.approx(2000.0)


def test_wave_speed_of_a_body() -> None:
    """c_p = sqrt(E (1 - nu) / (rho (1 + nu)(1 - 2 nu)))."""
    expected = math.sqrt(1e4 * 0.7 / (1.3 * 0.4))
    assert pressure_wave_speed(RUBBER, 3, "strain") == pytest.approx(expected)

"""Remarks on bodies that have gone into walls or each other at the end of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import warp_mps as mps
from warp_mps.particles.filling import fill_scene
from warp_mps.run.penetrations import remarks_on_penetrations
from warp_mps.scene import Scene

L0 = 0.01
RUBBER = mps.Material(density=1200.0, youngs_modulus=6e4, poissons_ratio=0.3)


def standing(contact: str = "none", **fields: object) -> Scene:
    """Two blocks beside each other on a floor, which they touch."""
    shapes = {"one": ((0.0, 0.0), (0.04, 0.04)), "two": ((0.05, 0.0), (0.09, 0.04))}
    bodies = tuple(
        mps.Body(name=name, shape=mps.Box.from_corners(*corners), material=RUBBER, spacing=L0)
        for name, corners in shapes.items()
    )
    floor = mps.Wall(name="floor", shape=mps.Box.from_corners((-0.05, -0.03), (0.15, 0.0)), spacing=L0)
    given = {"bodies": bodies, "walls": (floor,), "contact": mps.Contact(between=contact), "duration": 0.1}  # type: ignore[arg-type]
    return Scene(name="blocks", **{**given, **fields})  # type: ignore[arg-type]


def moved(scene: Scene, name: str, by: tuple[float, float]) -> list[str]:
    """Remarks where a body has moved by a vector in spacings."""
    particles = fill_scene(scene)
    x = particles.positions.copy()
    x[slice(*particles.ranges[particles.names.index(name)])] += np.multiply(by, L0)
    return remarks_on_penetrations(scene, particles, x)


def test_bodies_that_stand_on_walls_are_not_remarked() -> None:
    assert moved(standing(), "one", (0.0, 0.0)) == moved(standing(), "one", (-0.5, 0.3)) == []


def test_a_body_that_sinks_into_the_floor_is_remarked() -> None:
    (line,) = moved(standing(), "one", (0.0, -0.65))
    assert line.startswith("body 'one': 4 particles went into 'floor', by 0.65 spacings at (")
    assert line.endswith("contact is 'none' (mps:contact): use 'bodies'")
    (line,) = moved(standing("bodies"), "one", (0.0, -0.65))
    assert line.endswith("raise contact.stiffness (mps:contactStiffness), or take a smaller spacing")


def test_bodies_that_go_into_each_other_are_remarked() -> None:
    (line,) = moved(standing(), "two", (-1.5, 0.0))
    assert line.startswith("body 'one': 4 particles went into 'two', by 0.50 spacings at (0.035, ")


def test_a_soft_flap_that_its_weight_presses_into_the_floor_says_so(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A strip, clamped at its left end, hangs down to a floor just below it; there is no contact."""
    soft = mps.Material(density=1200.0, youngs_modulus=6e4, poissons_ratio=0.3)
    strip = mps.Body(name="strip", shape=mps.Box.from_corners((0.0, 0.0), (0.2, 0.03)), material=soft, spacing=L0)
    floor = mps.Wall(name="floor", shape=mps.Box.from_corners((0.1, -0.03), (0.3, 0.0)), spacing=L0)
    clamp = mps.Support(name="clamp", region=mps.Box.from_corners((-0.01, -0.01), (0.02, 0.04)))
    scene = Scene(
        name="strip",
        bodies=(strip,),
        walls=(floor,),
        supports=(clamp,),
        contact=mps.Contact(between="none"),
        gravity=(0.0, -9.81),
        duration=0.1,
    )
    summary = mps.run_scene(scene, tmp_path)
    (line,) = [line for line in summary.remarks if "went into 'floor'" in line]
    assert line in capfd.readouterr().err

"""The check of a case."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import warp_mps as mps
from tests.coupling.scenes import lump, pool
from tests.scenes import HAMILTONIAN, beam
from warp_mps.errors import InputError
from warp_mps.run.inventory.case_check import check
from warp_mps.scene import Material, Part, StageFrame, Support
from warp_mps.shapes import Box

BLOCK = lump([3, 3], [4, 4])


def test_bodies_walls_and_fluids_are_told_back() -> None:
    found = check(pool(BLOCK))
    assert [item.kind for item in found.items] == ["body", *["wall"] * (len(found.items) - 2), "fluid"]
    body, water = found.items[0], found.items[-1]
    assert body.particles == 16
    assert body.size == pytest.approx((4 * body.spacing, 4 * body.spacing))
    assert body.mass.mass == pytest.approx(BLOCK.material.density * body.mass.volume)
    assert water.mass.mass == pytest.approx(1000.0 * water.mass.volume)
    assert body.size_in_stage is None
    assert all(item.mass.mass is None for item in found.items[1:-1])
    assert found.item(body.name) is body
    with pytest.raises(KeyError, match="'none' is not one of"):
        found.item("none")


def test_sizes_are_also_in_units_of_the_stage() -> None:
    """A dropped unit shows: a beam in millimetres is a thousand times as small in metres."""
    scene = beam(4, stage=StageFrame(axes="xy", meters_per_unit=0.001))
    item = check(scene).items[0]
    assert item.size_in_stage == pytest.approx(tuple(1000.0 * length for length in item.size))


def test_materials_of_a_body_have_shares() -> None:
    scene = beam(4)
    steel = Material(density=7800.0, youngs_modulus=1e9, poissons_ratio=0.3)
    body = scene.bodies[0]
    half = Part(name="half", region=Box((1.0, 1.0), (-0.5 + 0.08, 0.0)), material=steel)
    scene = replace(scene, bodies=(replace(body, parts=(half,)),))
    own, part = check(scene).items[0].parts
    assert (own.name, part.name) == (body.name, "half")
    assert own.particles == part.particles
    assert part.mass / own.mass == pytest.approx(7800.0 / body.material.density)


def test_the_check_is_public_and_is_json() -> None:
    found = mps.check(beam(4))
    assert isinstance(found, mps.CaseCheck)
    data = json.loads(found.to_json())
    assert data["items"][0]["particles"] == found.items[0].particles
    assert data["cost"]["time_step"]["steps"] == found.cost.time_step.steps
    np.testing.assert_allclose(data["items"][0]["mass"]["centre"], found.items[0].mass.centre)
    json.loads(mps.check(pool()).to_json())


def test_what_a_run_would_refuse_is_refused() -> None:
    scene = beam(4)
    with pytest.raises(InputError, match="the support holds no particle"):
        check(replace(scene, supports=(Support(name="far", region=Box((0.1, 0.1), (9.0, 9.0))),)))
    with pytest.raises(InputError, match="GiB are available"):
        check(replace(scene, bodies=(replace(scene.bodies[0], spacing=1e-8),)))
    with pytest.raises(InputError, match="must be a Scene"):
        check("dam_break")  # type: ignore[arg-type]


def test_the_check_is_text() -> None:
    """What the command prints, the remarks last."""
    lines = str(check(pool(BLOCK))).splitlines()
    assert lines[0].endswith("(2-D, plane strain, dynamic, fluid scheme conservative, model hamiltonian)")
    assert any(re.match(r"longest time step +\S+ s, limited by CFL number 0.2 at", line) for line in lines)
    assert any(re.match(r"  draught +\S+ m in equilibrium, \S+ m as drawn$", line) for line in lines)
    assert any(re.match(r"steps of the bodies +", line) for line in lines)
    static = beam(4, analysis="static", elasticity=HAMILTONIAN)
    assert re.search(r"load step +0.1, limited by mps:loadSteps", str(check(static)))

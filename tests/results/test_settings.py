"""The settings of a case in run.json: all that decides it, with units, as plain values."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.scenes import RUBBER
from warp_mps.results.settings import scene_settings
from warp_mps.scene import Body, Fluid, Liquid, Load, Probe, Scene, TableMotion, Wall
from warp_mps.shapes import Box
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.shipped_cases import shipped_cases


def solid() -> Scene:
    beam = Body(name="beam", shape=Box((0.4, 0.1)), material=RUBBER, spacing=0.02)
    motion = TableMotion(times=np.array([0.0, 1.0]), displacements=np.zeros((2, 2)))
    paddle = Wall(name="paddle", shape=Box((0.1, 0.1), center=(0.0, 1.0)), spacing=0.02, motion=motion)
    push = Load(name="push", region=Box((0.1, 1.0), center=(0.2, 0.0)), force=(0.0, -3.0))
    return Scene(
        bodies=(beam,),
        walls=(paddle,),
        loads=(push,),
        probes=(Probe(name="tip", point=(0.19, 0.0)),),
        gravity=(0.0, -9.81),
        duration=0.5,
        description="a beam",
    )


def test_names_carry_the_units_of_the_documentation() -> None:
    found = scene_settings(solid())
    assert found["duration [s]"] == 0.5
    assert found["gravity [m/s^2]"] == [0.0, -9.81]
    assert found["description"] == "a beam"
    beam = found["bodies"]["beam"]
    assert beam["spacing [m]"] == 0.02
    assert beam["shape"] == {"kind": "Box", "size [m]": [0.4, 0.1], "center [m]": [0.0, 0.0]}
    assert beam["material"]["youngs_modulus [Pa]"] == RUBBER.youngs_modulus
    assert beam["material"]["poissons_ratio"] == RUBBER.poissons_ratio
    # in a plane forces are per metre of depth
    assert found["loads"]["push"]["force [N/m]"] == [0.0, -3.0]
    paddle = found["walls"]["paddle"]["motion"]
    assert (paddle["kind"], paddle["times [s]"], paddle["displacements [m]"]) == (
        "TableMotion",
        [0, 1],
        [[0, 0], [0, 0]],
    )
    assert found["probes"]["tip"]["point [m]"] == [0.19, 0.0]


def test_what_a_method_that_is_not_used_would_take_is_left_out() -> None:
    found = scene_settings(solid())
    assert "elasticity" in found
    assert not {"flow", "load_steps", "theta", "time_step [s]"} & set(found)
    water = Fluid(name="water", shape=Box((0.4, 0.2)), liquid=Liquid(density=998.0), spacing=0.02)
    found = scene_settings(Scene(fluids=(water,), duration=1.0))
    assert found["fluids"]["water"]["liquid"]["density [kg/m^3]"] == 998.0
    assert found["flow"]["scheme"] == "conservative"
    assert not {"elasticity", "contact", "plane"} & set(found)


@pytest.mark.parametrize("name", shipped_cases())
def test_the_settings_of_every_shipped_case_are_plain(name: str) -> None:
    scene = read_stage(shipped_cases()[name])
    found = scene_settings(scene)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert [*found.get("bodies", {}), *found.get("walls", {}), *found.get("fluids", {})] == [
        item.name for item in scene.filled
    ]

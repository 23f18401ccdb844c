"""Scenes of fluids: refusals and their messages, remarks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from tests.refusals import Fields, assert_refused, named
from tests.scenes import block
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Flow, Fluid, Liquid, Load, Probe, Scene, Support, VelocityField, Wall
from warp_mps.scene.validation.fluids import remarks
from warp_mps.shapes import Box

WATER = Fluid(name="water", shape=Box((0.4, 0.2), (0.0, 0.1)), spacing=0.02, path="/World/water")
FLOOR = Wall(name="floor", shape=Box((0.6, 0.08), (0.0, -0.04)), spacing=0.02, path="/World/floor")
BOX = ((0.0, 0.0), (1.0, 1.0))
REGION = Box((1.0, 1.0))
POINT = {"point": (0.0, 0.1)}
GREEN = VelocityField(kind="taylor_green", amplitude=(0.0, 1.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=1.0)
STRAIN = VelocityField(kind="stagnation", rate=-100.0, axis=(1.0, 0.0), origin=(0.0, 0.0))
WAVE = replace(GREEN, kind="standing_wave", depth=0.5)


def scene(**fields: Any) -> Scene:
    """Water on a floor, with some fields replaced."""
    good = {"fluids": (WATER,), "walls": (FLOOR,), "gravity": (0.0, -9.81), "duration": 1.0, "path": "/World"}
    return Scene(**{**good, **fields})


def fluid(**fields: Any) -> dict[str, Any]:
    """Fields of a scene whose fluid is another one."""
    return {"fluids": (replace(WATER, **fields),)}


def second(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with two fluids."""
    other = replace(WATER, name="drop", shape=Box((0.1, 0.1), (0.0, 0.5)), path="/World/drop")
    return {"fluids": (WATER, replace(other, **fields))}


def flow(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with other choices of the flow."""
    return {"flow": Flow(**fields)}


def probe(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a probe."""
    return {"probes": (Probe(**{"name": "tip", "path": "/World/tip", **fields}),)}


# made late: a record refuses what is wrong in itself
BROKEN: list[tuple[str, str, str, Fields]] = [
    ("/World", "bodies", "needs a body or a fluid", lambda: {"fluids": ()}),
    ("liquid", "density", "above 0", lambda: fluid(liquid=Liquid(density=0.0))),
    ("/World/oil", "density", "above 0", lambda: fluid(liquid=Liquid(density=-1.0, path="/World/oil"))),
    ("/World/oil", "viscosity", "at least 0", lambda: fluid(liquid=Liquid(viscosity=-1e-6, path="/World/oil"))),
    ("/World/water", "spacing", "above 0", lambda: fluid(spacing=0.0)),
    ("/World/water", "name", "letters, digits", lambda: fluid(name="sea water")),
    ("/World/water", "node_axes", "among x, y and z", lambda: fluid(node_axes=(5,))),
    ("/World/water", "velocity", "2 finite numbers", lambda: fluid(velocity=(1.0, 0.0, 0.0))),
    ("/World/water", "angular_velocity", "1 finite numbers", lambda: fluid(angular_velocity=(0.0, 0.0, 1.0))),
    (
        "/World/water",
        "velocity_field.rate",
        "'stagnation' needs it",
        lambda: fluid(velocity_field=replace(STRAIN, rate=None)),
    ),
    (
        "/World/water",
        "velocity_field.length",
        "it takes rate",
        lambda: fluid(velocity_field=replace(STRAIN, length=1.0)),
    ),
    ("/World/water", "velocity_field.mode", "is not used by", lambda: fluid(velocity_field=replace(STRAIN, mode=2))),
    ("/World/water", "velocity_field.depth", "is not used by", lambda: fluid(velocity_field=replace(GREEN, depth=1.0))),
    ("velocity field", "length", "above 0", lambda: fluid(velocity_field=replace(GREEN, length=0.0))),
    (
        "/World/water",
        "velocity_field.amplitude",
        "right angles",
        lambda: fluid(velocity_field=replace(GREEN, amplitude=(0.1, 1.0))),
    ),
    (
        "/World/water",
        "velocity_field.amplitude",
        "has no length",
        lambda: fluid(velocity_field=replace(GREEN, amplitude=(0.0, 0.0))),
    ),
    ("/World/water", "velocity_field.depth", "needs it", lambda: fluid(velocity_field=replace(WAVE, depth=None))),
    ("velocity field", "depth", "above 0", lambda: fluid(velocity_field=replace(WAVE, depth=-1.0))),
    ("/World/drop", "spacing", "is 0.025 m and that of /World/water 0.02 m", lambda: second(spacing=0.025)),
    ("/World/drop", "density", "and that of /World/water 1000 kg/m^3", lambda: second(liquid=Liquid(density=998.0))),
    ("/World/drop", "viscosity", "all fluids must be of one liquid", lambda: second(liquid=Liquid(viscosity=0.0))),
    ("/World/drop", "name", "is used twice", lambda: second(name="water")),
    ("/World/water", "name", "is also that of a wall", lambda: fluid(name="floor")),
    (
        "/World/floor",
        "spacing",
        "is 0.0201 m, must be that of /World/water, 0.02 m",
        lambda: {"walls": (replace(FLOOR, spacing=0.0201),)},
    ),
    ("flow", "scheme", "must be one of: conservative", lambda: flow(scheme="upwind")),
    ("flow", "negative_pressure", "must be one of: clipped, allowed", lambda: flow(negative_pressure="some")),
    ("flow", "effective_radius", "between 1.5 and 4.1", lambda: flow(effective_radius=4.2)),
    ("flow", "effective_radius", "between 1.5 and 4.1", lambda: flow(effective_radius=0.0)),
    ("flow", "tolerance", "at most 0.1", lambda: flow(tolerance=0.0)),
    ("flow", "tolerance", "at most 0.1", lambda: flow(tolerance=0.2)),
    ("flow", "tolerance", "at most 0.1", lambda: flow(tolerance=float("nan"))),
    ("flow", "courant", "at most 1", lambda: flow(courant=1.5)),
    ("/World", "flow.domain.low", "2 finite numbers", lambda: flow(domain=((0.0,), (1.0, 1.0)))),
    ("/World", "flow.domain.high", "above the lowest corner", lambda: flow(domain=((0.0, 0.0), (1.0, 0.0)))),
    ("/World", "flow.periodic", "needs a domain", lambda: flow(periodic=(0,))),
    ("/World", "integrator", "requires elastic bodies", lambda: {"integrator": "implicit", "time_step": 1e-3}),
    ("/World", "flow.periodic", "different axes", lambda: flow(domain=BOX, periodic=(2,))),
    ("/World", "flow.periodic", "different axes", lambda: flow(domain=BOX, periodic=(1, 1))),
    (
        "/World",
        "flow.domain.high",
        "makes a period of 0.2 m, must be at least 0.204 m",
        lambda: flow(domain=((0.0, 0.0), (0.2, 1.0)), periodic=(0,)),
    ),
    (
        "/World",
        "flow.periodic",
        "must be empty in a scene with elastic bodies",
        lambda: {"bodies": (block(2),), "fluids": (), **flow(domain=BOX, periodic=(0,))},
    ),
    (
        "/World/grip",
        "region",
        "a support requires an elastic body",
        lambda: {"supports": (Support(name="grip", region=REGION, path="/World/grip"),)},
    ),
    (
        "load 'push'",
        "region",
        "a load requires",
        lambda: {"loads": (Load(name="push", region=REGION, force=(1.0, 0.0)),)},
    ),
    ("/World/tip", "quantity", "of: pressure, velocity, elevation", lambda: probe(quantity="displacement", **POINT)),
    ("/World/tip", "quantity", "must be one of: pressure", lambda: probe(quantity="elevation", region=REGION)),
    ("/World/tip", "quantity", "must be one of: position", lambda: probe(quantity="contact_force", body="water")),
    ("/World/tip", "quantity", "must be one of: position", lambda: probe(quantity="volume", body="floor")),
    ("/World/tip", "quantity", "requires gravity", lambda: {**probe(quantity="elevation", **POINT), "gravity": ()}),
    ("/World/tip", "about", "is missing", lambda: probe(quantity="contact_moment", body="floor")),
    (
        "/World/tip",
        "moves_with",
        "is 'water', must name a wall",
        lambda: probe(quantity="pressure", moves_with="water", **POINT),
    ),
    (
        "/World/tip",
        "moves_with",
        "is for a point",
        lambda: probe(quantity="pressure", moves_with="floor", region=REGION),
    ),
    ("/World", "damping", "requires an elastic body", lambda: {"damping": 0.1}),
    ("/World", "outputs", "require an elastic body", lambda: {"outputs": ("stress",)}),
]


@pytest.mark.parametrize(("where", "attribute", "reason", "fields"), BROKEN, ids=named)
def test_a_broken_scene_is_refused(where: str, attribute: str, reason: str, fields: Fields) -> None:
    assert_refused(lambda: scene(**fields()), where, attribute, reason)


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"walls": (), "gravity": ()},
        {"walls": (replace(FLOOR, spacing=0.02 * (1.0 + 1e-7)),)},
        second(liquid=Liquid(path="/World/oil")),
        fluid(velocity=(1.0, 0.0), angular_velocity=2.0, velocity_field=STRAIN),
        fluid(velocity_field=GREEN),
        fluid(velocity_field=WAVE),
        probe(quantity="elevation", moves_with="floor", **POINT),
        probe(quantity="volume", body="water"),
        probe(quantity="contact_moment", body="floor", about=(0.0, 1.0)),
        flow(scheme="corrected", effective_radius=4.1, tolerance=0.1, courant=1.0, domain=BOX, periodic=(0, 1)),
    ],
)
def test_a_good_scene_is_taken(fields: dict[str, Any]) -> None:
    assert scene(**fields).path == "/World"


def test_what_a_fluid_lacks_is_remarked() -> None:
    assert remarks(scene()) == []
    assert remarks(scene(walls=())) == ["no walls: nothing holds the fluid"]
    assert remarks(scene(gravity=(0.0, 0.0))) == ["no gravity: the fluid has no weight"]
    assert len(remarks(scene(walls=(), gravity=()))) == 2
    wall = scene().walls[0]
    thin = replace(wall, shape=Box((1.0, 2.0 * wall.spacing), (0.0, -1.0)), path="/World/Shelf")
    (line,) = remarks(scene(walls=(thin,)))
    assert line.startswith("/World/Shelf: is 2 particles thick")
    assert "3 separate them" in line
    assert remarks(Scene(bodies=(block(2),), duration=1.0)) == []
    assert remarks(scene(duration=0.02, frame_rate=0.5))[0].startswith("ends at 2 s: ")
    assert remarks(scene(duration=0.02, frame_rate=0.5, sample_rate=50.0)) == []


@pytest.mark.parametrize("scheme", ["corrected", "koshizuka_oka"])
def test_a_scheme_that_stirs_water_between_walls_is_remarked(scheme: str) -> None:
    (line,) = remarks(scene(**flow(scheme=scheme)))
    speed = 0.2 * math.sqrt(9.81 * WATER.spacing)
    assert line == (
        f"scheme '{scheme}' does not conserve momentum: water at rest below a free surface comes to move at "
        f"some {speed:.2g} m/s, and a run that gains energy in that way ends; take 'conservative'"
    )
    assert remarks(scene(**flow(scheme="conservative"))) == []
    assert remarks(scene(**flow(scheme=scheme), walls=())) == ["no walls: nothing holds the fluid"]
    assert remarks(scene(**flow(scheme=scheme), gravity=())) == ["no gravity: the fluid has no weight"]


def test_fluids_that_share_space_are_refused() -> None:
    with pytest.raises(InputError, match="fluids may touch but not share space"):
        fill_scene(scene(**second(shape=Box((0.1, 0.1), (0.0, 0.15)))))
    assert fill_scene(scene()).liquid == 200

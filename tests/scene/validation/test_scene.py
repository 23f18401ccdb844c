"""Every refusal of a scene names the place, the field and the constraint."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.refusals import Fields, assert_refused, named
from tests.scenes import RUBBER, block
from warp_mps.errors import InputError
from warp_mps.scene import (
    OUTPUTS,
    Body,
    Contact,
    Elasticity,
    HarmonicMotion,
    HarmonicRotation,
    Load,
    Material,
    Measurement,
    Part,
    Probe,
    Scene,
    StageFrame,
    Support,
    TableMotion,
    TableRotation,
    VelocityField,
    Wall,
)
from warp_mps.shapes import Box

NAN, INF = math.nan, math.inf
REGION = Box((1.0, 1.0))
POINT = {"point": (0.0, 0.0)}
SWING = HarmonicMotion(amplitude=(0.0, 1e-3), frequency=5.0)
STEPS = TableMotion(times=np.array([0.0, 1.0]), displacements=np.zeros((2, 2)))
TURN = HarmonicRotation(amplitude=0.1, frequency=5.0, pivot=(0.0, 0.0))
ANGLES = TableRotation(times=np.array([0.0, 1.0]), angles=np.zeros(2), pivot=(0.0, 0.0))
FIELD = VelocityField(kind="sine", amplitude=(0.0, 1.0), axis=(1.0, 0.0), origin=(0.0, 0.0), length=1.0)


def scene(**fields: Any) -> Scene:
    """A good scene, with some fields replaced."""
    good: dict[str, Any] = {
        "bodies": (block(2, path="/World/block"),),
        "duration": 1.0,
        "path": "/World",
        "probes": (Probe(name="tip", point=(0.0, 0.0), path="/World/tip"),),
    }
    return Scene(**{**good, **fields})


def body(**fields: Any) -> dict[str, Any]:
    """Fields of a scene whose body is another one."""
    return {"bodies": (replace(block(2, path="/World/block"), **fields),)}


def material(**fields: Any) -> dict[str, Any]:
    """Fields of a scene whose material is another one."""
    return body(material=replace(RUBBER, path="/World/rubber", **fields))


def part(**fields: Any) -> dict[str, Any]:
    """Fields of a scene whose body has a part."""
    return body(
        parts=(Part(**{"name": "core", "region": REGION, "material": RUBBER, "path": "/World/core", **fields}),)
    )


def support(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a support."""
    return {"supports": (Support(**{"name": "grip", "region": REGION, "path": "/World/grip", **fields}),)}


def wall(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a wall."""
    good = {"name": "floor", "shape": Box((1.0, 0.1), (0.0, -1.0)), "spacing": 0.01, "path": "/World/floor"}
    return {"walls": (Wall(**{**good, **fields}),)}


def turning(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a wall that turns."""
    return wall(rotation=replace(TURN, **fields))


def solid(**fields: Any) -> dict[str, Any]:
    """Fields of a 3-D scene with a wall that turns."""
    return {**turning(pivot=(0.0, 0.0, 0.0), **fields), "dimension": 3, "probes": ()}


def load(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a load."""
    good = {"name": "push", "region": REGION, "path": "/World/push", "force": (1.0, 0.0)}
    return {"loads": (Load(**{**good, **fields}),)}


def probe(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a probe."""
    return {"probes": (Probe(**{"name": "tip", "path": "/World/tip", **fields}),)}


def measurement(**fields: Any) -> dict[str, Any]:
    """Fields of a scene with a measurement."""
    good = {"name": "mode", "measure": "frequency", "probe": "tip", "path": "/World/mode"}
    return {"measurements": (Measurement(**{**good, **fields}),)}


def velocity_field(**fields: Any) -> dict[str, Any]:
    """Fields of a scene whose body has an initial velocity field."""
    return body(velocity_field=replace(FIELD, **fields))


# made late: a record refuses what is wrong in itself
BROKEN: list[tuple[str, str, str, Fields]] = [
    ("/World", "dimension", "must be one of: 2, 3", lambda: {"dimension": 1}),
    ("/World", "plane", "must be one of: strain, stress", lambda: {"plane": "both"}),
    (
        "elasticity",
        "model",
        "must be one of: hamiltonian, springs",
        lambda: {"elasticity": Elasticity(model="glass")},
    ),
    (
        "elasticity",
        "normalization",
        "must be one of: lattice, particle",
        lambda: {"elasticity": Elasticity(normalization="n")},
    ),
    ("elasticity", "effective_radius", "between 1", lambda: {"elasticity": Elasticity(effective_radius=0.9)}),
    ("elasticity", "effective_radius", "between 1", lambda: {"elasticity": Elasticity(effective_radius=NAN)}),
    ("contact", "between", "must be one of: none, bodies, all", lambda: {"contact": Contact(between="some")}),
    ("contact", "stiffness", "above 0", lambda: {"contact": Contact(stiffness=0.0)}),
    ("contact", "friction", "at least 0", lambda: {"contact": Contact(friction=-0.1)}),
    ("/World", "duration", "above 0", lambda: {"duration": 0.0}),
    ("/World", "duration", "finite", lambda: {"duration": INF}),
    ("/World", "frame_rate", "above 0", lambda: {"frame_rate": -1.0}),
    ("/World", "sample_rate", "above 0", lambda: {"sample_rate": 0.0}),
    ("/World", "sample_rate", "whole multiple of the frame rate, 100", lambda: {"sample_rate": 150.0}),
    ("/World", "sample_rate", "whole multiple of the frame rate, 100", lambda: {"sample_rate": 20.0}),
    ("elasticity", "control", "between 0 and 10", lambda: {"elasticity": Elasticity(control=-1.0)}),
    ("/World", "stage.axes", "must be one of: xy, xz, yz", lambda: {"stage": StageFrame(axes="xyz")}),
    ("stage frame", "up_axis", "must be one of: Y, Z", lambda: {"stage": StageFrame(up_axis="X")}),
    ("stage frame", "meters_per_unit", "above 0", lambda: {"stage": StageFrame(meters_per_unit=0.0)}),
    ("/World", "time_step", "above 0", lambda: {"time_step": NAN}),
    ("/World", "courant", "above 0", lambda: {"courant": 0.0}),
    ("/World", "damping", "at least 0", lambda: {"damping": -1.0}),
    ("/World", "gravity", "2 finite numbers", lambda: {"gravity": (0.0, -9.81, 0.0)}),
    ("/World", "gravity", "2 finite numbers", lambda: {"gravity": (0.0, NAN)}),
    ("/World", "bodies", "needs a body or a fluid", lambda: {"bodies": ()}),
    ("/World/block", "name", "is used twice", lambda: {"bodies": (block(2, path="/World/block"),) * 2}),
    ("/World/block", "name", "is empty", lambda: body(name="")),
    ("/World/block", "name", "letters, digits and _", lambda: body(name="my block")),
    ("/World/rubber", "law", "must be one of: st_venant", lambda: material(law="jelly")),
    ("/World/floor", "name", "is also that of a body", lambda: wall(name="block")),
    ("/World/floor", "name", "is used twice", lambda: {"walls": wall()["walls"] * 2}),
    ("/World/floor", "name", "letters, digits and _", lambda: wall(name="a floor")),
    ("/World/floor", "spacing", "above 0", lambda: wall(spacing=0.0)),
    ("/World/floor", "node_axes", "among x, y and z", lambda: wall(node_axes=(3,))),
    ("/World/floor", "slip", "must be one of: free, no", lambda: wall(slip="some")),
    ("/World/floor", "friction", "at least 0", lambda: wall(friction=-0.1)),
    ("harmonic motion", "frequency", "above 0", lambda: wall(motion=replace(SWING, frequency=0.0))),
    ("/World/floor", "motion.times", "increase", lambda: wall(motion=replace(STEPS, times=np.array([1.0, 0.0])))),
    (
        "table motion",
        "interpolation",
        "linear, cubic",
        lambda: wall(motion=replace(STEPS, interpolation="round")),
    ),
    ("harmonic rotation", "amplitude", "finite", lambda: turning(amplitude=NAN)),
    ("harmonic rotation", "frequency", "above 0", lambda: turning(frequency=-1.0)),
    ("harmonic rotation", "phase", "finite", lambda: turning(phase=INF)),
    ("/World/floor", "rotation.pivot", "2 finite numbers", lambda: turning(pivot=(0.0, 0.0, 0.0))),
    ("/World/floor", "rotation.axis", "3 finite numbers", solid),
    ("/World/floor", "rotation.axis", "has no length", lambda: solid(axis=(0.0, 0.0, 0.0))),
    ("/World/floor", "rotation.times", "two times", lambda: wall(rotation=replace(ANGLES, times=np.zeros(1)))),
    ("/World/floor", "rotation.times", "increase", lambda: wall(rotation=replace(ANGLES, times=np.zeros(2)))),
    (
        "/World/floor",
        "rotation.angles",
        "one number for each",
        lambda: wall(rotation=replace(ANGLES, angles=np.zeros(3))),
    ),
    ("/World/floor", "rotation.angles", "finite", lambda: wall(rotation=replace(ANGLES, angles=np.array([0.0, NAN])))),
    ("/World/floor", "rotation.angles", "0 at t = 0", lambda: wall(rotation=replace(ANGLES, angles=np.ones(2)))),
    (
        "table rotation",
        "interpolation",
        "linear, cubic",
        lambda: wall(rotation=replace(ANGLES, interpolation="round")),
    ),
    (
        "/World/tip",
        "quantity",
        "must be one of: position",
        lambda: {**wall(), **probe(body="floor", quantity="momentum")},
    ),
    ("/World/grip", "bodies", "is 'floor', must name a body", lambda: {**wall(), **support(bodies=("floor",))}),
    ("/World/grip", "axes", "different axes", lambda: support(axes=(1, 1))),
    (
        "/World/tip",
        "name",
        "is used twice",
        lambda: {"probes": (Probe(name="a", point=(0.0, 0.0), path="/World/tip"),) * 2},
    ),
    ("/World/grip", "name", "is used twice", lambda: {"supports": support()["supports"] * 2}),
    ("/World/rubber", "retardation_time", "at least 0", lambda: material(retardation_time=-1.0)),
    ("/World/rubber", "retardation_time", "finite", lambda: material(retardation_time=NAN)),
    (
        "/World/rubber",
        "retardation_time",
        "is for the hamiltonian model",
        lambda: {**material(retardation_time=1e-3), "elasticity": Elasticity(model="springs")},
    ),
    ("/World/rubber", "density", "above 0", lambda: material(density=0.0)),
    ("/World/rubber", "youngs_modulus", "above 0", lambda: material(youngs_modulus=-1.0)),
    ("/World/rubber", "poissons_ratio", "between -1 and 0.5", lambda: material(poissons_ratio=0.5)),
    (
        "/World/rubber",
        "poissons_ratio",
        "between -1 and 1",
        lambda: {**material(poissons_ratio=1.0), "plane": "stress"},
    ),
    ("/World/rubber", "poissons_ratio", "between -1", lambda: material(poissons_ratio=-1.0)),
    ("material", "density", "above 0", lambda: body(material=Material(0.0, 1e6, 0.3))),
    ("/World/block", "spacing", "above 0", lambda: body(spacing=0.0)),
    ("/World/block", "velocity", "2 finite numbers", lambda: body(velocity=(1.0,))),
    ("/World/block", "angular_velocity", "1 finite numbers", lambda: body(angular_velocity=(0.0, 0.0, 1.0))),
    ("/World/block", "node_axes", "must be axes", lambda: body(node_axes=(3,))),
    ("/World/block", "bonded_to", "is 'ghost', must name a body", lambda: body(bonded_to=("ghost",))),
    ("material", "density", "above 0", lambda: part(material=replace(RUBBER, density=0.0))),
    (
        "/World/core",
        "material.poissons_ratio",
        "between -1 and 0.5",
        lambda: part(material=replace(RUBBER, poissons_ratio=0.5)),
    ),
    ("/World/core", "name", "is empty", lambda: part(name="")),
    ("velocity field", "kind", "must be one of: sine", lambda: velocity_field(kind="square")),
    ("/World/block", "velocity_field.amplitude", "2 finite numbers", lambda: velocity_field(amplitude=(1.0,))),
    ("/World/block", "velocity_field.amplitude", "'sine' needs it", lambda: velocity_field(amplitude=None)),
    (
        "/World/block",
        "velocity_field.rate",
        "is not used by the velocity field 'sine'",
        lambda: velocity_field(rate=1.0),
    ),
    ("/World/block", "velocity_field.kind", "needs a 3-D scene", lambda: velocity_field(kind="twist")),
    ("/World/block", "velocity_field.axis", "2 finite numbers", lambda: velocity_field(axis=(NAN, 1.0))),
    ("/World/block", "velocity_field.axis", "has no length", lambda: velocity_field(axis=(0.0, 0.0))),
    ("/World/block", "velocity_field.origin", "2 finite numbers", lambda: velocity_field(origin=(0.0, 0.0, 0.0))),
    ("velocity field", "length", "above 0", lambda: velocity_field(length=0.0)),
    ("velocity field", "mode", "at least 1", lambda: velocity_field(mode=0)),
    ("/World/grip", "axes", "2 dimensions", lambda: support(axes=(2,))),
    ("/World/grip", "bodies", "is 'ghost', must name a body", lambda: support(bodies=("ghost",))),
    ("/World/grip", "motion.amplitude", "2 finite", lambda: support(motion=replace(SWING, amplitude=(1.0,)))),
    ("harmonic motion", "frequency", "above 0", lambda: support(motion=replace(SWING, frequency=0.0))),
    ("harmonic motion", "phase", "finite", lambda: support(motion=replace(SWING, phase=INF))),
    ("/World/grip", "motion.times", "at least two", lambda: support(motion=replace(STEPS, times=np.array([0.0])))),
    ("/World/grip", "motion.times", "increase", lambda: support(motion=replace(STEPS, times=np.array([1.0, 1.0])))),
    ("/World/grip", "motion.times", "finite", lambda: support(motion=replace(STEPS, times=np.array([0.0, NAN])))),
    (
        "/World/grip",
        "motion.displacements",
        "one vector",
        lambda: support(motion=replace(STEPS, displacements=np.zeros((3, 2)))),
    ),
    (
        "/World/grip",
        "motion.displacements",
        "finite",
        lambda: support(motion=replace(STEPS, displacements=np.full((2, 2), NAN))),
    ),
    ("/World/push", "force", "neither a force nor an acceleration", lambda: load(force=None)),
    ("/World/push", "force", "2 finite numbers", lambda: load(force=(1.0, 2.0, 3.0))),
    ("/World/push", "acceleration", "2 finite numbers", lambda: load(acceleration=(INF, 0.0))),
    ("/World/push", "frequency", "at least 0", lambda: load(frequency=-1.0)),
    ("/World/push", "phase", "finite", lambda: load(phase=NAN)),
    ("/World/push", "bodies", "is 'ghost', must name a body", lambda: load(bodies=("ghost",))),
    ("/World/tip", "target", "exactly one", probe),
    ("/World/tip", "target", "exactly one", lambda: probe(point=(0.0, 0.0), body="block")),
    ("/World/tip", "target", "is 'ghost', must name a body, wall or fluid: one of: block", lambda: probe(body="ghost")),
    (
        "/World/tip",
        "target",
        "is 'ghost', must name a support: the scene has none",
        lambda: probe(support="ghost", quantity="reaction"),
    ),
    ("/World/tip", "quantity", "must be one of: position", lambda: probe(point=(0.0, 0.0), quantity="colour")),
    (
        "/World/tip",
        "quantity",
        "must be one of: reaction",
        lambda: {**support(), **probe(support="grip", quantity="position")},
    ),
    ("/World/tip", "quantity", "must be one of: position", lambda: probe(quantity="section_force", **POINT)),
    ("/World/tip", "about", "is missing", lambda: probe(region=REGION, quantity="section_moment")),
    (
        "/World/tip",
        "about",
        "needs section_moment",
        lambda: probe(region=REGION, quantity="section_force", about=(0.0, 0.0)),
    ),
    ("/World/tip", "about", "2 finite", lambda: probe(region=REGION, quantity="section_moment", about=(0.0, NAN))),
    ("/World", "outputs", "is 'stress', must be a tuple of texts", lambda: {"outputs": "stress"}),
    ("/World", "outputs", "is 'heat', must be one of: stress", lambda: {"outputs": ("stress", "heat")}),
    ("/World", "outputs", "names a quantity twice", lambda: {"outputs": ("stress", "stress")}),
    ("/World/tip", "point", "2 finite numbers", lambda: probe(point=(0.0, 0.0, 0.0))),
    ("/World/mode", "measure", "must be one of: frequency", lambda: measurement(measure="colour")),
    ("/World/mode", "probe", "is 'ghost', must name a probe", lambda: measurement(probe="ghost")),
    ("/World/mode", "component", "one of the 2 components", lambda: measurement(component=2)),
    (
        "/World/mode",
        "component",
        "must be 0",
        lambda: {**probe(quantity="von_mises", **POINT), **measurement(component=1)},
    ),
    (
        "/World/mode",
        "component",
        "one of the 4 components",
        lambda: {**probe(quantity="stress", **POINT), **measurement(component=4)},
    ),
    ("/World/mode", "start", "must lie before the end", lambda: measurement(start=1.0)),
    ("/World/mode", "start", "must lie before the end", lambda: measurement(start=0.5, end=0.5)),
    ("/World/mode", "at", "must be a number: value_at needs it", lambda: measurement(measure="value_at")),
    ("/World/mode", "at", "must be finite", lambda: measurement(measure="time_at", at=NAN)),
    ("/World/mode", "at", "must lie between 0.2 and 1 s", lambda: measurement(measure="value_at", at=0.1, start=0.2)),
    ("/World/mode", "at", "is only for the measures value_at and time_at", lambda: measurement(at=0.1)),
    ("/World/mode", "frequency", "is only for the harmonic measures", lambda: measurement(frequency=2.0)),
    ("/World/mode", "unit", "must be one of: , s", lambda: measurement(measure="time_at", at=0.1, unit="m")),
    ("/World/tip", "moves_with", "in a scene of fluids", lambda: {**wall(), **probe(moves_with="floor", **POINT)}),
    ("/World/mode", "frequency", "above 0", lambda: measurement(measure="harmonic_phase")),
    ("/World/mode", "reference", "finite", lambda: measurement(reference=NAN)),
    ("/World/mode", "unit", "must be one of", lambda: measurement(unit="mm")),
]


@pytest.mark.parametrize(("where", "attribute", "reason", "fields"), BROKEN, ids=named)
def test_a_broken_scene_is_refused(where: str, attribute: str, reason: str, fields: Fields) -> None:
    assert_refused(lambda: scene(**fields()), where, attribute, reason)


def test_items_without_a_path_are_named_by_kind_and_name() -> None:
    with pytest.raises(InputError, match=r"^body 'block' spacing: is -1, must be finite and above 0$"):
        scene(bodies=(block(2, spacing=-1.0),))
    with pytest.raises(InputError, match=r"^load 'push' force: neither"):
        scene(loads=(Load(name="push", region=REGION),))


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"gravity": (0.0, -9.81), "damping": 0.0, "sample_rate": 1000.0, "time_step": 1e-5},
        {**material(poissons_ratio=0.7), "plane": "stress"},
        material(poissons_ratio=-0.5),
        part(),
        support(motion=SWING, axes=(1,)),
        support(motion=STEPS, bodies=("block",)),
        load(frequency=3.0, acceleration=(0.0, 1.0)),
        body(angular_velocity=3.0, velocity=(1.0, 0.0), velocity_field=FIELD),
        measurement(start=0.5, end=0.8, unit="Hz"),
        {**support(), **probe(support="grip", quantity="reaction")},
        {"outputs": OUTPUTS},
        material(retardation_time=1e-3),
        probe(region=REGION, quantity="section_moment", about=(0.0, 0.0)),
        {**probe(quantity="stress", **POINT), **measurement(component=3, measure="maximum", unit="Pa")},
    ],
)
def test_a_good_scene_is_taken(fields: dict[str, Any]) -> None:
    assert scene(**fields).path == "/World"


def test_a_scene_in_space_wants_three_numbers() -> None:
    box: Body = block(3)
    with pytest.raises(InputError, match=r"gravity: is .* must be 3 finite numbers"):
        Scene(bodies=(box,), duration=1.0, dimension=3, gravity=(0.0, -9.81))
    with pytest.raises(InputError, match=r"angular_velocity: .* must be 3 finite numbers"):
        Scene(bodies=(replace(box, angular_velocity=1.0),), duration=1.0, dimension=3)
    twist = VelocityField(kind="twist", rate=1.0, axis=(1.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0), length=1.0)
    for fields, words in (
        ({"rate": None}, r"velocity_field.rate: is missing: the velocity field 'twist' needs it"),
        ({"rate": NAN}, r"velocity field rate: is nan, must be finite"),
        ({"amplitude": (0.0, 1.0, 0.0)}, r"velocity_field.amplitude: .*; it takes rate, length"),
    ):
        with pytest.raises(InputError, match=words):
            Scene(bodies=(replace(box, velocity_field=replace(twist, **fields)),), duration=1.0, dimension=3)
    # plane stress is nothing in space
    with pytest.raises(InputError, match=r"between -1 and 0.5 \(both excluded\) in 3-D"):
        Scene(bodies=(block(3, material=Material(1.0, 1.0, 0.6)),), duration=1.0, dimension=3, plane="stress")

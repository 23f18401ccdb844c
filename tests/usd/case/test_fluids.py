"""Fluids in stages and in results: reading, saving, refusals, writing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.usd.case.stages import HEAD
from tests.usd.case.test_save import same
from warp_mps.errors import InputError
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import (
    Flow,
    Fluid,
    Liquid,
    Measurement,
    Probe,
    Scene,
    StageFrame,
    VelocityField,
    Wall,
)
from warp_mps.shapes import Box, Points, Sphere
from warp_mps.usd.animation.writer import AnimationWriter
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.case.save import save_stage

OIL = Liquid(density=917.0, viscosity=8.4e-5)


def fluid_scene(dimension: int, frame: StageFrame | None) -> Scene:
    """A scene that uses every field of fluids."""

    def pad(*values: float) -> tuple[float, ...]:
        return (*values, 0.3)[:dimension]

    size = (1.2, 0.4, 0.4)[:dimension]
    fields = (
        VelocityField(kind="stagnation", rate=-3.0, axis=pad(1.0, 0.0), origin=pad(0.1, 0.2)),
        VelocityField(
            kind="standing_wave", amplitude=(0.0, 0.2, 0.0)[:dimension], axis=(1.0, 0.0, 0.0)[:dimension],
            origin=pad(0.1, 0.2), length=1.2, depth=0.4,
        ),
        VelocityField(
            kind="taylor_green", amplitude=(0.0, 0.2, 0.0)[:dimension], axis=(1.0, 0.0, 0.0)[:dimension],
            origin=pad(0.1, 0.2), length=1.2,
        ),
    )  # fmt: skip
    cloud = np.array([(0.0, 2.0, 0.0), (0.125, 2.0, 0.0)])
    fluids = (
        Fluid(name="tank", shape=Box(size), liquid=OIL, spacing=0.1, node_axes=(1,), velocity_field=fields[0]),
        Fluid(name="ball", shape=Sphere(0.4, (3, 2)), liquid=OIL, spacing=0.1, velocity_field=fields[1]),
        Fluid(
            name="drop", shape=Sphere(0.4, (5, 2)), liquid=OIL, spacing=0.1, velocity=pad(1.5, -2.5),
            angular_velocity=0.7 if dimension == 2 else (0.1, 0.2, 0.3), velocity_field=fields[2],
        ),
        Fluid(name="cloud", shape=Points(cloud, cloud * (0.5, 1, 0)), liquid=OIL, spacing=0.1),
    )  # fmt: skip
    flow = Flow(
        scheme="corrected", effective_radius=2.6, negative_pressure="allowed", tolerance=1e-5, courant=0.15,
        domain=(pad(-7.0, -5.0), (9.0, 8.0, 7.0)[:dimension]), periodic=(0, dimension - 1),
    )  # fmt: skip
    return Scene(
        name="fluid", fluids=fluids, flow=flow, duration=0.5, dimension=dimension, stage=frame,
        walls=(Wall(name="floor", shape=Box((9.0, 0.4, 1.0)[:dimension], (0.0, -3.0)), spacing=0.1, slip="no"),),
        gravity=pad(0.0, -9.75), probes=(
            Probe(name="middle", body="tank", quantity="position"),
            Probe(name="gauge", point=pad(0.1, -0.2), quantity="pressure", moves_with="floor"),
            Probe(name="push", body="floor", quantity="contact_moment", about=pad(1.0, 2.0)),
        ),
        measurements=(
            Measurement(name="level", measure="value_at", probe="middle", component=1, at=0.25),
            Measurement(name="surge", measure="time_at", probe="gauge", at=1234.5),
        ),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("dimension", "frame"),
    [
        (2, None),
        (2, StageFrame(axes="xz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=0.5)),
        (3, None),
        (3, StageFrame(axes="xyz", up_axis="Z", meters_per_unit=1e-3)),
    ],
)
def test_what_is_saved_is_read_back(tmp_path: Path, dimension: int, frame: StageFrame | None) -> None:
    scene = fluid_scene(dimension, frame)
    save_stage(scene, tmp_path / "fluid.usda")
    back = read_stage(tmp_path / "fluid.usda")
    same(scene, back, dimension)
    assert back.flow.periodic == scene.flow.periodic
    assert [len(fluid.node_axes) for fluid in back.fluids] == [1, 0, 0, 0]
    stage = Usd.Stage.Open(str(tmp_path / "fluid.usda"))
    schemas = stage.GetPrimAtPath("/World/Fluids/drop").GetMetadata("apiSchemas").GetAppliedItems()
    assert "MpsFluidAPI" in schemas
    assert [prim.GetName() for prim in stage.GetPrimAtPath("/World/Materials").GetChildren()] == ["tank"]


def test_a_saved_stage_passes_the_validators(tmp_path: Path) -> None:
    validation = pytest.importorskip("pxr.UsdValidation")
    save_stage(fluid_scene(3, None), tmp_path / "fluid.usda")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    errors = validation.ValidationContext(validators).Validate(Usd.Stage.Open(str(tmp_path / "fluid.usda")))
    assert [error.GetMessage() for error in errors] == []


PHYSICS = (
    'def PhysicsScene "Scene"\n{{\n    int mps:dimension = 2\n    double mps:duration = 2\n    {scene}\n}}\n'
    'def Cube "Pool"\n{{\n    token mps:role = "fluid"\n    double mps:spacing = 10\n    double size = 100\n'
    "    {pool}\n}}\n"
    'def Material "Oil"\n{{\n    {oil}\n}}\n'
)
BOUND = "rel material:binding:physics = </Oil>"


def written(folder: Path, *, scene: str = "", pool: str = "", oil: str = "") -> Path:
    """A stage in centimetres and grams of one fluid."""
    text = HEAD.format(length=0.01, mass=0.001, up="Y") + PHYSICS.format(scene=scene, pool=pool, oil=oil)
    (folder / "case.usda").write_text(text, encoding="utf-8")
    return folder / "case.usda"


def test_a_fluid_without_a_material_is_water(tmp_path: Path) -> None:
    scene = read_stage(written(tmp_path))
    (pool,) = scene.fluids
    assert (pool.name, pool.path, pool.spacing) == ("Pool", "/Pool", 0.1)
    assert (pool.liquid.density, pool.liquid.viscosity) == (1000.0, 1e-6)
    assert scene.flow == Flow()
    assert scene.gravity == pytest.approx((0.0, -9.81))


def test_a_liquid_in_the_units_of_the_stage(tmp_path: Path) -> None:
    (pool,) = read_stage(
        written(tmp_path, pool=BOUND, oil="float physics:density = 0.9\n    double mps:viscosity = 2")
    ).fluids
    assert pool.liquid.density == pytest.approx(900.0)
    assert pool.liquid.viscosity == pytest.approx(2e-4)
    assert pool.liquid.path == "/Oil"
    (pool,) = read_stage(written(tmp_path, pool=BOUND + "\n    float physics:density = 0.8")).fluids
    assert (pool.liquid.density, pool.liquid.viscosity) == (pytest.approx(800.0), 1e-6)


def test_a_domain_in_the_units_of_the_stage(tmp_path: Path) -> None:
    corners = "double3 mps:domainLow = (-60, -50, 0)\n    double3 mps:domainHigh = (50, 90, 0)"
    flow = read_stage(written(tmp_path, scene=corners + '\n    token mps:periodicAxes = "y"')).flow
    np.testing.assert_allclose(flow.domain, [(-0.6, -0.5), (0.5, 0.9)])
    assert flow.periodic == (1,)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (r"/Oil mps:youngsModulus: is not known here", {"pool": BOUND, "oil": "double mps:youngsModulus = 1"}),
        (r"/Oil mps:viscosity: is -0.0001, .* at least 0", {"pool": BOUND, "oil": "double mps:viscosity = -1"}),
        (r"/Pool mps:bondedTo: is not known here", {"pool": "rel mps:bondedTo = </Oil>"}),
        (r"/Pool mps:velocityField:rate: is missing", {"pool": 'token mps:velocityField = "stagnation"'}),
        (r"/Scene mps:domainHigh: is missing", {"scene": "double3 mps:domainLow = (0, 0, 0)"}),
        (r"/Scene mps:periodicAxes: is 'z', must be axes among xy", {"scene": 'token mps:periodicAxes = "z"'}),
        (r"/Scene mps:periodicAxes: needs a domain", {"scene": 'token mps:periodicAxes = "x"'}),
        (r"/Scene mps:pressureTolerance: is 1, must", {"scene": "double mps:pressureTolerance = 1"}),
        (r"/Scene mps:fluidScheme: is 'best', must be one of", {"scene": 'token mps:fluidScheme = "best"'}),
    ],
)
def test_refusals_in_the_words_of_the_stage(tmp_path: Path, words: str, text: dict[str, str]) -> None:
    with pytest.raises(InputError, match=words):
        read_stage(written(tmp_path, **text))


def test_a_stage_without_anything_to_simulate(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_text(
        path.read_text(encoding="utf-8").replace('token mps:role = "fluid"', "token mps:role = None"), encoding="utf-8"
    )
    with pytest.raises(InputError, match="needs a body or a fluid"):
        read_stage(path)


def test_a_result_has_the_particles_of_every_fluid(tmp_path: Path) -> None:
    scene = fluid_scene(2, None)
    particles = fill_scene(scene)
    writer = AnimationWriter(tmp_path / "run.usdc", particles, scene.frame, frame_rate=10.0, provenance={})
    writer.write(0.0, particles.positions, particles.velocities)
    # fluids mix: what moves keeps its place in the arrays, and so its identifier
    mixed = particles.positions[::-1].copy()
    writer.write(0.1, mixed, particles.velocities)
    writer.close()
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    assert [prim.GetName() for prim in stage.GetPrimAtPath("/Result").GetChildren()] == list(particles.names)
    colors = set()
    for name, (first, last) in zip(particles.names, particles.ranges, strict=True):
        points = UsdGeom.Points(stage.GetPrimAtPath(f"/Result/{name}"))
        assert len(points.GetPointsAttr().Get(1.0)) == last - first == len(points.GetWidthsAttr().Get())
        np.testing.assert_array_equal(points.GetIdsAttr().Get(), particles.ids[first:last])
        np.testing.assert_allclose(np.asarray(points.GetPointsAttr().Get(1.0))[:, :2], mixed[first:last], atol=1e-6)
        colors.add(tuple(points.GetDisplayColorPrimvar().Get()[0]))
    # one colour for the liquid, another for the wall
    assert len(colors) == 2

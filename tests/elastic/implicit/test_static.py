"""Static equilibrium: balance of forces and energies, and answers known from elsewhere."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.bits import assert_restored_goes_on
from tests.elastic.implicit.plates import DEFLECTION, PRESSURE, plate
from tests.scenes import RUBBER, block, cross, random
from warp_mps.errors import RunError
from warp_mps.particles.selection import select
from warp_mps.results.history import read_history
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import LAWS, Contact, Load, Probe, Scene, Support, TableMotion
from warp_mps.shapes import Box

CLAMP = Support(name="clamp", region=Box((0.02, 1.0, 1.0), center=(-0.05, 0.0, 0.0)))


def cantilever(dimension: int = 2, *, layers: int = 3, **scene: object) -> Scene:
    """A bar of rubber of 10 by 3 cm that is held at its left end."""
    spacing = 0.03 / layers
    body = block(dimension, shape=Box((0.1, 0.03, 0.03)[:dimension]), spacing=spacing)
    region = Box((0.02, 1.0, 1.0)[:dimension], center=(-0.05, 0.0, 0.0)[:dimension])
    down = np.eye(dimension)[1] * -9.81
    fields = {"supports": (replace(CLAMP, region=region),), "gravity": down, "analysis": "static", "load_steps": 1}
    return Scene(**{"bodies": (body,), "duration": 1.0, "dimension": dimension, **fields, **scene})  # type: ignore[arg-type]


def found(scene: Scene, **options: object) -> Simulation:
    simulation = Simulation(scene, **options)  # type: ignore[arg-type]
    simulation.advance(simulation.total_steps)
    return simulation


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("dimension", "plane"), [(2, "strain"), (2, "stress"), (3, "strain")])
def test_reactions_balance_the_loads(dimension: int, plane: str, law: str) -> None:
    """Weight and a load of 200 N or 200 N/m, which bend the bar by a fifth of its length: forces and moments."""
    scene = cantilever(dimension, plane=plane, load_steps=2)
    body = replace(scene.bodies[0], material=replace(RUBBER, law=law, youngs_modulus=1e6))
    tip = Box((0.02, 1.0, 1.0)[:dimension], center=(0.05, 0.0, 0.0)[:dimension])
    size = 300.0 if dimension == 2 else 9.0
    pull = size * np.array([0.3, -1.0, 0.2])[:dimension]
    simulation = found(replace(scene, bodies=(body,), loads=(Load(name="tip", region=tip, force=pull),)))
    particles = simulation.particles
    applied = particles.masses[:, None] * np.asarray(scene.gravity)
    loaded = select(particles, tip)
    applied[loaded] += pull / len(loaded)
    forces = applied + simulation.reactions
    assert np.abs(simulation.displacements).max() > 0.01
    scale = np.abs(applied).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-7 * scale)
    # the clamp exerts its forces at its face, where the bonds of free particles to held ones end
    model, any_held = simulation.solid.model, simulation.solid.boundary.held[:, 0]
    i = np.repeat(np.arange(particles.count), np.diff(model.start.numpy()))
    j, bond = model.index.numpy(), model.bond.numpy()
    u, pull_of, stiffness = simulation.displacements, model.pull.numpy(), model.resistance.numpy()
    pair_forces = np.einsum("kab,kb->ka", pull_of[i] + pull_of[j], bond)
    pair_forces += (stiffness[i] + stiffness[j])[:, None] * (u[j] - u[i])
    at_face = ~any_held[i] & any_held[j]
    moments = cross(particles.positions[i] + bond + u[j], model.weight.numpy()[:, None] * pair_forces)[at_face]
    moments = moments.sum(axis=0) + cross(simulation.positions, applied)[~any_held].sum(axis=0)
    np.testing.assert_allclose(moments, 0.0, atol=1e-7 * scale * 0.1)
    held = simulation.solid.boundary.held
    assert (simulation.displacements[held] == 0.0).all()
    np.testing.assert_allclose((simulation.internal_forces + applied)[~held], 0.0, atol=1e-7 * scale)


def test_work_of_the_loads_is_the_elastic_energy() -> None:
    """The error of the work falls by 4 when there are twice as many load steps, for the bar stiffens."""
    body = replace(cantilever().bodies[0], material=replace(RUBBER, youngs_modulus=2e4))
    errors, energies = [], []
    for steps in (2, 4, 8):
        energy = found(cantilever(bodies=(body,), load_steps=steps)).energy
        errors.append(abs(energy.balance))
        energies.append(energy.elastic)
        assert energy.kinetic == energy.potential == energy.contact == energy.dissipated == 0.0
    np.testing.assert_allclose(energies, energies[0], rtol=1e-6)
    assert errors[0] > 1e-4 * energies[0]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.15)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_stretched_bar(dimension: int, law: str) -> None:
    """By a table, that only ends where it should: the middle is as the law says of a bar that is free to contract."""
    scene, grip = stretched(dimension, law)
    simulation = found(scene)
    middle = np.abs(simulation.particles.positions[:, 0]) < 0.006
    gradient = simulation.solid.model.gradient.numpy()[middle].mean(axis=0)
    stretch = 1.0 + gradient[0, 0]
    assert 1.3 < stretch < 1.6
    across = _across(law, dimension, stretch)
    np.testing.assert_allclose(gradient, np.diag([stretch - 1.0, *[across] * (dimension - 1)]), atol=0.01)
    pull = simulation.reactions[select(simulation.particles, grip)].sum(axis=0)
    expected = _pull(law, dimension, stretch) * 0.04 ** (dimension - 1)
    np.testing.assert_allclose(pull, expected * np.eye(dimension)[0], atol=0.03 * expected)
    moved = simulation.displacements[select(simulation.particles, grip)]
    np.testing.assert_allclose(moved, np.broadcast_to(0.06 * np.eye(dimension)[0], moved.shape), atol=1e-15)
    assert simulation.energy.work == pytest.approx(simulation.energy.elastic, rel=0.01)


def stretched(dimension: int, law: str) -> tuple[Scene, Box]:
    """A bar of 16 by 4 cm with both ends held, one of them pulled away by 6 cm; and the end's position."""
    body = block(dimension, (16, 4, 4), material=replace(RUBBER, law=law))
    left, right = (Box((0.04, 1.0, 1.0)[:dimension], center=(x, 0.0, 0.0)[:dimension]) for x in (-0.08, 0.08))
    way = np.outer([0.0, 0.01, 0.06], np.eye(dimension)[0])
    motion = TableMotion(times=np.array([0.0, 0.1, 7.0]), displacements=way)
    grips = Support(name="left", region=left), Support(name="right", region=right, motion=motion)
    return Scene(bodies=(body,), supports=grips, dimension=dimension, duration=1.0, analysis="static"), right


LAME, SHEAR = 0.3e7 / (1.3 * 0.4), 1e7 / 2.6


def _across(law: str, dimension: int, stretch: float) -> float:
    """Displacement gradient across a bar of some stretch along it, with no stress across."""
    if law == LAWS[0]:
        along = 0.5 * (stretch**2 - 1.0)
        strain = -LAME * along / (2.0 * SHEAR + LAME * (dimension - 1))
        return float(np.sqrt(1.0 + 2.0 * strain) - 1.0)
    low, high = 0.2, 1.0
    for _ in range(60):
        b = 0.5 * (low + high)
        stress = SHEAR * (b * b - 1.0) + LAME * np.log(stretch * b ** (dimension - 1))
        low, high = (b, high) if stress < 0.0 else (low, b)
    return b - 1.0


def _pull(law: str, dimension: int, stretch: float) -> float:
    """Force per reference area of that bar [Pa]."""
    b = 1.0 + _across(law, dimension, stretch)
    if law == LAWS[0]:
        along, across = 0.5 * (stretch**2 - 1.0), 0.5 * (b * b - 1.0)
        return stretch * (2.0 * SHEAR * along + LAME * (along + (dimension - 1) * across))
    return (SHEAR * (stretch**2 - 1.0) + LAME * np.log(stretch * b ** (dimension - 1))) / stretch


@pytest.mark.parametrize(("layers", "error"), [(5, 0.015), (10, 0.009)])
def test_a_clamped_plate_under_water(layers: int, error: float) -> None:
    scene = plate(layers, analysis="static", load_steps=1)
    simulation, spacing = found(scene), 0.05 / layers
    middle = np.abs(simulation.particles.positions[:, 0]) < 0.6 * spacing
    assert simulation.displacements[middle, 1].mean() == pytest.approx(DEFLECTION, rel=error)
    assert simulation.reactions.sum(axis=0)[1] == pytest.approx(PRESSURE * (1.0 - spacing), rel=1e-7)
    assert simulation.energy.work == pytest.approx(simulation.energy.elastic, rel=1e-4)


def test_a_restored_analysis_goes_on_to_the_same_bits() -> None:
    assert_restored_goes_on(cantilever(load_steps=4), 2, 2)


def test_load_steps_do_not_change_the_end() -> None:
    ends = [found(cantilever(load_steps=steps)).displacements for steps in (1, 5)]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-6 * np.abs(ends[0]).max())


def test_a_run_has_a_row_and_a_frame_for_every_load_step(tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom

    probe = Probe(name="tip", point=(0.04, 0.0))
    summary = run_scene(cantilever(load_steps=4, probes=(probe,)), tmp_path, quiet=True)
    assert summary.status == "done"
    assert summary.implicit["equilibria"] == 4
    assert summary.implicit["newton_iterations"] >= 4
    assert summary.implicit["linear_iterations"] > 10
    assert summary.implicit["unsolved"] == 0
    assert 0.0 < summary.implicit["worst_residual"] <= 1e-8
    history = read_history(tmp_path / "probes.csv")
    np.testing.assert_allclose(history.times, [0.0, 0.25, 0.5, 0.75, 1.0])
    sag = history.probe("tip", 1)
    np.testing.assert_allclose(sag, sag[-1] * history.times, rtol=0.01)
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    points = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Points))
    assert UsdGeom.Points(points).GetPointsAttr().GetNumTimeSamples() == 5


def test_a_finished_run_goes_on_to_more_load(tmp_path: Path) -> None:
    """With the rows of a run that was to go there at once, to the same bits."""
    probe = Probe(name="tip", point=(0.04, 0.0))
    scene = cantilever(load_steps=2, probes=(probe,))
    run_scene(scene, tmp_path / "parts", quiet=True)
    more = replace(scene, duration=2.0)
    run_scene(more, tmp_path / "parts", quiet=True, resume=True)
    run_scene(more, tmp_path / "whole", quiet=True)
    parts, whole = (read_history(tmp_path / name / "probes.csv") for name in ("parts", "whole"))
    np.testing.assert_allclose(whole.times, [0.0, 0.5, 1.0, 1.5, 2.0])
    assert parts.rows == whole.rows


@pytest.mark.parametrize("law", LAWS)
def test_a_column_that_buckles(law: str) -> None:
    """Pressed together by a quarter: it leaves the straight line, on which the tangent is not positive any more."""
    soft = replace(RUBBER, law=law, youngs_modulus=1e5)
    body = block(2, shape=Box((0.16, 0.02)), spacing=0.005, material=soft)
    left, right = (Box((0.01, 1.0), center=(x, 0.0)) for x in (-0.08, 0.08))
    motion = TableMotion(times=np.array([0.0, 1.0]), displacements=np.array([[0.0, 0.0], [-0.04, 0.001]]))
    grips = Support(name="left", region=left), Support(name="right", region=right, motion=motion)
    simulation = found(Scene(bodies=(body,), supports=grips, duration=1.0, analysis="static"))
    assert np.abs(simulation.displacements[:, 1]).max() > 0.03
    held = simulation.solid.boundary.held
    forces = simulation.internal_forces
    assert np.abs(forces[~held]).max() < 1e-6 * np.abs(forces[held]).max()
    # straight, it would resist with E/(1 - nu^2) times its strain
    resistance = abs(simulation.reactions[select(simulation.particles, right)].sum(axis=0)[0])
    assert resistance < 0.25 * 0.25 * 1e5 / 0.91 * 0.02


def test_a_body_that_nothing_holds_is_refused_in_a_line(tmp_path: Path) -> None:
    scene = cantilever(supports=())
    with pytest.raises(RunError, match="no equilibrium was found beyond a load factor of 0: a body is held"):
        run_scene(scene, tmp_path, quiet=True)


def slender(length: float) -> Scene:
    """A bar that is long for its thickness of 3 cm."""
    clamp = replace(CLAMP, region=Box((0.02, 1.0), center=(-0.5 * length, 0.0)))
    return cantilever(bodies=(block(2, shape=Box((length, 0.03))),), supports=(clamp,))


def test_a_slender_body_is_found_in_single_precision() -> None:
    """To the rounding of its forces, which cancel to far less than they are."""
    exact, single = (found(slender(0.8), precision=name).displacements for name in ("float64", "float32"))
    assert np.abs(exact).max() > 0.1
    np.testing.assert_allclose(single, exact, atol=1e-4 * np.abs(exact).max())


@pytest.mark.long
def test_a_very_slender_body_needs_double_precision_and_is_told_so() -> None:
    """Its forces cancel to less than their rounding."""
    with pytest.raises(RunError, match=r"rounded by .* take double precision; particle \d+ of body 'block'"):
        found(slender(1.6), precision="float32")


def test_bodies_apart_are_found_side_by_side() -> None:
    """Without contact, each sags as it would alone."""
    scene = cantilever()
    other = replace(scene.bodies[0], name="other", shape=Box((0.1, 0.03), center=(0.0, 0.1)))
    both = found(replace(scene, bodies=(*scene.bodies, other), contact=Contact(between="none"))).displacements
    alone = found(scene).displacements
    np.testing.assert_allclose(both, np.concatenate((alone, alone)), atol=1e-6 * np.abs(alone).max())


def test_the_end_does_not_depend_on_where_the_search_begins() -> None:
    """From a state that is far from equilibrium, in which the tangent is not positive."""
    simulation = Simulation(cantilever())
    solid = simulation.solid
    held = solid.boundary.held
    crumpled = np.where(held, 0.0, 0.006 * random(*held.shape, seed=3))
    solid.state.u.assign(crumpled)
    simulation.advance(1)
    ends = simulation.displacements
    expected = found(cantilever()).displacements
    np.testing.assert_allclose(ends, expected, atol=1e-5 * np.abs(expected).max())

"""The mobility of bodies, against that of simple ones."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, IMPLICIT, WAYS, lump, pool, system_of
from tests.fluid.scenes import L0
from warp_mps.core.device import open_device
from warp_mps.core.types import numeric_types
from warp_mps.coupling.added_mass import LEAST, PASSES, STEPS, Mobility
from warp_mps.coupling.hydroelastic import Hydroelastic
from warp_mps.scene import Material, Scene, Support
from warp_mps.shapes import Box

STIFF = Material(500.0, 1e8, 0.3)
DT = 1e-3


def measured(scene: Scene) -> tuple[Hydroelastic, np.ndarray]:
    """A system whose mobilities were measured in its first state, and those."""
    system = system_of(scene)
    fluid = system.fluids.step
    fluid.time_step.longest = DT
    fluid.time_step.set_target(1.0)
    fluid.set_time_step()
    end = system.step.fit_time_step()
    system.step.predict()
    system.structure.save()
    system.step.measure_mobility(end)
    return system, system.step.mobility.array.numpy().astype(float)


@pytest.mark.parametrize("way", WAYS)
def test_a_free_body_moves_as_a_whole(way: dict) -> None:
    """One that is stiff: under forces F_j its acceleration is F/M, F their sum; b = F^2 / (M sum_j F_j^2)."""
    scene = pool(lump([0, 2], [6, 3], material=STIFF), cells=(6, 9), **{**way, "contact": ALONE})
    # no water below, so that pressure moves it
    water = scene.fluids[0]
    shape = replace(water.shape, positions=water.shape.positions[water.shape.positions[:, 1] > 5 * L0])
    system, found = measured(replace(scene, fluids=(replace(water, shape=shape),)))
    forces = system.step.passes.robin.forces_of(np.ones(system.fluids.model.count))
    mass = system.markers.masses.sum()
    uniform = float(np.sum(forces.sum(axis=0) ** 2) / (mass * np.sum(forces**2)))
    assert found.min() == found.max()
    assert found[0] == pytest.approx(uniform, rel=0.05)
    assert found[0] < 1.0 / system.markers.masses[0]


@pytest.mark.parametrize("way", WAYS)
def test_a_body_in_the_midst_of_water_is_moved_by_gradients(way: dict) -> None:
    """A uniform pressure only squeezes it."""
    scene = pool(lump([5, 4], [3, 3], material=STIFF), cells=(13, 11), **{**way, "contact": ALONE})
    system, found = measured(scene)
    fluids, mass = system.fluids, system.markers.masses.sum()
    x = fluids.state.x.numpy()[fluids.model.walls :]
    bounds = []
    for values in (np.ones(len(x)), *(x - x.mean(axis=0)).T):
        forces = system.step.passes.robin.forces_of(values)
        bounds.append(float(np.sum(forces.sum(axis=0) ** 2) / (mass * np.sum(forces**2))))
    free = 1.0 / system.markers.masses[0]
    assert bounds[0] < LEAST * free
    assert found[0] == pytest.approx(max(bounds), rel=0.2)
    assert found[0] > 20.0 * LEAST * free


def test_a_body_that_is_held_has_the_least() -> None:
    held = (Support(name="all", region=Box((10.0, 10.0))),)
    system, found = measured(pool(lump([2, 2], [4, 3]), cells=(8, 9), supports=held, **IMPLICIT))
    np.testing.assert_allclose(found, LEAST / system.markers.masses)


def of(*bodies: int) -> Mobility:
    """The mobility of markers of some bodies, of 2 kg each."""
    markers = SimpleNamespace(bodies=np.array(bodies), masses=np.full(len(bodies), 2.0))
    return Mobility(markers, types=numeric_types(2, "float64"), device=open_device("cpu"))  # type: ignore[arg-type]


def test_each_body_has_its_own() -> None:
    """Free particles, springs in a step of the midpoint rule, and a body without water about it."""
    mobility = of(0, 0, 1, 1, 2)
    np.testing.assert_array_equal(mobility.array.numpy(), 0.5)
    stiffness = np.array([0.0, 0.0, 3e6, 3e6, 0.0])[:, None]
    inertia = 2.0 + stiffness * (0.5 * DT) ** 2
    rng = np.random.default_rng(0)
    pattern = rng.normal(size=(5, 2))
    pattern[4] = 0.0
    mobility.measure(lambda f: f / inertia, [pattern, rng.normal(size=(5, 2)) * (pattern != 0.0)], np.ones((5, 2)))
    np.testing.assert_allclose(mobility.array.numpy(), [0.5, 0.5, 1.0 / 2.75, 1.0 / 2.75, 0.5], rtol=1e-12)


def test_nothing_wet_and_nothing_that_moves() -> None:
    mobility = of(0, 0)
    mobility.measure(lambda f: f, [np.zeros((2, 2))] * 3, np.zeros((2, 2)))
    np.testing.assert_array_equal(mobility.array.numpy(), 0.5)
    # a body that answers against the force, as one does whose period a step cannot resolve
    mobility.measure(lambda f: -f, [np.ones((2, 2))], np.zeros((2, 2)))
    np.testing.assert_array_equal(mobility.array.numpy(), LEAST * 0.5)


def test_it_is_measured_when_it_may_have_changed() -> None:
    mobility = of(0)
    assert mobility.is_due(DT)
    found = [mobility.is_due(DT * factor) for factor in (1.0, 1.2, 0.8, 1.3, 1.3, 0.9)]
    assert found == [False, False, False, True, False, True]
    mobility.note_passes(PASSES)
    assert not mobility.is_due(0.9 * DT)
    mobility.note_passes(PASSES + 1)
    assert mobility.is_due(0.9 * DT)
    assert [mobility.is_due(0.9 * DT) for _ in range(STEPS)].index(True) == STEPS - 1
    other = of(0)
    other.assign(mobility.arrays())
    assert not other.is_due(0.9 * DT)

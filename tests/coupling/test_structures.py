"""Bodies that take a step of the fluid several times, from the same state under other forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.bits import assert_same_bits
from tests.coupling.scenes import WAYS, afloat, hung, system_of
from tests.fluid.scenes import KINDS
from warp_mps.coupling.hydroelastic import Hydroelastic
from warp_mps.coupling.structures import SubsteppedStructure
from warp_mps.scene import Contact

BOTH = [*WAYS, {"integrator": "explicit", "contact": Contact(between="bodies", friction=0.3)}]


def push(system: Hydroelastic, force: np.ndarray | float) -> None:
    """Set the forces of the water on the elastic particles."""
    values = np.zeros(system.structure.external.numpy().shape)
    values[: system.particles.elastic] = force
    system.structure.external.assign(values)


@pytest.mark.parametrize("way", BOTH)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_every_pass_of_a_step_starts_from_the_saved_state(way: dict, dimension: int, precision: str) -> None:
    """Whatever was tried in between; with graphs and without."""
    ends = []
    for graphs in (True, False):
        system = system_of(hung(dimension, damping=1.0, **way), precision=precision, graphs=graphs)
        structure, rng = system.structure, np.random.default_rng(0)
        force = rng.normal(size=(system.particles.elastic, dimension))
        for step in range(1, 4):
            dt, left = structure.fit_time_step(2e-3, 1.0)
            structure.save()
            tried = []
            for factor in (step, -3.0 * step, step):
                push(system, factor * force)
                structure.advance(step * dt)
                tried.append({name: values.copy() for name, values in structure.arrays().items()})
            assert np.abs(tried[0]["v"] - tried[1]["v"]).max() > 1e-4
            assert left > 1
            if way["integrator"] == "explicit":
                assert_same_bits([tried[2]], [tried[0]])
                continue
            # a search that begins elsewhere ends as near to the solution, not at the same bits; statistics count all
            for name, values in tried[0].items():
                if name != "pace" and not name.startswith("coarse") and not name.endswith("statistics"):
                    close = (1e-6 if precision == "float64" else 1e-3) * np.abs(values).max(initial=0.0)
                    np.testing.assert_allclose(tried[2][name], values, rtol=0.0, atol=close, err_msg=name)
        ends.append(tried[2])
    assert_same_bits(ends[:1], ends[1:])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_free_body_gains_the_impulse_of_its_forces(way: dict, dimension: int) -> None:
    """And its weight's, to rounding, though it is deformed; a step that was tried before leaves nothing."""
    system = system_of(afloat(dimension=dimension, **way))
    structure, rng, time = system.structure, np.random.default_rng(1), 0.0
    masses = system.particles.masses[: system.particles.elastic]
    for step in range(4):
        force = rng.normal(size=(system.particles.elastic, dimension))
        dt, _ = structure.fit_time_step(2e-3 * (1.0 + 0.3 * step), 1.0)
        before = masses @ structure.solid.velocities()[: system.particles.elastic]
        structure.save()
        for tried in (5.0 * rng.normal(size=force.shape), force):
            push(system, tried)
            structure.advance(time + dt)
        time += dt
        gained = masses @ structure.solid.velocities()[: system.particles.elastic] - before
        gravity = masses.sum() * np.array([0.0, -9.81, 0.0][:dimension])
        expected = dt * (force.sum(axis=0) + gravity)
        near = 1e-11 if way["integrator"] == "explicit" else 1e-7
        np.testing.assert_allclose(gained, expected, atol=near * dt * np.abs(force).sum())


def test_substeps_divide_a_step() -> None:
    """Their number follows the step that is asked for, which is never exceeded, and the rest comes out even."""
    structure = system_of(hung(integrator="explicit")).structure
    assert isinstance(structure, SubsteppedStructure)
    rng, interval = np.random.default_rng(2), round(0.01 / structure.dt)
    assert interval * structure.dt == pytest.approx(0.01)
    for _ in range(200):
        rest, steps = interval, 0
        while rest:
            wish = structure.dt * rng.uniform(0.2, 9.0)
            dt, left = structure.fit_time_step(wish, rest * structure.dt)
            count = round(dt / structure.dt)
            assert dt == pytest.approx(count * structure.dt)
            assert 1 <= count <= max(1.0, wish / structure.dt * (1.0 + 1e-8))
            assert left == -(-rest // count)
            rest, steps = rest - count, steps + 1
            assert (rest == 0) == (left == 1)
        assert steps <= interval
    for count in (1, 2, 3, 7, 20):
        structure.fit_time_step(count * structure.dt, count * structure.dt)
        structure.save()
        u = structure.solid.state.u.numpy().copy()
        structure.advance(0.0)
        one = structure.solid.state.u.numpy().copy()
        structure.restore()
        np.testing.assert_array_equal(structure.solid.state.u.numpy(), u)
        for _ in range(count):
            structure.solid.step()
        np.testing.assert_array_equal(structure.solid.state.u.numpy(), one)


@pytest.mark.parametrize("way", WAYS)
def test_arrays_bring_back_what_is_shown(way: dict) -> None:
    """Forces of the water are part of the state."""
    system, other = (system_of(hung(**way)) for _ in range(2))
    structure = system.structure
    dt, _ = structure.fit_time_step(2e-3, 1.0)
    structure.save()
    push(system, np.random.default_rng(0).normal(size=(system.particles.elastic, 2)))
    structure.advance(dt)
    other.structure.assign(structure.arrays())
    shown: list[Any] = [[made.solid.internal_forces(), made.solid.reactions()] for made in (system, other)]
    np.testing.assert_array_equal(shown[1][0], shown[0][0])
    np.testing.assert_array_equal(shown[1][1], shown[0][1])
    assert np.abs(shown[0][1]).max() > 0.0

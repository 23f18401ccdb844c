"""Explicit viscosity and no-slip walls."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fluid.scenes import (
    DT,
    KINDS,
    L0,
    box,
    fluids_of,
    pairs,
    predicted,
    scene_of,
    small,
    stir,
    tank,
    tolerance,
    total_momentum,
    wall_count,
    water,
)
from warp_mps.scene import Flow, Liquid, Wall

NU = 0.01
VISCOUS = Liquid(viscosity=NU)


@pytest.mark.parametrize("slip", ["free", "no"])
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_viscous_forces_are_those_of_numpy(dimension: int, precision: str, slip: str) -> None:
    """And walls hold the water back only where it does not slip: they get what it loses."""
    fluid = {"liquid": VISCOUS}
    scene = tank(small(dimension), wall={"slip": slip}, fluid=fluid, gravity=(), time_step=DT)
    fluids = fluids_of(scene, precision=precision)
    stir(fluids)
    w = wall_count(fluids)
    u = fluids.state.u.numpy().astype(float)
    _, _, weights = pairs(fluids)
    if slip == "free":
        weights[:, :w] = 0.0
    else:
        near, beside = weights[:w, w:], weights[:w, w:].sum(axis=1) > 0.0
        u[:w][beside] = -(near @ u[w:])[beside] / near.sum(axis=1)[beside, None]
    factor = NU * fluids.model.operators.laplacian
    expected = factor * (weights[w:] @ u - weights[w:].sum(axis=1)[:, None] * u[w:])
    near = tolerance(precision, 1e-9, 1e-3)
    np.testing.assert_allclose(predicted(fluids), expected, atol=near * np.abs(expected).max())
    impulse = fluids.state.impulse.numpy()[:w]
    lost = -1000.0 * L0**dimension * DT * expected.sum(axis=0)
    if slip == "free":
        assert not impulse.any()
        lost = np.zeros(dimension)
    np.testing.assert_allclose(impulse.sum(axis=0), lost, atol=near * np.abs(impulse).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_viscosity_of_a_quadratic_velocity_is_exact(dimension: int) -> None:
    """On the lattice, away from the ends."""
    cells = (14, 14, 9)[:dimension]
    block = water([0.0] * dimension, [L0 * n for n in cells], liquid=VISCOUS)
    fluids = fluids_of(scene_of(block, dimension=dimension, time_step=DT))
    x = fluids.state.x.numpy()
    middle = x.mean(axis=0)
    u = np.zeros_like(x)
    u[:, 0] = 3.0 * (x[:, 1] - middle[1]) ** 2
    u[:, 1] = (x[:, 0] - middle[0]) ** 2 + (x[:, 1] - middle[1])
    fluids.state.u.assign(u)
    inside = np.abs(x - middle).max(axis=1) < 1.1 * L0
    expected = NU * np.array([6.0, 2.0, 0.0][:dimension])
    found = predicted(fluids)[inside]
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-8, atol=1e-12)


def channel_error(cells: int) -> float:
    """Error of a flow along a channel that starts from rest, relative to its speed (root mean squares)."""
    height, g, end, spacing = 0.2, 0.1, 1.0, 0.2 / cells
    width, t = 16 * spacing, 4 * spacing
    walls = tuple(
        Wall(name=name, shape=box([0.0, low], [width, low + t]), spacing=spacing, slip="no")
        for name, low in (("floor", -t), ("ceiling", height))
    )
    body = water([0.0, 0.0], [width, height], spacing=spacing, liquid=VISCOUS)
    flow = Flow(domain=([0.0, -t], [width, height + t]), periodic=(0,))
    fluids = fluids_of(scene_of(body, walls=walls, gravity=(g, 0.0), flow=flow))
    fluids.advance(end)
    w = wall_count(fluids)
    y, u = fluids.readings.positions()[w:, 1], fluids.velocities()[w:]
    expected = 0.5 * g / NU * y * (height - y)
    for k in np.pi * np.arange(1, 40, 2) / height:
        expected -= 4.0 * g / (NU * height * k**3) * np.sin(k * y) * np.exp(-(k**2) * NU * end)
    speed = np.sqrt(np.mean(expected**2))
    assert np.abs(u[:, 1]).max() < 0.05 * speed
    return float(np.sqrt(np.mean((u[:, 0] - expected) ** 2)) / speed)


def test_a_flow_along_a_channel_is_that_of_poiseuille() -> None:
    """While it builds up, between walls without slip, with an error of the second order in the spacing.

    The row beside a wall is too fast, for the wall's velocity is that of its particles, half a spacing behind its face.
    """
    coarse, fine = channel_error(8), channel_error(16)
    assert coarse < 0.06
    assert fine < 0.25 * coarse


def test_the_work_of_walls_that_drag_the_water_along() -> None:
    """What sliding walls without slip do by viscosity is what the water gains, at first."""
    fluids = fluids_of(tank((8, 8), wall={"slip": "no"}, fluid={"liquid": VISCOUS}, gravity=()))
    w, u = wall_count(fluids), fluids.state.u.numpy()
    u[:w] = [0.0, 0.7]
    fluids.state.u.assign(u)
    predicted(fluids)
    impulse, work = fluids.state.impulse.numpy(), fluids.state.work.numpy()
    assert impulse[:, 1].min() < 0.0
    np.testing.assert_allclose(work, -0.7 * impulse[:, 1], rtol=1e-12)
    assert total_momentum(fluids)[1] == pytest.approx(-impulse[:, 1].sum())

"""Water at rest: what is balanced there, and when water counts as at rest."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.fluid.scenes import DT, L0, fluids_of, stir, tank, until, wall_count
from warp_mps.fluid.fluids import Fluids
from warp_mps.fluid.operator_constants import gradient_factor
from warp_mps.fluid.still_water import RADIUS
from warp_mps.scene import Flow

G, RHO = 9.81, 1000.0


def least_shear_stiffness(dimension: int, radius: float) -> float:
    """Least stiffness of a lattice against shear waves, with pair forces of a uniform pressure [p/(rho l0^2)]."""
    steps = np.arange(-3, 4)
    x = np.array([k for k in itertools.product(steps, repeat=dimension) if any(k)], float)
    r = np.linalg.norm(x, axis=1)
    x, q = x[r < radius], r[r < radius] / radius
    c = gradient_factor(dimension, radius) / radius**2 * (1.0 - q) ** 3
    slope = -3.0 * gradient_factor(dimension, radius) / radius**3 * (1.0 - q) ** 2
    n = x / (q * radius)[:, None]
    stiffness = -c[:, None, None] * np.eye(dimension) - (slope * q * radius)[:, None, None] * n[:, :, None] * n[:, None]
    waves = np.linspace(-np.pi, np.pi, 13)
    least = np.inf
    for k in itertools.product(waves, repeat=dimension):
        if not any(k):
            continue
        wave = np.array(k) / np.linalg.norm(k)
        along = np.outer(wave, wave)
        across = np.eye(dimension) - along
        matrix = across @ np.einsum("nab,n->ab", stiffness, 1.0 - np.cos(x @ np.array(k))) @ across
        least = min(least, float(np.linalg.eigvalsh(matrix + 100.0 * along)[0]))
    return least


def test_the_lattice_is_stable_under_the_weight_of_water_at_rest_alone() -> None:
    for dimension, usual in ((2, 3.1), (3, 2.2)):
        assert least_shear_stiffness(dimension, RADIUS) > 0.0
        assert least_shear_stiffness(dimension, usual) < -1e-3


def resting(cells: tuple[int, ...], *, room: tuple[int, ...]) -> tuple[Fluids, np.ndarray]:
    """Water at rest in a tank, its equation assembled for pressures that grow with depth; these pressures [Pa]."""
    fluids = fluids_of(tank(cells, room=room))
    w = wall_count(fluids)
    depth = cells[1] * L0 - fluids.state.x.numpy()[w:, 1]
    u = fluids.state.u.numpy()
    u[w:, 1] = -G * DT
    fluids.state.u.assign(u)
    fluids.state.p.assign(RHO * G * depth)
    fluids.step.time_step.dt.assign([DT])
    fluids.step.assemble()
    return fluids, RHO * G * depth


@pytest.mark.parametrize("cells", [(10, 6), (3, 6), (5, 4, 4)])
def test_forces_of_water_at_rest_cancel_gravity(cells: tuple[int, ...]) -> None:
    """Of every particle, beside walls that stand above the level, in a shaft and in 3-D."""
    room = (cells[0], cells[1] + 4, *cells[2:])
    fluids, _ = resting(cells, room=room)
    fluids.step.forces.find_slopes()
    fluids.step.forces.accelerate(fluids.step.time_step.dt, fluids.step.velocity_change)
    a = fluids.step.velocity_change.numpy() / DT
    a[:, 1] -= G
    assert fluids.step.pressure.rest.numpy()[0] == 1.0
    assert np.abs(a).max() < 1e-9 * G


@pytest.mark.parametrize("cells", [(10, 6), (3, 6), (1, 6)])
def test_rows_of_water_at_rest_hold_its_pressure(cells: tuple[int, ...]) -> None:
    """Beside walls too, which fill a part of what is beyond the surface: there 0.19 rho g/l0 were wrong."""
    fluids, p = resting(cells, room=(cells[0], cells[1] + 4))
    matrix = fluids.step.pressure.matrix
    first, count, index = matrix.first.numpy(), matrix.count.numpy(), matrix.index.numpy()
    value, product = matrix.value.numpy(), matrix.diagonal.numpy() * p
    for k in range(len(p)):
        row = slice(first[k], first[k] + count[k])
        product[k] -= value[row] @ p[index[row]]
    residual = (product - fluids.step.pressure.rhs.numpy()) / (RHO * G / L0)
    print(f"largest residual {np.abs(residual).max():.4f} rho g/l0")
    assert np.abs(residual).max() < 0.02


def test_water_comes_to_rest() -> None:
    """And stays on its lattice; it went round at 0.02 sqrt(g l0) and moved by more than half a spacing."""
    fluids = fluids_of(tank((12, 6), room=(12, 10)))
    w = wall_count(fluids)
    start = fluids.readings.positions()[w:].copy()
    until(fluids, 1.0, 0.1)
    moved = np.abs(fluids.readings.positions()[w:] - start).max() / L0
    speed = float(np.sqrt((fluids.velocities()[w:] ** 2).sum(axis=1).mean() / (G * L0)))
    print(f"moved by {moved:.3f} l0, speed {speed:.1e} sqrt(g l0)")
    assert moved < 0.03
    assert speed < 1e-3


@pytest.mark.parametrize(
    ("flow", "gravity"), [({"scheme": "corrected"}, -G), ({"negative_pressure": "allowed"}, -G), ({}, 0.0)]
)
def test_only_heavy_water_of_the_conservative_scheme_rests(flow: dict, gravity: float) -> None:
    fluids = fluids_of(tank((6, 6), flow=Flow(**flow), gravity=(0.0, gravity)))
    fluids.step.time_step.dt.assign([DT])
    fluids.step.assemble()
    assert fluids.step.pressure.rest.numpy()[0] == 0.0


def test_water_that_is_about_to_move_does_not_rest() -> None:
    """A column without a wall at its side, and particles that are too close."""
    column, crowd = fluids_of(tank((6, 6), room=(12, 8))), fluids_of(tank((6, 6)))
    x = crowd.state.x.numpy()
    x[-1, 0] += 0.2 * L0 * (1.0 if x[-1, 0] < 3.0 * L0 else -1.0)
    crowd.state.x.assign(x)
    for fluids in (column, crowd):
        fluids.step.time_step.dt.assign([DT])
        fluids.step.assemble()
        assert fluids.step.pressure.rest.numpy()[0] == 0.0


def test_water_that_moves_does_not_rest() -> None:
    fluids = fluids_of(tank((6, 6)))
    stir(fluids, amount=0.0, speed=0.1)
    fluids.step.time_step.dt.assign([DT])
    fluids.step.assemble()
    assert fluids.step.pressure.rest.numpy()[0] == 0.0

"""Orbits and waves as exact solutions have them, periodic boundaries, and particles that leave the domain."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.fluid.scenes import (
    L0,
    fluids_of,
    periodic_box,
    put,
    scene_of,
    tank,
    tolerance,
    until,
    wall_count,
    water,
)
from warp_mps.scene import BodyForce, Flow, Liquid, VelocityField

G = 9.81


def orbit(dt: float, scheme: str) -> tuple[float, float]:
    """A particle alone on a spring of 5 rad/s, after 1 s: its distance from the exact orbit [m], and steps taken."""
    start, speed, omega = np.array([0.31, 0.11]), np.array([0.2, -0.4]), 5.0
    spring = BodyForce(name="spring", acceleration=lambda x, t: -(omega**2) * x)
    flow = Flow(scheme=scheme, courant=1.0, domain=([-1.0, -1.0], [1.0, 1.0]))
    body = water([0.3, 0.1], [0.3 + L0, 0.1 + L0], velocity=speed, liquid=Liquid(viscosity=0.0))
    fluids = fluids_of(scene_of(body, body_forces=(spring,), flow=flow, time_step=dt))
    steps = fluids.advance(1.0)
    exact = start * np.cos(omega) + speed / omega * np.sin(omega)
    return float(np.linalg.norm(fluids.readings.positions()[0] - exact)), steps


@pytest.mark.parametrize(("scheme", "order", "largest"), [("conservative", 2, 2e-4), ("corrected", 1, 9e-3)])
def test_the_order_in_time(scheme: str, order: int, largest: float) -> None:
    """Second at the midpoint of a step, body force and all, and first at predicted positions."""
    (coarse, few), (fine, many) = orbit(0.01, scheme), orbit(0.005, scheme)
    assert (few, many) == (100, 200)
    assert fine < coarse < largest
    assert coarse / fine == pytest.approx(2.0**order, rel=0.1)


def test_a_standing_wave_keeps_its_energy() -> None:
    """To 1 % from its first period to its second, 14 particles deep, inviscid.

    The pressure at predicted positions takes 2 pi omega dt = 7.6 %. Later, with particles in disorder, more is lost.
    """
    depth = 14 * L0
    k = 0.5 * np.pi / depth
    omega = np.sqrt(G * k * np.tanh(k * depth))
    crest = (0.0, 0.04 * depth * omega)
    field = VelocityField(
        kind="standing_wave", amplitude=crest, axis=(1.0, 0.0), origin=(0.0, 0.0), depth=depth, length=4 * depth
    )
    body = {"velocity_field": field, "liquid": Liquid(viscosity=0.0)}
    fluids = fluids_of(tank((28, 14), room=(28, 20), fluid=body))
    w, speeds, period = wall_count(fluids), [], 2.0 * np.pi / omega

    def look(_: float) -> None:
        x, u = fluids.readings.positions()[w:], fluids.velocities()[w:]
        across, up = -np.sin(k * x[:, 0]) * np.cosh(k * x[:, 1]), np.cos(k * x[:, 0]) * np.sinh(k * x[:, 1])
        speeds.append(np.sum(u[:, 0] * across + u[:, 1] * up) / np.sum(across**2 + up**2))

    until(fluids, 2.0 * period, period / 40, look)
    angles = 2.0 * np.pi * np.arange(1, 41) / 40
    first, second = (abs(np.exp(1j * angles) @ np.array(part)) ** 2 for part in (speeds[:40], speeds[40:]))
    assert 2.0 * np.pi * omega * fluids.model.longest_step == pytest.approx(0.076, rel=0.01)
    assert second / first == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_particles_go_round_a_period(precision: str) -> None:
    """A body of water that fills a periodic box flows through it unhindered."""
    scene = periodic_box((14, 13))
    fluids = fluids_of(scene, precision=precision)
    start, size = fluids.readings.positions(), np.array([14, 13]) * L0
    velocity = np.array([1.3, -0.7])
    fluids.state.u.assign(np.broadcast_to(velocity, start.shape))
    fluids.advance(0.5)
    x = fluids.readings.positions()
    assert (x >= 0.0).all()
    assert (x <= size).all()
    expected = np.mod(start + 0.5 * velocity, size)
    gap = x - expected
    gap -= size * np.round(gap / size)
    np.testing.assert_allclose(gap, 0.0, atol=tolerance(precision, 1e-12, 1e-4) * size.max())
    np.testing.assert_allclose(fluids.velocities(), np.broadcast_to(velocity, x.shape), rtol=tolerance(precision))
    assert fluids.readings.lost() == 0


def test_what_leaves_the_domain_is_lost_and_stays_where_it_left() -> None:
    """The rest goes on as if it had never been there."""
    flow = Flow(domain=([-0.5, -0.5], [0.5, 0.5]))
    fluids = fluids_of(scene_of(water([0.0, 0.0], [8 * L0, 8 * L0], liquid=Liquid(viscosity=0.0)), flow=flow))
    put(fluids, {0: ([0.49, 0.3], [3.0, 0.0]), 1: ([0.47, 0.3], [1.0, 0.0])})
    fluids.advance(0.02)
    assert fluids.readings.lost() == 1
    first = fluids.readings.positions()[0]
    assert first[0] > 0.5
    assert not fluids.velocities()[0].any()
    assert re.fullmatch(
        r"1 of 64 fluid particles have left the domain: 1 at its high x end, as particle 0 .*: close the tank .*",
        fluids.trouble() or "",
    )
    fluids.advance(0.025)
    np.testing.assert_array_equal(fluids.readings.positions()[0], first)
    assert not fluids.velocities()[0].any()
    # its neighbour went on alone
    np.testing.assert_allclose(fluids.velocities()[1], [1.0, 0.0], atol=1e-12)
    assert fluids.pressures()[0] == 0.0


def test_the_pressure_of_the_rest_does_not_move_what_is_lost() -> None:
    """Water whose uppermost row is thrown out of the domain, with the rows below it under pressure."""
    fluids = fluids_of(tank((8, 12), flow=Flow(domain=([-0.5, -0.5], [0.5, 12.0 * L0]))))
    upper = fluids.readings.positions()[:, 1] > 11.0 * L0
    upper[: wall_count(fluids)] = False
    u = fluids.velocities()
    u[upper] = [0.0, 5.0]
    fluids.state.u.assign(u)
    fluids.advance(3e-3)
    assert fluids.readings.lost() == upper.sum() == 8
    first = fluids.readings.positions()
    for k in range(4, 30):
        fluids.advance(k * 1e-3)
        np.testing.assert_array_equal(fluids.readings.positions()[upper], first[upper])
        assert not fluids.velocities()[upper].any()
    # the depth of the remaining water
    pressure = fluids.pressures()[wall_count(fluids) :].max() / (1000.0 * 9.81 * L0)
    assert 9.5 < pressure < 12.0

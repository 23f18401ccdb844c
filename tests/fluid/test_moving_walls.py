"""Water in tanks whose walls move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.fluid.scenes import KINDS, L0, fluids_of, tank, total_momentum, until
from tests.fluid.scenes import wall_count as walls_of
from warp_mps.fluid.fluids import Fluids
from warp_mps.scene import HarmonicMotion, HarmonicRotation, Liquid, Scene, TableMotion, TableRotation, Wall

RHO, G = 1000.0, 9.81
END = 0.4


def moved(scene: Scene, name: str, **fields: object) -> Scene:
    """The scene with a wall that moves."""
    walls = tuple(replace(wall, **fields) if wall.name == name else wall for wall in scene.walls)  # type: ignore[arg-type]
    return replace(scene, walls=walls)


def stroke(length: float, *, dimension: int = 2) -> TableMotion:
    """A stroke along x from rest to rest."""
    times = np.array([0.0, 0.5 * END, END])
    rows = np.zeros((3, dimension))
    rows[:, 0] = 0.0, 0.5 * length, length
    return TableMotion(times=times, displacements=rows, interpolation="cubic")


class Account:
    """Impulses, works and momenta of a run, added up interval by interval."""

    def __init__(self, fluids: Fluids) -> None:
        self.fluids, self.momentum, self.start = fluids, total_momentum(fluids), fluids.energy()
        self.impulse = np.zeros_like(self.momentum)
        self.peaks: list[float] = []

    def run(self, end: float, interval: float) -> None:
        """Advance to a time."""
        mass = len(self.fluids.state.p) * RHO * L0 ** len(self.momentum)

        def look(_: float) -> None:
            self.impulse -= interval * self.fluids.contact_forces().sum(axis=0)
            self.impulse[1] -= interval * mass * G
            self.peaks.append(self.fluids.pressures().max())

        until(self.fluids, end, interval, look)

    @property
    def error(self) -> float:
        """What the momentum is off that the impulses make, relative to the weight's."""
        gained = total_momentum(self.fluids) - self.momentum
        return float(np.abs(gained - self.impulse).max() / np.abs(self.impulse).max())


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_a_piston_pushes_the_water_up(dimension: int, precision: str) -> None:
    """No water gets behind it; what it gives is what the water has, and the level is that of the volume."""
    cells, room = ((16, 6), (16, 14)) if dimension == 2 else ((12, 5, 4), (12, 10, 4))
    length = 4 * L0
    scene = moved(tank(cells, room=room), "x_low", motion=stroke(length, dimension=dimension))
    fluids = fluids_of(scene, precision=precision)
    account, w = Account(fluids), walls_of(fluids)
    account.run(END, 0.02)
    x = fluids.readings.positions()[w:]
    assert x[:, 0].min() > length
    assert fluids.readings.lost() == 0
    assert account.error < (1e-11 if precision == "float64" else 1e-3)
    work = fluids.energy().work
    assert work > 0.0
    # it has lifted the water, and what it has not is lost in waves and splashes
    deep = cells[1] * L0
    weight = RHO * G * np.prod(cells) * L0**dimension
    lift = 0.5 * weight * deep * (cells[0] / (cells[0] - length / L0) - 1.0)
    assert 0.9 * lift < work < 2.0 * lift
    rise = x[:, 1].mean() / (0.5 * deep)
    assert rise == pytest.approx(cells[0] / (cells[0] - length / L0), rel=0.08)


def test_a_piston_that_starts_at_once_gives_the_water_its_speed() -> None:
    """A table of straight lines makes its speed jump: an impulse, to which the water answers as one."""
    table = TableMotion(times=np.array([0.0, 1.0]), displacements=np.array([[0.0, 0.0], [0.2, 0.0]]))
    fluids = fluids_of(moved(tank((16, 6), room=(16, 14)), "x_low", motion=table))
    w = walls_of(fluids)
    account = Account(fluids)
    account.run(0.02, 0.01)
    x, u = fluids.readings.positions()[w:], fluids.velocities()[w:]
    beside = (x[:, 0] < 2.5 * L0) & (x[:, 1] < 3 * L0)
    # the potential flow of an impulse, without pressure at the surface (Lamb, section 11), the piston's face at 0.2 t
    k = (2 * np.arange(200) + 1) * np.pi / (2.0 * 6 * L0)
    waves = 0.4 / (k * 6 * L0) * (-1.0) ** np.arange(200)
    expected = (waves * np.cos(k * x[beside, 1:]) * np.exp(-k * (x[beside, :1] - 0.004))).sum(axis=1)
    assert np.mean(u[beside, 0]) == pytest.approx(expected.mean(), rel=0.03)
    assert account.error < 1e-11


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_tank_that_is_carried_along_carries_its_water(dimension: int) -> None:
    """Full and closed, the water moves with it as a solid does, and no particle changes its place for a neighbour's."""
    cells = (8, 7) if dimension == 2 else (5, 5, 4)
    motion = HarmonicMotion(amplitude=(0.02, 0.01, 0.0)[:dimension], frequency=2.0)
    still = {"liquid": Liquid(viscosity=0.0), "velocity": 4.0 * np.pi * np.array([0.02, 0.01, 0.0])[:dimension]}
    scene = tank(cells, lid=True, wall={"motion": motion}, fluid=still, gravity=(), time_step=1e-3)
    fluids = fluids_of(scene)
    w, start = walls_of(fluids), fluids.readings.positions()
    for t in (0.1, 0.2, 0.33):
        fluids.advance(t)
        moves = fluids.readings.positions() - start
        expected = np.sin(4.0 * np.pi * t) * np.array([0.02, 0.01, 0.0])[:dimension]
        np.testing.assert_allclose(moves[:w], np.broadcast_to(expected, moves[:w].shape), atol=1e-12)
        np.testing.assert_allclose(moves[w:].mean(axis=0), expected, atol=0.05 * L0)
        assert np.abs(moves[w:] - expected).max() < L0


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_tank_that_is_turned_keeps_its_water(dimension: int) -> None:
    """By a right angle: all of it stays inside, and impulses and momentum agree."""
    cells, room = ((10, 6), (10, 10)) if dimension == 2 else ((6, 4, 4), (6, 6, 4))
    axis = {"axis": (0.0, 0.0, 1.0)} if dimension == 3 else {}
    pivot = (0.5 * room[0] * L0, 0.5 * room[1] * L0, 0.0)[:dimension]
    times, angles = np.array([0.0, 0.5 * END, END]), np.array([0.0, 0.25 * np.pi, 0.5 * np.pi])
    turn = TableRotation(times=times, angles=angles, pivot=pivot, interpolation="cubic", **axis)
    fluids = fluids_of(tank(cells, room=room, lid=True, wall={"rotation": turn}))
    account, w = Account(fluids), walls_of(fluids)
    account.run(END, 0.02)
    x = fluids.readings.positions()
    walls = fluids.model.particles.positions[:w]
    arm = walls - np.array(pivot)
    turned = arm.copy()
    turned[:, 0], turned[:, 1] = -arm[:, 1], arm[:, 0]
    np.testing.assert_allclose(x[:w], turned + np.array(pivot), atol=1e-12)
    size = np.array(room) * L0
    back = x[w:] - np.array(pivot)
    inside = np.column_stack((back[:, 1], -back[:, 0])) + 0.5 * size[:2]
    assert (inside > 0.0).all()
    assert (inside < size[:2]).all()
    assert account.error < 1e-11
    assert fluids.readings.lost() == 0
    np.testing.assert_allclose(fluids.rotations()[:w, -1], 0.5 * np.pi)
    assert not fluids.rotations()[w:].any()


def test_a_rocked_tank_gains_the_work_of_its_walls() -> None:
    """Energy that is held never grows by more than what the walls have put in."""
    rock = HarmonicRotation(amplitude=0.15, frequency=1.5, pivot=(8 * L0, 0.0))
    fluids = fluids_of(tank((16, 6), room=(16, 14), wall={"rotation": rock}))
    balance, works = [fluids.energy().balance], []

    def look(_: float) -> None:
        energy = fluids.energy()
        balance.append(energy.balance)
        works.append(energy.work)

    until(fluids, 0.7, 0.02, look)
    scale = RHO * G * 16 * 6 * L0**2 * 6 * L0
    course = np.array(balance)
    assert max(works) > 0.02 * scale
    assert (course - np.minimum.accumulate(course)).max() < 1e-2 * scale


def test_neighbouring_walls_may_move_apart() -> None:
    """A gate is lifted: the water flows out under it, and none goes through it."""
    t = 4 * L0
    scene = tank((8, 8), room=(20, 12))
    gate = Wall(
        name="gate",
        shape=scene.walls[1].shape,
        spacing=L0,
        motion=TableMotion(
            times=np.array([0.0, 0.4]), displacements=np.array([[0.0, 0.0], [0.0, 0.12]]), interpolation="cubic"
        ),
    )
    shape = replace(gate.shape, center=(8 * L0 + 0.5 * t, gate.shape.center[1], 0.0))
    fluids = fluids_of(replace(scene, walls=(*scene.walls, replace(gate, shape=shape))))
    w = walls_of(fluids)
    behind = []

    def look(_: float) -> None:
        x = fluids.readings.positions()
        lowest = x[:w][fluids.model.particles.walls[:w] == 3][:, 1].min()
        in_gate = (x[w:, 0] > 8 * L0 + 0.5 * L0) & (x[w:, 0] < 8 * L0 + t - 0.5 * L0) & (x[w:, 1] > lowest + 0.5 * L0)
        assert not in_gate.any()
        behind.append((x[w:, 0] > 8 * L0 + t).sum())

    until(fluids, 0.4, 0.02, look)
    assert behind[2] == 0
    assert behind[-1] > 10
    assert fluids.readings.lost() == 0

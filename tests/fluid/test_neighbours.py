"""Neighbour lists of moving particles against all pairs."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from tests.fluid.scenes import KINDS, apart
from warp_mps.core.device import open_device
from warp_mps.core.types import numeric_types
from warp_mps.fluid.neighbour_room import MOST_ROOM, expected_neighbours, most_particles
from warp_mps.fluid.neighbours import NeighbourLists
from warp_mps.scene.numerics import SKIN

L0 = 0.1
RADIUS = 2.1 * L0
LOW, HIGH = np.array([-0.7, 0.3, 2.0]), np.array([0.9, 1.6, 3.0])


def lists_of(
    count: int, *, walls: int = 0, periodic: tuple[int, ...] = (), neighbours: int = 200, dimension: int = 2,
    precision: str = "float64",
) -> NeighbourLists:  # fmt: skip
    """Lists of a number of particles within LOW and HIGH."""
    return NeighbourLists(
        count, walls=walls, low=LOW[:dimension], high=HIGH[:dimension], periodic=periodic, radius=RADIUS, spacing=L0,
        neighbours=neighbours, types=numeric_types(dimension, precision), device=open_device("cpu"),
    )  # fmt: skip


def points(count: int, dimension: int = 2, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(LOW[:dimension], HIGH[:dimension], (count, dimension))


class Cloud:
    """Points on a device with their lists."""

    def __init__(self, x: np.ndarray, *, precision: str = "float64", **options: object) -> None:
        self.lists = lists_of(len(x), dimension=x.shape[1], precision=precision, **options)  # type: ignore[arg-type]
        self.x = wp.array(x, dtype=numeric_types(x.shape[1], precision).vec, device="cpu")
        self.lost = wp.zeros(len(x), dtype=wp.int32, device="cpu")
        self.lists.renew(self.x, self.lost)

    def move(self, x: np.ndarray) -> None:
        """Put the points elsewhere and let the lists follow."""
        self.x.assign(x)
        self.lists.update(self.x, self.lost)

    @property
    def listed(self) -> list[list[int]]:
        """Neighbours of each point, in order."""
        rows, counts = self.lists.listed.numpy(), self.lists.count.numpy()
        return [sorted(row[:count].tolist()) for row, count in zip(rows, counts, strict=True)]

    def near(self, reach: float) -> list[list[int]]:
        """All that is closer than the reach, by all pairs."""
        r = np.linalg.norm(apart(self.x.numpy().astype(float), np.array(self.lists.period, float)), axis=2)
        np.fill_diagonal(r, np.inf)
        return [np.flatnonzero(row < reach).tolist() for row in r]


REACH = RADIUS + SKIN * L0
PERIODS = [(), (0,), (1,), (0, 1)]


@pytest.mark.parametrize("periodic", PERIODS)
@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_lists_are_those_of_all_pairs(dimension: int, precision: str, periodic: tuple[int, ...]) -> None:
    cloud = Cloud(points(300, dimension), precision=precision, periodic=periodic)
    rounding = 0.0 if precision == "float64" else 1e-5 * L0
    most, least = cloud.near(REACH + rounding), cloud.near(REACH - rounding)
    for found, may, must in zip(cloud.listed, most, least, strict=True):
        assert set(must) <= set(found) <= set(may)
        assert len(set(found)) == len(found)
    assert cloud.lists.overflowed() is None


@pytest.mark.parametrize("periodic", [(2,), (0, 1, 2)])
def test_lists_across_the_third_axis(periodic: tuple[int, ...]) -> None:
    cloud = Cloud(points(300, 3, seed=4), periodic=periodic)
    assert cloud.listed == cloud.near(REACH)


@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_on_the_corners_of_cells(dimension: int) -> None:
    """A lattice whose spacing is that of the cells, from the domain's corner on: nothing is decided by rounding."""
    lines = [np.arange(low, high - 1e-9, REACH / 2.0) for low, high in zip(LOW, HIGH, strict=True)][:dimension]
    x = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, dimension)
    cloud = Cloud(x)
    least, most = cloud.near(REACH * (1.0 - 1e-12)), cloud.near(REACH * (1.0 + 1e-12))
    for found, may, must in zip(cloud.listed, most, least, strict=True):
        assert set(must) <= set(found) <= set(may)


@pytest.mark.parametrize("periodic", [(), (0,)])
def test_particles_outside_the_domain_are_found_as_well(periodic: tuple[int, ...]) -> None:
    """Walls may reach out of it."""
    x = points(300)
    x[:80] += [2.1, 0.0] if periodic else [-2.9, -3.3]
    cloud = Cloud(x, periodic=periodic)
    assert cloud.listed == cloud.near(REACH)


def test_walls_are_no_neighbours_to_each_other() -> None:
    cloud = Cloud(points(200), walls=90)
    expected = [[j for j in row if i >= 90 or j >= 90] for i, row in enumerate(cloud.near(REACH))]
    assert cloud.listed == expected
    assert any(expected[:90])


def test_lost_particles_are_left_out() -> None:
    cloud = Cloud(points(200))
    lost = np.arange(200) % 5 == 0
    cloud.lost.assign(lost.astype(np.int32))
    cloud.lists.renew(cloud.x, cloud.lost)
    expected = [[] if lost[i] else [j for j in row if not lost[j]] for i, row in enumerate(cloud.near(REACH))]
    assert cloud.listed == expected


@pytest.mark.parametrize("share", [0.49, 0.51])
def test_lists_are_kept_until_a_particle_has_moved_by_half_of_the_margin(share: float) -> None:
    """Until then they hold every neighbour within the effective radius, whichever way the particles went."""
    x = points(300)
    cloud = Cloud(x)
    before = cloud.listed
    turn = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, len(x))
    cloud.move(x + share * SKIN * L0 * np.column_stack((np.cos(turn), np.sin(turn))))
    for found, must in zip(cloud.listed, cloud.near(RADIUS), strict=True):
        assert set(must) <= set(found)
    if share < 0.5:
        assert cloud.listed == before
    else:
        assert cloud.listed == cloud.near(REACH) != before
        np.testing.assert_array_equal(cloud.lists.x_listed.numpy(), cloud.x.numpy())


def test_one_particle_that_moves_renews_the_lists() -> None:
    x = points(300)
    cloud = Cloud(x)
    x[7] += [0.6 * SKIN * L0, 0.0]
    cloud.move(x)
    assert cloud.listed == cloud.near(REACH)


def test_moves_add_up_from_the_last_lists_on() -> None:
    x = points(300)
    cloud = Cloud(x)
    before = cloud.listed
    step = [0.2 * SKIN * L0, 0.0]
    for _ in range(2):
        x[::2] += step
        cloud.move(x)
    assert cloud.listed == before
    x[::2] += step
    cloud.move(x)
    assert cloud.listed == cloud.near(REACH)


def test_the_same_points_give_the_same_order() -> None:
    """So that sums are the same bits whenever the lists are made again."""
    x = points(300)
    first, second = Cloud(x), Cloud(x)
    second.move(x + 0.5)
    second.move(x)
    for name in ("listed", "count"):
        rows = [getattr(cloud.lists, name).numpy() for cloud in (first, second)]
        counts = first.lists.count.numpy()
        for a, b, count in zip(*rows, counts, strict=True):
            np.testing.assert_array_equal(np.atleast_1d(a)[:count], np.atleast_1d(b)[:count])


def test_too_many_neighbours_are_reported_and_not_written_past_the_room() -> None:
    x = points(300)
    crowd = np.arange(40, 90)
    x[crowd] = [0.1, 0.9] + 0.01 * L0 * x[crowd]
    cloud = Cloud(x, neighbours=12)
    room, told = cloud.lists.listed.shape[1], cloud.lists.overflowed()
    assert told is not None
    assert len(cloud.near(REACH)[told]) > room
    assert cloud.lists.count.numpy().max() == room
    # it is not forgotten when the crowd has parted
    cloud.move(points(300, seed=2))
    assert cloud.lists.overflowed() is not None
    assert cloud.lists.crowded()


def test_lists_grow_until_a_crowd_has_room() -> None:
    x = points(300)
    crowd = np.arange(40, 90)
    x[crowd] = [0.1, 0.9] + 0.01 * L0 * x[crowd]
    cloud = Cloud(x, neighbours=24)
    lists, room = cloud.lists, cloud.lists.listed.shape[1]
    while lists.crowded() and lists.can_grow:
        lists.grow()
        lists.renew(cloud.x, cloud.lost)
    assert lists.listed.shape[1] in (2 * room, 4 * room)
    assert lists.overflowed() is None
    assert cloud.listed == cloud.near(REACH)
    for _ in range(5):
        if lists.can_grow:
            lists.grow()
    assert lists.listed.shape[1] == MOST_ROOM * room


def test_lists_do_not_grow_beyond_what_can_be_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rows of the pressure matrix have the room of the lists, and their places are counted in 32 bits."""
    lists = Cloud(points(300), neighbours=24).lists
    assert lists.can_grow
    count, width = lists.listed.shape
    monkeypatch.setattr("warp_mps.fluid.neighbours.MOST_ENTRIES", 2 * width * count - 1)
    assert not lists.can_grow
    assert most_particles(3, 2.1) * int(1.75 * 57) < 2**31 <= (most_particles(3, 2.1) + 1) * int(1.75 * 57)


@pytest.mark.parametrize(
    ("dimension", "radius", "expected"), [(2, 3.1, 36), (2, 2.1, 20), (2, 1.9, 14), (3, 2.1, 57), (3, 1.4, 20)]
)
def test_the_neighbours_of_even_water(dimension: int, radius: float, expected: int) -> None:
    """By hand, with a margin of 0.3: shells of the lattice, or what a ball holds where the next one is close."""
    assert expected_neighbours(dimension, radius) == expected


def test_no_crowd_is_reported_where_there_is_none() -> None:
    line = np.arange(0.0, 1.0, L0)
    x = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2) + LOW[:2]
    assert Cloud(x, neighbours=12).lists.overflowed() is None

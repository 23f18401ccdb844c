"""The two-level preconditioner: an inverse that conjugate gradients may use, and few iterations at any length."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.bits import assert_restored_goes_on, assert_same_bits
from tests.elastic.hamiltonian.test_kernels import rotation
from tests.elastic.states import Strained, strain
from tests.scenes import HAMILTONIAN, RUBBER, block, random, scene_of
from warp_mps.core.linear.conjugate_gradient import ConjugateGradient, Statistics
from warp_mps.core.types import numeric_types
from warp_mps.elastic.implicit.coarse_matrix import positive_inverse
from warp_mps.elastic.implicit.solid import ImplicitSolid
from warp_mps.elastic.implicit.tangent_operator import Tangent
from warp_mps.elastic.implicit.two_level import TwoLevelPreconditioner
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Load, Scene, Support
from warp_mps.scene.choices import PRECISIONS
from warp_mps.shapes import Box


@dataclass(frozen=True)
class System:
    """A tangent at a state of strain, with its preconditioner."""

    held: Strained
    fixed: np.ndarray
    tangent: Tangent
    two_level: TwoLevelPreconditioner

    def solve(self, *, coarse: bool, tolerance: float = 1e-4) -> Statistics:
        """Solve for a random force."""
        size, numbers = self.fixed.size, numeric_types(self.fixed.shape[1])
        chosen = self.two_level if coarse else self.tangent
        options = {"tolerance": tolerance, "max_iterations": 20_000, "preconditioner": chosen}
        solver = ConjugateGradient(size, types=numbers, device="cpu", **options)  # type: ignore[arg-type]
        b = wp.array(random(size, seed=3) * ~self.fixed.ravel(), dtype=wp.float64, device="cpu")
        x = wp.zeros(size, dtype=wp.float64, device="cpu")
        solver.solve(self.tangent.operator, b, x)
        q = wp.zeros_like(x)
        self.tangent.multiply(x, q)
        residual = np.where(self.fixed.ravel(), 0.0, b.numpy() - q.numpy())
        assert np.linalg.norm(residual) <= 1.01 * tolerance * np.linalg.norm(b.numpy())
        return solver.read_statistics()


def system(
    scene: Scene,
    fixed: Box,
    *,
    bend: float = 0.0,
    inertia: float = 0.0,
    precision: str = "float64",
    parallel: bool | None = None,
) -> System:
    """Bodies that are held in a region, bent to a curvature [1/m] and turned."""
    held = strain(scene, precision)
    particles = held.particles
    d = particles.dimension
    x, y = particles.positions[:, 0], particles.positions[:, 1]
    bent = particles.positions.copy()
    if bend:
        bent[:, 0], bent[:, 1] = (1.0 / bend + y) * np.sin(bend * x), (1.0 / bend + y) * np.cos(bend * x) - 1.0 / bend
        bent = bent @ rotation(d, 0.7).T
    held.put(bent - particles.positions)
    inside = np.abs(particles.positions - np.array(fixed.center)[:d]) < 0.5 * np.array(fixed.size)[:d]
    clamped = np.repeat(inside.all(axis=1)[:, None], d, axis=1)
    numbers = numeric_types(d, precision)
    mass = wp.array(particles.masses, dtype=numbers.real, device="cpu")
    factor = wp.array([inertia], dtype=wp.float64, device="cpu")
    made = Tangent(held.model, held.state.u, mass, clamped, factor, types=numbers, device="cpu")
    options: dict[str, Any] = {"types": numbers, "device": "cpu", "parallel": parallel}
    two_level = TwoLevelPreconditioner(made, held.model, particles, held.state, clamped, factor, **options)
    made.prepare(made.operator, mass)
    two_level.rebuild()
    return System(held, clamped, made, two_level)


def beam(*counts: int, nu: float = 0.3, **options: Any) -> System:
    """A bar of rubber with as many particles along each axis, held at its left end."""
    size = 0.01 * np.array(counts)
    body = block(len(counts), shape=Box(tuple(size)), material=replace(RUBBER, poissons_ratio=nu))
    clamp = Box((0.06, 1.0, 1.0)[: len(counts)], center=(-0.5 * size[0], 0.0, 0.0)[: len(counts)])
    return system(scene_of(body, dimension=len(counts), elasticity=HAMILTONIAN), clamp, **options)


def dense(made: System, *, coarse: bool = True) -> np.ndarray:
    """The preconditioner among the free axes, as a matrix."""
    size, free = made.fixed.size, ~made.fixed.ravel()
    chosen, columns, z = made.two_level if coarse else made.tangent, [], wp.zeros(made.fixed.size, dtype=wp.float64)
    for column in np.eye(size)[free]:
        chosen.apply(wp.array(column, dtype=wp.float64, device="cpu"), z)
        assert (z.numpy()[~free] == 0.0).all()
        columns.append(z.numpy()[free].copy())
    return np.stack(columns, axis=1)


def matrix_of(made: System) -> np.ndarray:
    """The tangent among the free axes."""
    size, free = made.fixed.size, ~made.fixed.ravel()
    q, columns = wp.zeros(size, dtype=wp.float64, device="cpu"), []
    for column in np.eye(size)[free]:
        made.tangent.multiply(wp.array(column, dtype=wp.float64, device="cpu"), q)
        columns.append(q.numpy()[free].copy())
    return np.stack(columns, axis=1)


BARS = [(13, 4), (9, 4, 3)]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("counts", BARS)
def test_it_is_symmetric_and_positive(counts: tuple[int, ...], precision: str) -> None:
    inverse = dense(beam(*counts, bend=3.0, inertia=1e4, precision=precision))
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-10 * np.abs(inverse).max())
    assert np.linalg.eigvalsh(0.5 * (inverse + inverse.T)).min() > 0.0


@pytest.mark.parametrize("counts", [(30, 9), (9, 9, 9)])
def test_threads_that_share_sums_change_only_their_rounding(
    counts: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warp_mps.elastic.implicit.two_level.PARTICLES", 5)
    one, several = (beam(*counts, bend=2.0, parallel=parallel) for parallel in (False, True))
    assert several.two_level.parts > one.two_level.parts
    r = random(one.fixed.size, seed=6) * ~one.fixed.ravel()
    found = []
    for made in (one, several):
        z = wp.zeros(r.size, dtype=wp.float64, device="cpu")
        made.two_level.apply(wp.array(r, dtype=wp.float64, device="cpu"), z)
        found.append(z.numpy())
    np.testing.assert_allclose(found[1], found[0], atol=1e-8 * np.abs(found[0]).max())


@pytest.mark.parametrize(
    ("counts", "nu", "bend", "width"), [(BARS[0], 0.3, 3.0, 4.0), (BARS[1], 0.3, 3.0, 4.0), ((22, 4), 0.49, 0.3, 2.0)]
)
def test_its_coarse_part_is_exact_for_what_aggregates_can_do(
    counts: tuple[int, ...], nu: float, bend: float, width: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P (P^T A P)^-1 P^T A is a projection, of the rank of the aggregates' motions, that keeps a turn of all.

    Narrow aggregates of a nearly incompressible bar are coupled further than to the next, by the mean dilatations.
    """
    monkeypatch.setattr("warp_mps.elastic.implicit.aggregates.WIDTH", width)
    made = beam(*counts, nu=nu, bend=bend, inertia=1e4)
    projection = (dense(made) - dense(made, coarse=False)) @ matrix_of(made)
    np.testing.assert_allclose(projection @ projection, projection, atol=1e-8 * np.abs(projection).max())
    d = len(counts)
    rank = made.two_level.aggregates.count * 3 * (d - 1)
    assert np.trace(projection) == pytest.approx(rank, rel=1e-8)
    moved = made.held.particles.positions + made.held.state.u.numpy()
    turned = np.zeros_like(moved)
    turned[:, 0], turned[:, 1] = 0.3 - moved[:, 1], moved[:, 0]
    rigid = turned[~made.fixed]
    np.testing.assert_allclose(projection @ rigid, rigid, atol=1e-8 * np.abs(rigid).max())


@pytest.mark.parametrize(("counts", "angle", "factor", "most"), [((60, 4), 3.0, 6.0, 35), ((40, 4, 4), 0.5, 5.0, 50)])
def test_iterations_fall(counts: tuple[int, ...], angle: float, factor: float, most: int) -> None:
    """Of a bar at rest, and bent by an angle; bars of three dimensions buckle sideways at larger ones."""
    for bend in (0.0, angle / (0.01 * counts[0])):
        made = beam(*counts, bend=bend, inertia=10.0)
        blocks, both = made.solve(coarse=False).iterations, made.solve(coarse=True).iterations
        assert both <= most
        assert blocks >= factor * both


def test_iterations_do_not_grow_with_the_length() -> None:
    """Blocks alone take seven times as many at four times the length."""
    short, long = (beam(length, 4).solve(coarse=True).iterations for length in (50, 200))
    assert long <= 1.25 * short
    blocks = [beam(length, 4).solve(coarse=False).iterations for length in (50, 200)]
    assert blocks[1] > 3.0 * blocks[0]


def test_iterations_grow_little_with_the_width() -> None:
    narrow, wide = (beam(count, count).solve(coarse=True).iterations for count in (16, 48))
    assert wide <= 1.6 * narrow


def test_bodies_are_solved_side_by_side() -> None:
    """In blocks of their own, with as many iterations as one of them."""
    one = block(2, shape=Box((0.4, 0.04)))
    others = [replace(one, name=f"b{k}", shape=Box((0.4, 0.04), center=(0.0, 0.1 * k))) for k in range(4)]
    clamp = Box((0.06, 2.0), center=(-0.2, 0.0))
    alone = system(scene_of(one, elasticity=HAMILTONIAN), clamp)
    several = system(scene_of(*others, elasticity=HAMILTONIAN), clamp)
    assert several.two_level.matrix.total == 4 * alone.two_level.matrix.total
    assert several.solve(coarse=True).iterations <= 1.2 * alone.solve(coarse=True).iterations


def test_a_body_that_nothing_holds_is_solved_for_forces_in_balance() -> None:
    """Its matrix is singular."""
    made = system(scene_of(block(2, shape=Box((0.4, 0.04))), elasticity=HAMILTONIAN), Box((0.01, 0.01), center=(9, 9)))
    size = made.fixed.size
    along = random(size // 2, seed=4)
    force = np.zeros((size // 2, 2))
    # of no net force and no net moment
    x = made.held.particles.positions
    rigid = np.stack((np.ones(len(x)), np.zeros(len(x)), -x[:, 1], np.zeros(len(x)), np.ones(len(x)), x[:, 0]), axis=-1)
    basis = np.linalg.qr(rigid.reshape(len(x), 2, 3).reshape(size, 3))[0]
    force[:, 1] = along
    balanced = force.ravel() - basis @ (basis.T @ force.ravel())
    solver = ConjugateGradient(
        size, types=numeric_types(2), device="cpu", tolerance=1e-6, preconditioner=made.two_level
    )
    b, u = wp.array(balanced, dtype=wp.float64, device="cpu"), wp.zeros(size, dtype=wp.float64, device="cpu")
    solver.solve(made.tangent.operator, b, u)
    assert solver.count_unsolved() == 0
    assert solver.read_statistics().iterations <= 60


def test_inverses_are_positive_whatever_the_matrix() -> None:
    """Of one that is positive; of one that is not; with empty rows; and of no numbers."""
    root = random(6, 6, seed=5)
    good = root @ root.T + np.eye(6)
    np.testing.assert_allclose(positive_inverse(good, 1e-12), np.linalg.inv(good), rtol=1e-9)
    bad = good - 1.2 * np.eye(6)
    assert np.linalg.eigvalsh(bad).min() < 0.0
    assert np.linalg.eigvalsh(positive_inverse(bad, 1e-12)).min() > 0.0
    empty = good.copy()
    empty[2], empty[:, 2] = 0.0, 0.0
    rest = np.arange(6) != 2
    found = positive_inverse(empty, 1e-12)
    np.testing.assert_allclose(found[np.ix_(rest, rest)], np.linalg.inv(good[np.ix_(rest, rest)]), rtol=1e-9)
    assert (found[2] == 0.0).all()
    assert (found[:, 2] == 0.0).all()
    good[0, 0] = np.nan
    assert (positive_inverse(good, 1e-12) == 0.0).all()


@pytest.mark.parametrize("size", [31, 32, 33, 300])
def test_inverses_of_any_size(size: int) -> None:
    """Those that fill their tiles, those that do not, and those of several."""
    root = random(size, size, seed=6)
    good = root @ root.T + np.eye(size)
    found = positive_inverse(good, 0.0)
    np.testing.assert_allclose(found @ good, np.eye(size), atol=1e-10)
    assert (found == found.T).all()


INVERSE = """
import hashlib, numpy as np
from warp_mps.elastic.implicit.coarse_matrix import positive_inverse
k = np.arange(300.0)
matrix = np.exp(-np.abs(k - k[:, None]) / 9.0) + np.eye(300)
print(hashlib.sha256(positive_inverse(matrix, 1e-12).tobytes()).hexdigest())
"""


def test_inverses_are_the_same_bits_on_any_number_of_threads() -> None:
    """LAPACK's own inverse of 100 rows and more is not."""
    found = set()
    for threads in ("1", "2", "3"):
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": threads}
        done = subprocess.run([sys.executable, "-c", INVERSE], env=environment, capture_output=True, check=True)
        found.add(done.stdout)
    assert len(found) == 1


def swinging() -> Scene:
    """A slender bar that a force at its end bends to and fro in long steps."""
    body = block(2, shape=Box((0.6, 0.04)))
    clamp = Support(name="clamp", region=Box((0.06, 1.0), center=(-0.3, 0.0)))
    push = Load(name="push", region=Box((0.03, 1.0), center=(0.3, 0.0)), force=(0.0, -600.0), frequency=2.0)
    fields = {"supports": (clamp,), "loads": (push,), "elasticity": HAMILTONIAN}
    return scene_of(body, integrator="implicit", time_step=0.01, duration=1.0, **fields)


def test_a_run_that_renewed_it_goes_on_to_the_same_bits() -> None:
    """Before and after it is restored, and between its renewals."""
    simulation = Simulation(swinging())
    solid, renewals = simulation.solid, []
    assert isinstance(solid, ImplicitSolid)
    for _ in range(16):
        simulation.advance(1)
        renewals.append(solid.newton.preconditioner.reuse.rebuilds)
    assert renewals[7] >= 1
    assert renewals[-1] > renewals[7]
    assert_restored_goes_on(swinging(), 8, 8)


def test_graphs_give_the_bits_of_single_launches() -> None:
    runs = [Simulation(swinging(), graphs=graphs) for graphs in (True, False)]
    for simulation in runs:
        simulation.advance(12)
    assert_same_bits([runs[0].state_arrays()], [runs[1].state_arrays()])

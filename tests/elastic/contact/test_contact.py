"""Contact: collisions with a known solution, excluded pairs, and the candidate list."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.bits import assert_same_bits
from tests.scenes import RUBBER, angular_momentum, block, scene_of
from warp_mps.elastic.contact import law as contact_law
from warp_mps.elastic.contact import model as contacts
from warp_mps.elastic.contact.law import law_constants
from warp_mps.errors import RunError
from warp_mps.observers.base import Observer, View
from warp_mps.particles.particles import Particles
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, Material, Scene
from warp_mps.shapes import Box, Points

HEAVY = Material(4000.0, 4e7, 0.3)


def two_particles(
    dimension: int, *, away: float = 0.0105, offset: float = 0.0, velocity: float = 2.0, **scene: object
) -> Scene:
    """A light particle that flies into a heavy one, so far away along x and `offset` aside [m]; spacing 0.01 m."""
    aside = [offset] + [0.0] * (dimension - 2)
    light = Body(
        name="light",
        shape=Points(np.array([[0.0] * dimension])),
        material=RUBBER,
        spacing=0.01,
        velocity=[velocity] + [0.0] * (dimension - 1),
    )
    heavy = Body(name="heavy", shape=Points(np.array([[away, *aside]])), material=HEAVY, spacing=0.01)
    return scene_of(light, heavy, dimension=dimension, **{"time_step": 1e-6, **scene})


@pytest.mark.parametrize(
    ("dimension", "precision"),
    [
        (2, "float64"),
        pytest.param(3, "float64", marks=pytest.mark.long),
        pytest.param(2, "float32", marks=pytest.mark.long),
        pytest.param(3, "float32", marks=pytest.mark.long),
    ],
)
def test_two_particles_collide_head_on(dimension: int, precision: str) -> None:
    """Masses 1 and 4 that repel by the softer material's law, until it is relaxed again."""
    simulation = Simulation(two_particles(dimension), precision=precision)
    particles = simulation.particles
    light, heavy = particles.masses
    assert heavy == 4 * light
    start, momentum = simulation.energy.total, light * 2.0
    touched, largest = 0, 0.0
    for _ in range(3000):
        simulation.advance(1)
        total = (particles.masses[:, None] * simulation.velocities).sum(axis=0)
        np.testing.assert_allclose(total[0], momentum, rtol=1e-12 if precision == "float64" else 1e-4)
        touched += bool(simulation.contact_forces.any())
        largest = max(largest, simulation.energy.contact)
    expected = contact_time(dimension, light * heavy / (light + heavy))
    assert touched == pytest.approx(expected / 1e-6, abs=2)
    assert largest == pytest.approx(0.8 * start, rel=1e-3)
    assert simulation.energy.total == pytest.approx(start, rel=1e-5)
    # an elastic collision
    np.testing.assert_allclose(simulation.velocities[:, 0], [2.0 * (1 - 4) / 5, 2.0 * 2 / 5], rtol=1e-4)
    np.testing.assert_array_equal(simulation.velocities[:, 1:], 0.0)


def contact_time(dimension: int, mass: float) -> float:
    """Time for which two particles that meet at 2 m/s touch [s]: twice the integral of dr / v from touch to turn."""
    weight, scale = law_constants(dimension, 0.01, 0.01)

    def energy(r: float) -> float:
        s = r / 0.02
        return 1e7 * scale * max(weight * (1 - s) ** 4 * (1 + 4 * s) - 1.0, 0.0) ** 2

    def left(r: float) -> float:
        return 0.5 * mass * 2.0**2 - energy(r)

    touch = brentq(lambda r: weight * (1 - r / 0.02) ** 4 * (1 + 4 * r / 0.02) - 1.0, 1e-6, 0.02)
    turn = brentq(left, 1e-6, touch)
    # r = turn + (touch - turn) sin^2 takes the singularity away
    angle = (np.arange(2000) + 0.5) * 0.5 * np.pi / 2000
    r = turn + (touch - turn) * np.sin(angle) ** 2
    rate = (touch - turn) * np.sin(2 * angle) / np.sqrt([2.0 / mass * left(distance) for distance in r])
    return float(2.0 * rate.sum() * 0.5 * np.pi / 2000)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_glancing_collision_keeps_all_that_must_be_kept(dimension: int) -> None:
    simulation = Simulation(two_particles(dimension, offset=0.006))
    particles = simulation.particles

    def kept() -> np.ndarray:
        momentum = (particles.masses[:, None] * simulation.velocities).sum(axis=0)
        return np.concatenate((momentum, angular_momentum(simulation)))

    start, energy = kept(), simulation.energy.total
    simulation.advance(3000)
    assert abs(simulation.velocities[1, 1]) > 0.1
    assert not simulation.contact_forces.any()
    np.testing.assert_allclose(kept(), start, atol=1e-13 * np.abs(start).max())
    assert simulation.energy.total == pytest.approx(energy, rel=1e-4)


def test_a_restored_contact_is_there_at_once() -> None:
    """The candidate list is not part of a saved state; it is rebuilt from it."""
    scene = two_particles(2, away=0.02)
    simulation = Simulation(scene)
    simulation.advance(5550)
    assert simulation.energy.contact > 0.0
    restored = Simulation(scene)
    restored.restore(simulation.state_arrays())
    assert restored.energy == simulation.energy


@pytest.mark.parametrize(("between", "rebounds"), [("bodies", True), ("all", True), ("none", False)])
def test_bodies_touch_where_they_are_asked_to(between: str, rebounds: bool) -> None:
    simulation = Simulation(two_particles(2, contact=Contact(between=between)))
    simulation.advance(1500)
    assert (simulation.velocities[0, 0] < 0.0) == rebounds


def test_stiffness_is_relative_to_the_materials() -> None:
    """Four times as stiff: contact of a gentle touch lasts half as long."""
    touched = []
    for stiffness in (0.5, 2.0):
        scene = two_particles(2, away=0.0092, velocity=0.1, contact=Contact(stiffness=stiffness))
        simulation = Simulation(scene)
        steps = [simulation.advance(1) or bool(simulation.contact_forces.any()) for _ in range(3000)]
        touched.append(sum(steps))
    assert touched[1] > 100
    assert touched[0] == pytest.approx(2 * touched[1], rel=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
def test_neighbours_of_one_body_never_repel(dimension: int) -> None:
    """A body squeezed by a third, self-contact allowed."""
    box = block(dimension, (5, 4, 3))
    shape = Points(scene_positions(box, dimension))
    body = Body(name="a", shape=Points(shape.positions, -1500.0 * shape.positions), material=RUBBER, spacing=0.01)
    simulation = Simulation(scene_of(body, dimension=dimension, contact=Contact(between="all")))
    nearest = 1.0
    for _ in range(20):
        simulation.advance(1)
        nearest = min(nearest, closest(simulation.positions, simulation.positions))
        assert not simulation.contact_forces.any()
    assert nearest < 0.8 * 0.01


def scene_positions(body: Body, dimension: int) -> np.ndarray:
    """Positions of the particles of a body."""
    from warp_mps.shapes import fill

    return fill(body.shape, body.spacing, dimension)


def closest(a: np.ndarray, b: np.ndarray) -> float:
    """The least distance that is not 0 between points of two sets [m]."""
    distances = np.linalg.norm(a[:, None] - b[None], axis=-1)
    return float(distances[distances > 0.0].min())


def closing_hook(between: str) -> Simulation:
    """A C of 12 x 7 particles, 2 thick, whose arms fly towards each other."""
    x, y = np.meshgrid(np.arange(12.0), np.arange(7.0), indexing="ij")
    solid = (x < 2) | (y < 2) | (y > 4)
    cells = np.column_stack((x[solid], y[solid]))
    speed = -15.0 * np.sign(cells[:, 1] - 3.0) * (cells[:, 0] / 11.0) ** 2
    shape = Points(0.01 * cells, np.column_stack((np.zeros(len(cells)), speed)))
    hook = Body(name="hook", shape=shape, material=Material(1000.0, 1e6, 0.3), spacing=0.01)
    return Simulation(scene_of(hook, contact=Contact(between=between)))


def gap_of(simulation: Simulation) -> float:
    """Height between the tips of the hook's arms, which starts at 4 spacings [m]."""
    tip = simulation.particles.positions[:, 0] > 0.105
    upper = tip & (simulation.particles.positions[:, 1] > 0.035)
    return float(simulation.positions[upper, 1].min() - simulation.positions[tip & ~upper, 1].max())


@pytest.mark.parametrize("between", ["all", "bodies"])
def test_a_hook_closes_on_itself(between: str) -> None:
    simulation = closing_hook(between)
    energy, gaps, forces = simulation.energy.total, [gap_of(simulation)], []
    assert gaps[0] == pytest.approx(0.04)
    while simulation.time < 0.012:
        simulation.advance(10)
        gaps.append(gap_of(simulation))
        forces.append(np.abs(simulation.contact_forces).max())
    assert simulation.energy.total == pytest.approx(energy, rel=5e-3)
    if between == "bodies":
        assert min(gaps) < -0.01
        assert max(forces) == 0.0
    else:
        assert 0.0 < min(gaps) < 0.01
        assert gaps[-1] > 0.01
        assert max(forces) > 0.0
        np.testing.assert_allclose(simulation.contact_forces.sum(axis=0), 0.0, atol=1e-12 * max(forces))


def colliding_blocks(dimension: int, **scene: object) -> Scene:
    """A spinning block that hits another one and slides along it."""
    rest = [0.0] * (dimension - 2)
    spin = 60.0 if dimension == 2 else (20.0, 30.0, 60.0)
    left = block(dimension, name="left", velocity=[8.0, 3.0, *rest], angular_velocity=spin)
    right = block(dimension, name="right", shape=Box((0.03, 0.06, 0.04)[:dimension], [0.05, 0.0, *rest]))
    return scene_of(left, right, dimension=dimension, **scene)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_list_renewed_when_needed_gives_the_same_bits_as_one_renewed_at_every_step(
    dimension: int, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    replayed = Simulation(colliding_blocks(dimension), precision=precision)
    # without a margin every movement makes the list stale
    monkeypatch.setattr(contacts, "SKIN", 0.0)
    # and without boxes every particle looks around
    monkeypatch.setattr(contacts, "MOST_BOXES", 0)
    eager = Simulation(colliding_blocks(dimension), precision=precision, graphs=False)
    touched = False
    for _ in range(8):
        for simulation in (replayed, eager):
            simulation.advance(50)
        touched |= replayed.contact_forces.any()
        assert_same_bits([replayed.state_arrays()], [eager.state_arrays()])
    assert touched
    assert np.abs(replayed.displacements).max() > 0.01


@pytest.mark.parametrize("dimension", [2, 3])
def test_fine_particles_on_a_coarse_body(dimension: int) -> None:
    """A coarse particle meets many of a body five times finer, and has room for them."""
    rest = [0.0] * (dimension - 2)
    fine = Body(
        name="fine",
        shape=Box((0.02, 0.008, 0.02)[:dimension], [0.0, 0.0105, *rest]),
        material=RUBBER,
        spacing=0.002,
        velocity=[0.0, -2.0, *rest],
    )
    coarse = block(dimension, name="coarse", shape=Box((0.04, 0.02, 0.04)[:dimension], [0.0, -0.0105, *rest]))
    simulation = Simulation(scene_of(fine, coarse, dimension=dimension, duration=0.02))
    start = simulation.energy.total
    momentum = mean_velocity(simulation, simulation.particles)
    touched = False
    while simulation.time < 0.008:
        simulation.advance(50)
        touched |= bool(simulation.contact_forces.any())
    assert touched
    assert simulation.solid.contacts.overflowed() is None
    assert simulation.energy.total == pytest.approx(start, rel=1e-3)
    np.testing.assert_allclose(mean_velocity(simulation, simulation.particles), momentum, atol=1e-13)


def mean_velocity(simulation: Simulation, particles: Particles) -> np.ndarray:
    """Velocity of the centre of mass [m/s]."""
    return np.average(simulation.velocities, axis=0, weights=particles.masses)


def test_more_candidates_than_the_list_holds_end_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contact_law, "FILLED", 0.0)
    monkeypatch.setattr(contact_law, "SPARE", 3)
    simulation = Simulation(colliding_blocks(2, duration=0.05))
    first = simulation.state_arrays()
    witness = Witness(simulation)
    with pytest.raises(RunError, match="meets more particles of other bodies than a contact can hold"):
        simulation.run([witness])
    assert simulation.solid.contacts.overflowed() is not None
    # nothing was shown of the state that is wrong
    assert witness.steps == list(range(0, simulation.step, witness.every))
    assert len(witness.steps) > 1
    assert witness.overflows == [None] * len(witness.steps)
    simulation.restore(first)
    assert simulation.solid.contacts.overflowed() is None


class Witness(Observer):
    """Notes the steps that it is shown, and whether the contact of the simulation has overflowed."""

    every = 10

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self.steps: list[int] = []
        self.overflows: list[int | None] = []

    def observe(self, view: View) -> None:
        """Note the moment."""
        self.steps.append(view.step)
        self.overflows.append(self._simulation.solid.contacts.overflowed())

    def close(self) -> None:
        """Nothing is left open."""

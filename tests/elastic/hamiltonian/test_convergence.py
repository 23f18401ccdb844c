"""Convergence of the Hamiltonian model's eigenfrequencies to those of 2-D elasticity, and its stable time step.

References are eigenfrequencies of finite elements, converged to the digits given, for the beam of the paper's section
3.3 (0.16 x 0.02 m, E 10 MPa, nu 0.3, plane stress) with density 1000 kg/m^3, and for a bar of 0.5 x 0.05 x 0.05 m.
Those of the free beam are of elements of the fourth degree, for its errors fall to thousandths of a per cent. The
linearised model is solved; tests/elastic/test_hamiltonian_linear.py holds runs against it.
"""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.scenes import HAMILTONIAN, LENGTH, RUBBER, bar, beam, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene
from warp_mps.shapes import Box

FREE = (
    478.98303,
    1216.54168,
    1962.34299,
    2167.21819,
)  # rad/s: three bending modes, and before the last the first axial one
ROLLERS = (217.1, 813.2)  # rad/s: vertical rollers on the two whole end sections
BAR = 0.5033  # s: first bending period
# errors in percent at 4, 8 and 16 particles through the thickness
KNOWN = {4: (0.309, 0.936, -0.075, 1.533), 8: (-0.146, -0.067, -0.022, -0.003), 16: (-0.067, -0.065, -0.006, -0.069)}


@functools.cache
def free_modes(
    layers: int, radius: float = 1.5, nu: float = 0.3, plane: str = "stress", control: float = 0.5
) -> np.ndarray:
    """The free beam's first four eigenfrequencies [rad/s]."""
    scene = beam(layers, plane=plane, elasticity=Elasticity(effective_radius=radius, control=control))
    scene = replace(scene, bodies=(replace(scene.bodies[0], material=replace(RUBBER, poissons_ratio=nu)),))
    found, _ = linear_hamiltonian(scene, fill_scene(scene)).modes(4, rigid=3)
    return found


@pytest.mark.parametrize(("layers", "limit"), [(8, 0.01), (16, 0.003)])
def test_free_beam(layers: int, limit: float) -> None:
    assert free_modes(layers) == pytest.approx(FREE, rel=limit)


@pytest.mark.parametrize("layers", KNOWN)
def test_errors_of_the_free_beam(layers: int) -> None:
    errors = 100 * (free_modes(layers) / FREE - 1.0)
    assert errors == pytest.approx(KNOWN[layers], abs=0.001)


def orders(layers: tuple[int, ...], *, radius: float = 1.5, control: float = 0.5) -> np.ndarray:
    """Observed orders between each resolution and the next, shape [resolutions - 1, 4]."""
    errors = np.array([free_modes(n, radius, control=control) / FREE - 1.0 for n in layers])
    found = np.log2(np.abs(errors[:-1] / errors[1:]))
    print(f"r_e = {radius} l0, control {control}, {layers} particles")
    print(f"errors in percent:\n{np.round(100 * errors, 4)}\norders:\n{np.round(found, 2)}")
    return found


@pytest.mark.long
@pytest.mark.parametrize("control", [0.65, 0.7])
def test_with_more_control_the_order_is_two_from_8_particles_on(control: float) -> None:
    """All four modes; and the errors are below 1 % at 8 particles and 0.3 % at 16 even so."""
    found = orders((8, 16, 32), control=control)
    assert (found >= 1.7).all()
    for layers, limit in ((8, 0.01), (16, 0.003)):
        assert free_modes(layers, control=control) == pytest.approx(FREE, rel=limit)


@pytest.mark.parametrize(("radius", "least"), [(1.5, 1.3), pytest.param(2.1, 1.7, marks=pytest.mark.long)])
def test_the_order_of_the_default(radius: float, least: float) -> None:
    """Its bending errors change their sign below 16 particles, where two parts of them cancel.

    They are smaller there than with more control, but approach their order from below.
    """
    assert (orders((16, 32), radius=radius) >= least).all()


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "least"), [(1.5, 1.7), (2.1, 1.85)])
def test_the_order_of_the_default_tends_to_two(radius: float, least: float) -> None:
    found = orders((16, 32, 64), radius=radius)
    assert (found[1] >= least).all()
    assert (np.abs(found[1] - 2.0) < np.abs(found[0] - 2.0)).all()


@pytest.mark.slow
def test_the_order_with_more_control_stays_two() -> None:
    assert (np.abs(orders((32, 64), control=0.7) - 2.0) < 0.4).all()


@pytest.mark.parametrize("mode", [0, 1])
def test_beam_on_rollers(mode: int) -> None:
    """A column of particles lies on each of them."""
    scene = beam(16, nodes=True, elasticity=HAMILTONIAN)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 2), bool)
    held[np.isin(particles.positions[:, 0].round(9), (0.0, LENGTH)), 1] = True
    found, _ = linear_hamiltonian(scene, particles, held).modes(2, rigid=1)
    assert found[mode] == pytest.approx(ROLLERS[mode], rel=3e-3)


def test_bar_in_space() -> None:
    scene = bar(6, elasticity=HAMILTONIAN)
    found, _ = linear_hamiltonian(scene, fill_scene(scene)).modes(1, rigid=6)
    assert 2 * np.pi / found[0] == pytest.approx(BAR, rel=0.01)


@pytest.mark.parametrize(("layers", "limit"), [(3, 0.012), (4, 0.007), (8, 0.005)])
def test_a_nearly_incompressible_beam_does_not_lock(layers: int, limit: float) -> None:
    coarse, fine = (free_modes(layers, nu=0.49, plane="strain") for layers in (layers, 32))
    assert coarse == pytest.approx(fine, rel=limit)


SIZES = {2: ((12, 12), (24, 2), (2, 2)), 3: ((6, 6, 6), (6, 6, 2), (2, 2, 2))}
NU = (-0.5, 0.0, 0.3, 0.45, 0.49)


def body_of(cells: tuple[int, ...], nu: float, plane: str, elasticity: Elasticity, **scene: object) -> Scene:
    """A free body of so many particles along each axis."""
    body = Body(name="body", shape=Box([0.01 * n for n in cells]), material=Material(1000.0, 1e6, nu), spacing=0.01)
    return scene_of(body, dimension=len(cells), plane=plane, elasticity=elasticity, **scene)


def stable_step(scene: Scene) -> float:
    """The largest stable step of velocity Verlet, 2 / omega of the fastest mode [s]."""
    return 2.0 / linear_hamiltonian(scene, fill_scene(scene)).highest_frequency()


@pytest.mark.parametrize("control", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("radius", [1.5, 2.1, pytest.param(3.1, marks=pytest.mark.long)])
@pytest.mark.parametrize(("dimension", "plane"), [(2, "stress"), (2, "strain"), (3, "strain")])
def test_the_limit_of_the_step_is_below_what_is_stable(
    dimension: int, plane: str, radius: float, control: float
) -> None:
    for cells in SIZES[dimension]:
        for nu in NU:
            scene = body_of(cells, nu, plane, Elasticity(effective_radius=radius, control=control))
            clock = Clock(scene)
            assert clock.dt_limit < stable_step(scene), f"{cells}, nu {nu}"
            assert clock.dt < clock.dt_limit


@pytest.mark.parametrize(("dimension", "plane"), [(2, "stress"), (2, "strain"), (3, "strain")])
def test_the_limit_is_not_far_below(dimension: int, plane: str) -> None:
    worst = max(
        Clock(scene).dt_limit / stable_step(scene)
        for cells in SIZES[dimension]
        for nu in NU
        for scene in [body_of(cells, nu, plane, HAMILTONIAN)]
    )
    assert worst > 0.85


@pytest.mark.long
@pytest.mark.parametrize("control", [0.0, 0.1, 1.2, 10.0])
@pytest.mark.parametrize("radius", [1.2, 1.45, 1.5])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_limit_of_the_step_for_rare_choices(dimension: int, radius: float, control: float) -> None:
    """Few neighbours, and hardly any or much control; blocks of a few particles are the fastest."""
    for cells in ((2, 2, 2), (3, 3, 3), (24, 2, 2), (8, 8, 2), (6, 6, 6)):
        scene = body_of(cells[:dimension], 0.0, "strain", Elasticity(effective_radius=radius, control=control))
        assert Clock(scene).dt_limit < stable_step(scene), f"{cells}"


@pytest.mark.parametrize("dimension", [2, 3])
def test_runs_on_either_side_of_the_limit(dimension: int) -> None:
    """At the stability limit noise stays bounded; 2 % above it, it grows without bound."""
    cells, growth = (10, 6, 4)[:dimension], []
    linear = body_of(cells, 0.3, "strain", HAMILTONIAN)
    limit, stable = Clock(linear).dt_limit, stable_step(linear)
    # few enough steps that what grows by a half in each stays small
    for step, steps in ((limit, 300), (0.98 * stable, 300), (1.02 * stable, 40)):
        simulation = Simulation(body_of(cells, 0.3, "strain", HAMILTONIAN, time_step=step))
        simulation.solid.state.v.assign(1e-9 * random(simulation.particles.count, dimension))
        start = simulation.energy.total
        simulation.advance(steps)
        growth.append(simulation.energy.total / start)
    assert growth[0] < 3.0
    assert growth[1] < 10.0
    assert growth[2] > 1e4

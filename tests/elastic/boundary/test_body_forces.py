"""Body forces on elastic bodies: a harmonic trap has an exact motion, and its work an exact potential."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.bits import assert_same_bits, states
from tests.scenes import HAMILTONIAN, SPRINGS, block, ends, scene_of
from warp_mps.errors import InputError, RunError
from warp_mps.run.simulation import Simulation
from warp_mps.scene import BodyForce, Contact, Scene, Support
from warp_mps.shapes import Box

# of the traps [rad/s], and where they pull to [m]
OMEGA, CENTER = 40.0, 0.02
SQUARE = OMEGA**2


def trap(x: np.ndarray, t: float) -> np.ndarray:
    """A harmonic trap: -omega^2 (x - c), c on the first axis."""
    center = np.zeros(x.shape[1])
    center[0] = CENTER
    return -SQUARE * (x - center)


@wp.func
def warp_trap(x: Any, t: Any):
    """The same as a Warp function of any precision and dimension."""
    center = type(x)()
    center[0] = type(t)(CENTER)
    return type(t)(-SQUARE) * (x - center)


def wind(x: np.ndarray, t: float) -> np.ndarray:
    """A force that is uniform in space and grows with time, along the first axis: 50 t m/s^3."""
    return np.broadcast_to([50.0 * t] + [0.0] * (x.shape[1] - 1), x.shape)


def trapped(function: Any = trap, *, dimension: int = 2, **fields: Any) -> Scene:
    """A block in a trap, at rest beside its centre."""
    force = BodyForce(name="trap", acceleration=function)
    fields = {"elasticity": HAMILTONIAN, "duration": 0.2, **fields}
    return scene_of(block(dimension), dimension=dimension, body_forces=(force,), **fields)


IMPLICIT: dict[str, Any] = {
    "integrator": "implicit",
    "theta": 0.5,
    "time_step": 1e-3,
    "contact": Contact(between="none"),
}


@pytest.mark.parametrize("function", [trap, warp_trap])
@pytest.mark.parametrize(
    ("dimension", "fields", "accuracy"),
    [(2, {}, 1e-5), (3, {}, 1e-5), (2, {"elasticity": SPRINGS}, 1e-5), (2, IMPLICIT, 1e-3)],
)
def test_the_centre_of_a_body_oscillates_as_the_trap_says(
    function: Any, dimension: int, fields: dict[str, Any], accuracy: float
) -> None:
    """A trap pulls at the mass centre as at one particle, however the body deforms: x = c - c cos(omega t)."""
    simulation = Simulation(trapped(function, dimension=dimension, **fields))
    for part in (0.3, 0.5, 0.8, 1.2):
        simulation.step_to(part * 2.0 * np.pi / OMEGA)
        center = np.average(simulation.positions, axis=0, weights=simulation.particles.masses)
        expected = CENTER * (1.0 - np.cos(OMEGA * simulation.time))
        np.testing.assert_allclose(center[0], expected, atol=accuracy * CENTER)
        np.testing.assert_allclose(center[1:], 0.0, atol=1e-12)


@pytest.mark.parametrize("function", [trap, warp_trap])
@pytest.mark.parametrize("fields", [{}, {"damping": 3.0}, IMPLICIT])
def test_the_work_is_the_fall_of_the_potential_and_closes_the_balance(function: Any, fields: dict[str, Any]) -> None:
    simulation = Simulation(trapped(function, **fields))
    masses = simulation.particles.masses

    def potential() -> float:
        arms = simulation.positions - [CENTER, 0.0]
        return 0.5 * OMEGA**2 * float(masses @ np.sum(arms**2, axis=1))

    start, balance = potential(), simulation.energy.balance
    simulation.step_to(0.3 * 2.0 * np.pi / OMEGA)
    energy = simulation.energy
    assert energy.work > 0.2 * start
    assert energy.work == pytest.approx(start - potential(), rel=1e-4 if "theta" not in fields else 2e-3)
    assert energy.balance - balance == pytest.approx(0.0, abs=1e-4 * energy.work)


@pytest.mark.parametrize("fields", [{}, IMPLICIT])
def test_a_force_that_depends_on_time(fields: dict[str, Any]) -> None:
    """Under 50 t the velocity is 25 t^2: the rules of integration are exact for a force that is linear in time."""
    simulation = Simulation(trapped(wind, **fields))
    simulation.step_to(0.05)
    np.testing.assert_allclose(simulation.velocities[:, 0].mean(), 25.0 * simulation.time**2, rtol=1e-6)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("fields", [{}, IMPLICIT])
def test_a_python_function_is_the_same_as_a_warp_function(precision: str, fields: dict[str, Any]) -> None:
    of_python, of_warp = (Simulation(trapped(f, **fields), precision=precision) for f in (trap, warp_trap))
    for simulation in (of_python, of_warp):
        simulation.step_to(0.03)
    accuracy = 1e-10 if precision == "float64" else 1e-4
    np.testing.assert_allclose(of_python.displacements, of_warp.displacements, atol=accuracy * CENTER)
    assert of_python.energy.work == pytest.approx(of_warp.energy.work, rel=accuracy)


@pytest.mark.parametrize("function", [trap, warp_trap])
def test_graphs_kernels_pieces_and_restarts_give_the_same_bits(function: Any) -> None:
    scene = trapped(function)
    expected = states(Simulation(scene), 1, 33, 20)
    assert expected[1]["body_force"].any()
    assert_same_bits(states(Simulation(scene, graphs=False), 1, 33, 20), expected)
    pieces = Simulation(scene)
    for steps in (1, 20, 13):
        pieces.advance(steps)
    restored = Simulation(scene)
    restored.restore(pieces.state_arrays())
    assert_same_bits(states(restored, 20), expected[2:])
    if function is warp_trap:
        assert_same_bits(states(Simulation(scene, threads=2), 1, 33, 20), expected)


def test_an_implicit_run_is_restored_to_the_same_bits() -> None:
    scene = trapped(**IMPLICIT)
    whole, restored = Simulation(scene), Simulation(scene)
    saved, expected = states(whole, 5, 5)[-2:]
    restored.restore(saved)
    assert_same_bits(states(restored, 5), [expected])


def test_forces_act_on_the_bodies_that_they_name_and_walls_stay() -> None:
    bodies = (block(2), block(2, name="other", shape=Box((0.04, 0.03), (0.2, 0.0))))
    force = BodyForce(name="wind", acceleration=wind, acts_on=("other",))
    simulation = Simulation(scene_of(*bodies, body_forces=(force,), duration=0.1))
    simulation.step_to(0.01)
    first, second = (slice(*rows) for rows in simulation.particles.ranges)
    assert not simulation.velocities[first].any()
    assert (simulation.velocities[second, 0] > 0.0).all()


def test_what_a_trap_does_is_no_internal_force_and_a_support_takes_it_up() -> None:
    """At rest under it, a held body is pushed against its support by the total force."""
    clamp = Support(name="clamp", region=Box((1.0, 1.0)))
    force = BodyForce(name="trap", acceleration=trap)
    simulation = Simulation(scene_of(block(2), supports=(clamp,), body_forces=(force,), duration=0.1))
    simulation.advance(10)
    expected = simulation.particles.masses[:, None] * trap(simulation.positions, 0.0)
    np.testing.assert_allclose(simulation.reactions, -expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(simulation.internal_forces, 0.0, atol=1e-12)
    assert simulation.energy.work == 0.0


@pytest.mark.parametrize(
    ("function", "match"),
    [
        (lambda x, t: x[:, 0], r"body force 'trap' acceleration: gave an array of shape \(12,\), must be \(12, 2\)"),
        (lambda x, t: x * np.nan, "body force 'trap' acceleration: gave .*nan.* must be finite"),
        (lambda x: x, "body force 'trap' acceleration: raised TypeError: .*takes 1 positional argument"),
    ],
)
def test_functions_that_give_no_accelerations_are_refused(function: Any, match: str) -> None:
    with pytest.raises(InputError, match=match):
        Simulation(trapped(function))


@wp.func
def scalar(x: wp.vec2d, t: wp.float64) -> wp.float64:
    """No acceleration."""
    return wp.length(x)


def test_a_warp_function_of_other_types_is_refused() -> None:
    with pytest.raises(InputError, match=r"'trap' acceleration: cannot be compiled as a function of wp\.vec2d and"):
        Simulation(trapped(scalar))


def test_a_function_that_fails_later_ends_the_run() -> None:
    def fails(x: np.ndarray, t: float) -> np.ndarray:
        if t > 1e-3:
            raise ZeroDivisionError("late")
        return 0.0 * x

    simulation = Simulation(trapped(fails))
    with pytest.raises(RunError, match=r"body force 'trap': at 0.001.* s its function raised ZeroDivisionError: late"):
        simulation.run()


def test_threads_take_warp_functions_only() -> None:
    with pytest.raises(InputError, match="threads: is 2; body forces given as Python functions take one"):
        Simulation(trapped(), threads=2)


def test_statics_are_refused() -> None:
    support = Support(name="clamp", region=ends()[0])
    with pytest.raises(InputError, match="body force 'trap' acceleration: is a function of place and time; a static"):
        replace(trapped(contact=Contact(between="none")), analysis="static", supports=(support,))


def test_names_must_be_those_of_bodies() -> None:
    force = BodyForce(name="trap", acceleration=trap, acts_on=("nothing",))
    with pytest.raises(InputError, match=r"body force 'trap' acts_on: is 'nothing', must name a body or fluid"):
        replace(trapped(), body_forces=(force,))

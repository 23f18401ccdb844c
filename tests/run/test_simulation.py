"""A run: the same bits whichever way its steps are launched, restarts, refusals, stepping by hand."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.bits import assert_same_bits, states
from tests.scenes import block, scene_of, short_run
from warp_mps.errors import InputError, RunError
from warp_mps.run.simulation import Simulation
from warp_mps.run.steps import BLOCK
from warp_mps.scene import Body, Contact, HarmonicMotion, Load, Scene, Support, TableMotion
from warp_mps.shapes import Box

KINDS = [(dimension, precision) for dimension in (2, 3) for precision in ("float64", "float32")]


def everything(dimension: int) -> Scene:
    """A block that falls, pushed and damped, on one that is shaken, while a third one is drawn aside."""
    rest = [0.0] * (dimension - 2)

    def body(name: str, *center: float, **fields: object) -> Body:
        shape = Box((0.05, 0.03, 0.03)[:dimension], [*center, *rest])
        return block(dimension, name=name, shape=shape, **fields)

    def strip(y: float) -> Box:
        return Box((1.0, 0.011, 1.0)[:dimension], [0.0, y, *rest])

    amplitude = [0.0, 1e-3, *rest]
    path = TableMotion(times=np.array([1e-3, 2e-3]), displacements=np.array([[0.0] * dimension, [2e-3, *rest, 0.0]]))
    return scene_of(
        body(
            "upper",
            0.004,
            0.0305,
            velocity=[1.0, -8.0, *rest],
            angular_velocity=20.0 if dimension == 2 else (5.0, 9.0, 20.0),
        ),
        body("lower", 0.0, 0.0),
        body("third", 0.06, 0.0),
        dimension=dimension,
        duration=0.01,
        supports=(
            Support(
                name="shaker",
                region=strip(-0.01),
                bodies=("lower",),
                motion=HarmonicMotion(amplitude=amplitude, frequency=300.0),
            ),
            Support(name="hand", region=strip(-0.01), bodies=("third",), motion=path, axes=(0,)),
        ),
        loads=(Load(name="push", region=strip(0.0405), force=[50.0, 0.0, *rest], frequency=100.0),),
        gravity=[0.0, -9.81, *rest],
        damping=5.0,
        contact=Contact(between="all"),
    )


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_graphs_kernels_and_threads_give_the_same_bits(dimension: int, precision: str) -> None:
    chunks = (1, BLOCK + 1, 2 * BLOCK, 60)
    scene = everything(dimension)
    replayed = Simulation(scene, precision=precision)
    expected = states(replayed, *chunks)
    # the blocks touch from step 8 to 61
    assert expected[1]["contact"].any()
    assert replayed.energy.dissipated > 0.0
    for options in ({"graphs": False}, {"threads": 2}, {"threads": 3}):
        assert_same_bits(states(Simulation(scene, precision=precision, **options), *chunks), expected)


def test_bits_do_not_depend_on_how_a_run_is_cut_into_pieces() -> None:
    whole, pieces = (Simulation(everything(2)) for _ in range(2))
    whole.advance(150)
    for steps in (0, 7, 40, 64, 39):
        pieces.advance(steps)
    assert_same_bits([whole.state_arrays()], [pieces.state_arrays()])


@pytest.mark.parametrize(("dimension", "precision"), KINDS)
def test_a_restored_run_continues_to_the_same_bits(dimension: int, precision: str) -> None:
    """Restored while the bodies touch, the shaker swings, the hand draws and the list of candidates is not fresh."""
    scene = everything(dimension)
    simulation = Simulation(scene, precision=precision)
    simulation.advance(50)
    assert simulation.contact_forces.any()
    saved = simulation.state_arrays()
    kept = {name: values.copy() for name, values in saved.items()}
    later = states(simulation, 45, 80)
    assert_same_bits([saved], [kept])
    expected = energy_at(scene, precision, 50)
    for options in ({}, {"graphs": False}, {"threads": 2}):
        restored = Simulation(scene, precision=precision, **options)
        restored.advance(3)
        restored.restore(saved)
        assert (restored.step, restored.time) == (50, 50 * simulation.dt)
        assert_same_bits([restored.state_arrays()], [saved])
        assert restored.energy == expected
        assert_same_bits(states(restored, 45, 80), later)


def energy_at(scene: Scene, precision: str, steps: int) -> object:
    """Energy of a run after some steps."""
    simulation = Simulation(scene, precision=precision)
    simulation.advance(steps)
    return simulation.energy


def interrupt_after_a_block(simulation: Simulation) -> None:
    """Send Ctrl-C to this process once a simulation, in another thread, has advanced by a block of steps."""
    first = simulation.step
    while simulation.step < first + BLOCK:
        time.sleep(0.001)
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("options", [{}, {"graphs": False}, {"threads": 2}, {"threads": 3}])
def test_an_interrupted_run_is_at_the_step_that_it_says_and_goes_on(options: dict) -> None:
    scene = everything(2)
    interrupted, clean = Simulation(scene, **options), Simulation(scene)
    interrupted.advance(1)
    saved = interrupted.state_arrays()
    threading.Thread(target=interrupt_after_a_block, args=(interrupted,), daemon=True).start()
    with pytest.raises(KeyboardInterrupt):
        interrupted.advance(10**9)
    assert interrupted.step > 1
    assert interrupted.step % BLOCK == 1
    expected = states(clean, interrupted.step, 40)
    assert_same_bits([interrupted.state_arrays(), *states(interrupted, 40)], expected)
    again = Simulation(scene)
    again.restore(saved)
    interrupted.restore(saved)
    assert_same_bits(states(interrupted, 64), states(again, 64))


@pytest.mark.parametrize("in_main", [True, False])
def test_a_run_goes_on_from_a_restored_state_after_a_failure_within_a_step(
    in_main: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    launch, fails = wp.capture_launch, []

    def failing_launch(graph: Any) -> None:
        if fails and (threading.current_thread() is threading.main_thread()) is in_main:
            raise fails.pop()
        launch(graph)

    monkeypatch.setattr(wp, "capture_launch", failing_launch)
    simulation, clean = Simulation(everything(2), threads=3), Simulation(everything(2))
    saved, *_ = states(simulation, 20)
    fails.append(MemoryError("full"))
    with pytest.raises(MemoryError, match="full"):
        simulation.advance(BLOCK)
    assert simulation.step == 20
    with pytest.raises(RuntimeError, match="the team of threads is closed"):
        simulation.advance(1)
    simulation.restore(saved)
    assert_same_bits(states(simulation, BLOCK, 8), states(clean, 20, BLOCK, 8)[1:])


def test_threads_end_with_the_simulation() -> None:
    before = set(threading.enumerate())
    simulations = [Simulation(scene_of(block(2)), threads=3) for _ in range(3)]
    simulations[0].advance(2)
    started = set(threading.enumerate()) - before
    assert len(started) == 6
    simulations.clear()
    gc.collect()
    for thread in started:
        thread.join(timeout=60.0)
    assert not any(thread.is_alive() for thread in started)


def test_views_are_of_the_present_moment() -> None:
    simulation = Simulation(scene_of(block(2, velocity=(1.0, 0.0)), duration=1.0))
    at_rest = simulation.positions
    np.testing.assert_array_equal(at_rest, simulation.particles.positions)
    assert simulation.positions is at_rest
    simulation.advance(10)
    assert simulation.step == 10
    assert simulation.time == pytest.approx(10 * simulation.dt, rel=1e-15)
    np.testing.assert_allclose(simulation.positions - at_rest, [[simulation.time, 0.0]] * 12, atol=1e-17)
    np.testing.assert_array_equal(simulation.positions, at_rest + simulation.displacements)


def test_pressure_is_positive_where_a_body_is_squeezed() -> None:
    press = Support(
        name="press",
        region=Box((0.011, 1.0), (0.015, 0.0)),
        motion=TableMotion(times=np.array([0.0, 1e-3]), displacements=np.array([[0.0, 0.0], [-2e-3, 0.0]])),
    )
    wall = Support(name="wall", region=Box((0.011, 1.0), (-0.015, 0.0)))
    simulation = Simulation(scene_of(block(2), supports=(press, wall)))
    simulation.advance(round(1e-3 / simulation.dt))
    assert (simulation.pressures > 0.0).all()
    x = simulation.particles.positions[:, 0]
    assert simulation.reactions[x > 0.01, 0].sum() < 0.0 < simulation.reactions[x < -0.01, 0].sum()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"device": "cuda:99"}, "device: 'cuda:99' is not available"),
        ({"device": "cuda:99", "threads": 2}, "device: 'cuda:99' is not available"),
        ({"threads": 0}, "threads: is 0, must be a whole number of 1 or more"),
        ({"precision": "float16"}, "precision: is 'float16', must be one of: float64, float32"),
    ],
)
def test_what_cannot_be_run_is_refused(options: dict, match: str) -> None:
    with pytest.raises(InputError, match=match):
        Simulation(scene_of(block(2)), **options)


def test_threads_are_refused_on_a_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    from warp_mps.core import device

    monkeypatch.setattr(device, "open_device", lambda _: SimpleNamespace(is_cpu=False))
    with pytest.raises(InputError, match="threads: is 2 on cuda:0; threads are for the CPU device"):
        Simulation(scene_of(block(2)), device="cuda:0", threads=2)


def test_compiling_is_announced_before_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    announce: Callable[[str], None] = said.append
    Simulation(scene_of(block(2)))
    Simulation(scene_of(block(2)), announce=announce)
    assert said == []
    # nothing is compiled, since the kernels are loaded already
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    Simulation(scene_of(block(2)), announce=announce)
    assert len(said) == 1
    assert "compiling kernels for cpu" in said[0]


def test_stepping_by_hand() -> None:
    simulation = short_run(100)
    simulation.step_to(2.5e-6)
    assert (simulation.step, simulation.time) == (3, pytest.approx(3e-6))
    simulation.step_to(3e-6)
    assert simulation.step == 3
    simulation.step_to(150e-6)
    assert simulation.step == 150
    for moment in (149e-6, float("nan")):
        with pytest.raises(InputError, match=r"time: is .* s, must be finite and not before 0.00015 s"):
            simulation.step_to(moment)


@pytest.mark.parametrize("name", ["v", "dissipated"])
def test_a_run_whose_end_is_not_finite_fails_without_observers(name: str) -> None:
    simulation = short_run(3)
    array = getattr(simulation.solid.state, name)
    array.assign(np.full_like(array.numpy(), np.nan))
    with pytest.raises(RunError, match=r"is not finite at 3e-06 s \(step 3\)$|is turned inside out"):
        simulation.run()


def test_what_is_read_cannot_be_written_to() -> None:
    simulation = short_run(10)
    for array in (simulation.positions, simulation.stresses, simulation.strains):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_device_arrays_of_a_body_are_those_of_its_state() -> None:
    simulation = short_run(10)
    arrays = simulation.device_arrays
    assert set(arrays) == {"solid.displacements", "solid.velocities", "solid.forces"}
    kept = arrays["solid.displacements"]
    simulation.advance(10)
    assert simulation.device_arrays["solid.displacements"] is kept
    np.testing.assert_array_equal(kept.numpy(), simulation.displacements)
    np.testing.assert_array_equal(arrays["solid.velocities"].numpy(), simulation.velocities)
    with pytest.raises(TypeError):
        arrays["solid.forces"] = kept  # type: ignore[index]

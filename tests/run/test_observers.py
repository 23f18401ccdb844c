"""Observers of a run: their calls, their failures, and runs that are the same with and without them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bits import assert_same_bits
from tests.scenes import block, scene_of, short_run
from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, View
from warp_mps.run.run import run_scene
from warp_mps.run.simulation import Simulation


class Recorder(Observer):
    """Notes when it was called, and fails at a step or when it is closed if it is told to."""

    def __init__(
        self,
        every: int,
        fails_at: int | None = None,
        error: type[BaseException] = RunError,
        at_close: BaseException | None = None,
    ) -> None:
        self.every, self._fails_at, self._error, self._at_close = every, fails_at, error, at_close
        self.steps: list[int] = []
        self.times: list[float] = []
        self.closed = 0

    def observe(self, view: View) -> None:
        """Note the moment."""
        assert self.closed == 0
        self.steps.append(view.step)
        self.times.append(view.time)
        if view.step == self._fails_at:
            raise self._error("enough")

    def close(self) -> None:
        """Count the calls."""
        self.closed += 1
        if self._at_close:
            raise self._at_close


def test_observers_are_called_at_the_start_on_their_grid_and_at_the_end() -> None:
    simulation = short_run(100)
    recorders = [Recorder(every) for every in (7, 30, 100, 1000)]
    simulation.run(recorders)
    assert [recorder.steps for recorder in recorders] == [
        [*range(0, 100, 7), 100],
        [0, 30, 60, 90, 100],
        [0, 100],
        [0, 100],
    ]
    assert recorders[1].times == pytest.approx([0.0, 30e-6, 60e-6, 90e-6, 100e-6])
    assert [recorder.closed for recorder in recorders] == [1] * 4
    assert simulation.step == simulation.total_steps == 100


def test_observers_do_not_change_a_run() -> None:
    alone, seen = short_run(100), short_run(100)
    alone.run()
    seen.run([Recorder(3), Recorder(11)])
    assert_same_bits([alone.state_arrays()], [seen.state_arrays()])


@pytest.mark.parametrize("error", [RunError, KeyboardInterrupt, ZeroDivisionError])
@pytest.mark.parametrize("step", [0, 40])
def test_observers_are_closed_after_a_failure(error: type[BaseException], step: int) -> None:
    recorders = [Recorder(20), Recorder(20, fails_at=step, error=error)]
    simulation = short_run(100)
    with pytest.raises(error, match="enough"):
        simulation.run(recorders)
    assert simulation.step == step
    assert [recorder.closed for recorder in recorders] == [1, 1]
    assert recorders[0].steps[-1] == step


@pytest.mark.parametrize(
    ("fails_at", "expected", "match"),
    [(20, RunError, "enough"), (None, OSError, "no space"), (100, RunError, "enough")],
)
def test_all_observers_are_closed_and_the_first_error_is_raised(
    fails_at: int | None, expected: type[BaseException], match: str
) -> None:
    recorders = [
        Recorder(20),
        Recorder(20, at_close=OSError("no space")),
        Recorder(20, fails_at=fails_at),
        Recorder(20, at_close=KeyboardInterrupt("now")),
        Recorder(20),
    ]
    with pytest.raises(expected, match=match):
        short_run(100).run(recorders)
    assert [recorder.closed for recorder in recorders] == [1] * 5


def test_a_restored_run_goes_on_along_the_same_grid() -> None:
    first = short_run(100)
    first.advance(40)
    second = short_run(100)
    second.restore(first.state_arrays())
    recorder = Recorder(30)
    second.run([recorder])
    assert recorder.steps == [60, 90, 100]


@pytest.mark.parametrize(
    ("interval", "expected"),
    [
        (25e-6, [0, 25, 50, 75, 100]),
        (7.5e-6, [0, 8, 15, 23, 30, 38, 45, 53, 60, 68, 75, 83, 90, 98, 100]),
        (0.3e-6, [*range(101)]),
        (1.0, [0, 100]),
    ],
)
def test_observers_are_called_by_simulated_time(interval: float, expected: list[int]) -> None:
    recorder = Recorder(1)
    recorder.interval = interval
    short_run(100).run([recorder])
    assert recorder.steps == expected


@pytest.mark.parametrize(("every", "interval"), [(0, None), (1.5, None), (1, 0.0), (1, float("nan")), (1, "a")])
def test_triggers_that_never_come_are_refused(every: int, interval: float | None) -> None:
    recorder = Recorder(every)
    recorder.interval = interval
    with pytest.raises(InputError, match=r"observer (every|interval): is (0|nan|1.5|'a')"):
        short_run(10).run([recorder])
    assert recorder.closed == 1


@pytest.mark.parametrize(
    ("observers", "message"),
    [
        (Observer(), "observers: is .*, must be a list or tuple"),
        (None, "observers: is None, must be a list or tuple"),
        ([print], r"observers\[0\]: is .*, must be an object of a subclass"),
    ],
)
def test_observers_of_another_kind_are_refused(observers: object, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        run_scene(scene_of(block(2)), tmp_path, observers=observers)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("steps", [-1, 1.5, "3", None])
def test_steps_that_are_no_number_of_steps_are_refused(steps: object) -> None:
    with pytest.raises(InputError, match=r"steps: is .*, must be a whole number of at least 0"):
        Simulation(scene_of(block(2))).advance(steps)  # type: ignore[arg-type]


def test_a_simulation_of_what_is_no_scene_is_refused(tmp_path: Path) -> None:
    for run in (Simulation, lambda name: run_scene(name, tmp_path)):
        with pytest.raises(InputError, match="scene: is 'ring_collision', must be a Scene"):
            run("ring_collision")


def test_a_simulation_too_large_for_the_memory_is_refused() -> None:
    with pytest.raises(InputError, match="needs about"):
        Simulation(scene_of(block(2, spacing=1e-9)))


@pytest.mark.parametrize("method", ["advance", "restore"])
def test_an_observer_cannot_drive_the_run(method: str) -> None:
    class Driver(Observer):
        def observe(self, view: View) -> None:
            argument = 1 if method == "advance" else view.state_arrays()
            getattr(view, method)(argument)

    with pytest.raises(RuntimeError, match="an observer may look at a run, but not advance or restore it"):
        short_run(10).run([Driver()])


def test_what_an_observer_sees_cannot_be_written_to() -> None:
    simulation = short_run(10)
    for array in (simulation.particles.positions, simulation.particles.masses, simulation.positions):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0
    before = simulation.positions.copy()
    for array in simulation.state_arrays().values():
        array[...] = 0
    simulation.advance(1)
    assert abs(simulation.positions - before).max() < 1e-3

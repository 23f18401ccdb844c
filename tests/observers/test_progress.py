"""Progress, on a terminal and elsewhere."""

from __future__ import annotations

import io

import pytest

from tests.observers.views import FakeView, blocks, view_of
from warp_mps.observers.progress import Progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        """It does."""
        return True


class Clock:
    """A clock that is set by hand."""

    now = 0.0

    def __call__(self) -> float:
        """The time that was set [s]."""
        return self.now


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks(), total_steps=1000)


def run(progress: Progress, view: FakeView, clock: Clock, *, seconds: float) -> None:
    for step in range(1001):
        view.step, view.time, clock.now = step, step * 1e-3, seconds * step / 1000
        progress.observe(view)
    progress.close()


def test_a_short_run_prints_a_line_every_tenth(view: FakeView) -> None:
    stream, clock = io.StringIO(), Clock()
    run(Progress(every=1, stream=stream, clock=clock), view, clock, seconds=2.0)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 11
    assert lines[0] == "  0 %  0 s, time left unknown"
    assert lines[5] == " 50 %  0.5 s, 500 steps/s, 0:00:01 left"
    assert lines[-1] == "100 %  1 s, 500 steps/s, done"


def test_the_steps_within_those_of_the_run_are_counted() -> None:
    view = view_of(blocks(), total_steps=1000, substeps=8)
    stream, clock = io.StringIO(), Clock()
    run(Progress(every=1, stream=stream, clock=clock), view, clock, seconds=2.0)
    assert stream.getvalue().splitlines()[5] == " 50 %  0.5 s, 4000 steps/s, 0:00:01 left"


def test_a_long_run_prints_a_line_every_five_seconds(view: FakeView) -> None:
    stream, clock = io.StringIO(), Clock()
    run(Progress(every=1, stream=stream, clock=clock), view, clock, seconds=500.0)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 101
    assert lines[1] == "  1 %  0.01 s, 2 steps/s, 0:08:15 left"


def test_the_speed_of_a_resumed_run_counts_its_own_steps(view: FakeView) -> None:
    stream, clock = io.StringIO(), Clock()
    progress = Progress(every=1, stream=stream, clock=clock)
    view.step = 500
    progress.observe(view)
    view.step, clock.now = 750, 10.0
    progress.observe(view)
    assert stream.getvalue().splitlines()[1] == " 75 %  0 s, 25 steps/s, 0:00:10 left"


def test_a_terminal_gets_a_bar(view: FakeView, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "120")
    stream, clock = Terminal(), Clock()
    run(Progress(every=1, stream=stream, clock=clock), view, clock, seconds=2.0)
    assert "100%" in stream.getvalue()
    assert "500 steps/s" in stream.getvalue()


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()])
def test_quiet_shows_nothing(view: FakeView, stream: io.StringIO) -> None:
    clock = Clock()
    run(Progress(every=1, stream=stream, quiet=True, clock=clock), view, clock, seconds=100.0)
    assert stream.getvalue() == ""


def test_it_goes_to_standard_error(view: FakeView, capsys: pytest.CaptureFixture[str]) -> None:
    Progress(every=1).observe(view)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "0 %" in captured.err

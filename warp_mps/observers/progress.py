"""Progress on standard error: a bar on a terminal, elsewhere lines at intervals."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO, cast

from warp_mps.core.streams import PatientStream
from warp_mps.observers.base import Observer, View

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

LINE_SECONDS = 5.0
LINE_FRACTION = 0.1


class Progress(Observer):
    """Shows how far a run is, the simulated time, the steps a second and the time left.

    On a terminal it is a bar; elsewhere a line at the start, at the end, and whenever 5 s have passed or another
    tenth of the run is done.

    Args:
        every: Steps between two looks.
        quiet: Shows nothing.
        stream: Where to write; None is standard error.
        clock: Gives the wall time [s].
    """

    def __init__(
        self,
        *,
        every: int,
        quiet: bool = False,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.every = every
        self._quiet = quiet
        self._stream = PatientStream(sys.stderr if stream is None else stream)
        self._clock = clock
        self._first: tuple[int, int, float] | None = None
        self._line = (0.0, 0.0)
        self._bar: Bar | None = None

    def observe(self, view: View) -> None:
        """Show the state of the run."""
        if self._quiet:
            return
        now = self._clock()
        first = self._first is None
        if self._first is None:
            self._first = (view.step, view.steps_done, now)
        rate, speed = self._rates(view, now)
        if self._stream.isatty():
            self._show_bar(view, rate, speed)
        elif first or view.step >= view.total_steps or self._line_is_due(_fraction(view), now):
            self._line = (_fraction(view), now)
            self._stream.write(f"{_line(view, rate, speed)}\n")
            self._stream.flush()

    def close(self) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _rates(self, view: View, now: float) -> tuple[float, float]:
        """Steps of the run and time steps a second since the first look, 0 while unknown."""
        assert self._first is not None
        step, done, start = self._first
        seconds = now - start
        return ((view.step - step) / seconds, (view.steps_done - done) / seconds) if seconds > 0.0 else (0.0, 0.0)

    def _line_is_due(self, fraction: float, now: float) -> bool:
        last_fraction, last_time = self._line
        return now - last_time >= LINE_SECONDS or fraction - last_fraction >= LINE_FRACTION - 1e-9

    def _show_bar(self, view: View, rate: float, speed: float) -> None:
        if self._bar is None:
            self._bar = _make_bar(self._stream)
            self._bar.add_task("run", total=view.total_steps)
            self._bar.start()
        text = f"{view.time:.4g} s, {speed:.4g} steps/s, {_left(view, rate)}"
        self._bar.update(self._bar.task_ids[0], completed=view.step, description=text)


def _make_bar(stream: PatientStream) -> Bar:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (BarColumn(), TaskProgressColumn(), TextColumn("{task.description}"))
    return Progress(*columns, console=Console(file=cast(TextIO, stream)))


def _fraction(view: View) -> float:
    return view.step / view.total_steps if view.total_steps else 1.0


def _line(view: View, rate: float, speed: float) -> str:
    fast = f", {speed:.4g} steps/s" if rate else ""
    return f"{100 * _fraction(view):3.0f} %  {view.time:.4g} s{fast}, {_left(view, rate)}"


def _left(view: View, rate: float) -> str:
    if view.step >= view.total_steps:
        return "done"
    if not rate:
        return "time left unknown"
    minutes, seconds = divmod(round((view.total_steps - view.step) / rate), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02} left"

"""Explicit steps of elastic bodies as replayed graphs, also where a part of a step runs on the host."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from warp_mps.core.replay import Replay
from warp_mps.elastic.explicit.solid import Solid
from warp_mps.elastic.explicit.step import Phase


def take_steps(solid: Solid, replay: Replay, count: int) -> None:
    """Take some steps.

    They are one graph. Where a phase runs on the host, the phases before and after it are graphs of their own, and
    every step waits for the device.

    Args:
        solid: The bodies.
        replay: Replays the launches.
        count: Number of steps.
    """
    if not any(phase.on_host for phase in solid.phases):
        replay(f"{count} steps", lambda: _repeat(solid.step, count))
        return
    parts = [list(part) for _, part in itertools.groupby(solid.phases, key=lambda phase: phase.on_host)]
    for _ in range(count):
        for number, part in enumerate(parts):
            if part[0].on_host:
                solid.launch(part)
            else:
                replay(f"part {number} of a step", _launcher(solid, part))


def _launcher(solid: Solid, phases: Sequence[Phase]) -> Callable[[], None]:
    return lambda: solid.launch(phases)


def _repeat(launch: Callable[[], None], times: int) -> None:
    for _ in range(times):
        launch()

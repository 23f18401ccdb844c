"""Launches that are captured once and replayed, or made one by one with the same result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import warp as wp


def capture(launch: Callable[[], None], device: Any) -> Any:
    """A graph of what is launched, which `warp.capture_launch` runs; nothing of it is run yet."""
    with wp.ScopedCapture(device=device) as captured:
        launch()
    return captured.graph


class Replay:
    """Replays what was launched under a name before.

    Args:
        device: Warp device.
        graphs: Whether to; if not, everything is launched anew.
    """

    def __init__(self, *, device: Any, graphs: bool) -> None:
        self._device, self._use_graphs = device, graphs
        self._graphs: dict[str, Any] = {}

    def __call__(self, name: str, launch: Callable[[], None]) -> None:
        """Launch; under one name always the same, for only the contents of arrays may change."""
        if not self._use_graphs:
            launch()
            return
        if name not in self._graphs:
            self._graphs[name] = capture(launch, self._device)
        wp.capture_launch(self._graphs[name])

    def forget(self) -> None:
        """Capture everything anew, for arrays have been replaced."""
        self._graphs.clear()

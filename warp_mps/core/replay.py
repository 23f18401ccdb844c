"""Launches that are captured as graphs and replayed, or made one by one with the same result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import warp as wp


def capture(launch: Callable[[], None], device: Any) -> Any:
    """Capture launches as a graph for `warp.capture_launch`, without running them."""
    with wp.ScopedCapture(device=device) as captured:
        launch()
    return captured.graph


class Replay:
    """Replays the graph of the launches that were captured under a name.

    Args:
        device: Warp device.
        graphs: Whether to use graphs; if not, everything is launched each time.
    """

    def __init__(self, *, device: Any, graphs: bool) -> None:
        self._device, self._use_graphs = device, graphs
        self._graphs: dict[str, Any] = {}

    def __call__(self, name: str, launch: Callable[[], None]) -> None:
        """Launch. Under one name the launches must always be the same: only the contents of arrays may change."""
        if not self._use_graphs:
            launch()
            return
        if name not in self._graphs:
            self._graphs[name] = capture(launch, self._device)
        wp.capture_launch(self._graphs[name])

    def forget(self) -> None:
        """Drop all graphs, because arrays have been replaced."""
        self._graphs.clear()

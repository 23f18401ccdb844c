"""Launches that are captured once and replayed, or made one by one with the same result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import warp as wp


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
            with wp.ScopedCapture(device=self._device) as capture:
                launch()
            self._graphs[name] = capture.graph
        wp.capture_launch(self._graphs[name])

"""A snapshot of a state on the device, which can be restored."""

from __future__ import annotations

from collections.abc import Sequence

import warp as wp


class Snapshot:
    """A copy of the contents of arrays.

    Args:
        arrays: The arrays of the state.
    """

    def __init__(self, arrays: Sequence[wp.array]) -> None:
        self._pairs = [(array, wp.empty_like(array)) for array in arrays if array.size]

    def save(self) -> None:
        """Copy the present contents."""
        for array, kept in self._pairs:
            wp.copy(kept, array)

    def restore(self) -> None:
        """Restore the contents of the last `save`."""
        for array, kept in self._pairs:
            wp.copy(array, kept)

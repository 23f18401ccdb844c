"""A state that can be gone back to, all of it on the device."""

from __future__ import annotations

from collections.abc import Sequence

import warp as wp


class Snapshot:
    """A copy of arrays.

    Args:
        arrays: What evolves.
    """

    def __init__(self, arrays: Sequence[wp.array]) -> None:
        self._pairs = [(array, wp.empty_like(array)) for array in arrays if array.size]

    def save(self) -> None:
        """Keep the present contents."""
        for array, kept in self._pairs:
            wp.copy(kept, array)

    def restore(self) -> None:
        """Go back to the contents that were kept."""
        for array, kept in self._pairs:
            wp.copy(array, kept)

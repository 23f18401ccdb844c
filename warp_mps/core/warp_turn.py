"""One thread at a time in Warp, which keeps one graph capture and one table of modules for a whole process.

A launch of one thread would become part of a graph that another one is capturing. So every call into Warp stands in
``with warp_turn:``; several simulations in threads of one process take turns, a block of steps each, and get the same
results as one after the other. Processes run side by side.
"""

from __future__ import annotations

import os
import threading


class Turn:
    """A lock that the thread that holds it may enter again; a forked process finds it free."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._renew)

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def _renew(self) -> None:
        # the thread that held it does not exist in the child
        self._lock = threading.RLock()


warp_turn = Turn()

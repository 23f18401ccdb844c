"""Work that must not be torn apart by Ctrl-C."""

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def hold_interrupts() -> Iterator[None]:
    """Let what is inside end before an interrupt (SIGINT) takes effect; an error inside comes before the interrupt."""
    handler = signal.getsignal(signal.SIGINT)
    # only the main thread is ever interrupted; a handler that is not Python's cannot be called, nor put back
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    held: list[tuple[int, FrameType | None]] = []
    signal.signal(signal.SIGINT, lambda *interrupt: held.append(interrupt))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if held:
        handler(*held[0])

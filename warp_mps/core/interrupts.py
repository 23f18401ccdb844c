"""Work that must not be torn apart by Ctrl-C, and what an interrupt sets off, by a second one."""

import _thread
import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def defer_interrupts() -> Iterator[None]:
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


# time after which an interrupt comes back that met a finalizer [s]
LATER = 0.01


def _finalizes(frame: FrameType | None) -> bool:
    """Whether a frame belongs to a finalizer: an exception there is printed and forgotten."""
    while frame is not None and frame.f_code.co_name != "__del__":
        frame = frame.f_back
    return frame is not None


@contextlib.contextmanager
def first_interrupt_only() -> Iterator[None]:
    """Let the first interrupt (SIGINT) take effect and no other, so that what it sets off comes to its end.

    One that arrives in a finalizer takes effect a little later.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    interrupted = False

    def once(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if not interrupted and _finalizes(frame):
            threading.Timer(LATER, _thread.interrupt_main).start()
        elif not interrupted:
            interrupted = True
            handler(number, frame)

    signal.signal(signal.SIGINT, once)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)

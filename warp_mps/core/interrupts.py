"""Interrupts (Ctrl-C, SIGINT): deferring one until a section of code has ended, and ignoring a second one."""

import _thread
import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def defer_interrupts() -> Iterator[None]:
    """Defer an interrupt (SIGINT) until the body has ended; an error of the body takes precedence."""
    handler = signal.getsignal(signal.SIGINT)
    # only the main thread is interrupted; a handler that is not Python's can be neither called nor restored
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


# delay of an interrupt that arrived in a finalizer [s]
FINALIZER_DELAY = 0.01


def _in_finalizer(frame: FrameType | None) -> bool:
    """Whether a frame belongs to a finalizer, where Python prints and discards exceptions."""
    while frame is not None and frame.f_code.co_name != "__del__":
        frame = frame.f_back
    return frame is not None


@contextlib.contextmanager
def first_interrupt_only() -> Iterator[None]:
    """Let the first interrupt (SIGINT) take effect and ignore others, so that the clean-up is not interrupted.

    An interrupt that arrives in a finalizer takes effect after `FINALIZER_DELAY`.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    interrupted = False

    def once(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        if not interrupted and _in_finalizer(frame):
            threading.Timer(FINALIZER_DELAY, _thread.interrupt_main).start()
        elif not interrupted:
            interrupted = True
            handler(number, frame)

    signal.signal(signal.SIGINT, once)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)

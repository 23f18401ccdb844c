"""Signals that ask a run to stop: Ctrl-C (SIGINT), and those of batch systems and terminals (SIGTERM, SIGHUP).

They reach Python's main thread as exceptions, KeyboardInterrupt or its subclass `TerminatedError`. Here they are
deferred until a section of code has ended, and a second one is ignored. A signal that the process ignores stays
ignored, as SIGINT in the background jobs of a shell and SIGHUP below nohup.
"""

from __future__ import annotations

import _thread
import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

# signals that kill a process unless it handles them
KILLING = tuple(signal.Signals[name] for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
STOPPING = (signal.SIGINT, *KILLING)
# delay of a signal that arrived in a finalizer [s]
FINALIZER_DELAY = 0.01

Handler = Callable[[int, FrameType | None], Any]


class TerminatedError(KeyboardInterrupt):
    """The process was asked to end by SIGTERM or SIGHUP.

    Attributes:
        number: The signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"ended by {signal.Signals(number).name}")
        self.number = number


@contextlib.contextmanager
def defer_interrupts() -> Iterator[None]:
    """Defer a signal that asks to stop until the body has ended; an error of the body takes precedence."""
    held: list[tuple[Handler, int, FrameType | None]] = []

    def deferred(handler: Handler) -> Handler:
        return lambda number, frame: held.append((handler, number, frame))

    with _replaced(STOPPING, deferred):
        yield
    if held:
        handler, number, frame = held[0]
        handler(number, frame)


@contextlib.contextmanager
def first_interrupt_only() -> Iterator[None]:
    """Let the first signal that asks to stop take effect and ignore others, so that the clean-up is not interrupted.

    A signal that arrives in a finalizer takes effect after `FINALIZER_DELAY`.
    """
    interrupted = False

    def once(handler: Handler) -> Handler:
        def handle(number: int, frame: FrameType | None) -> None:
            nonlocal interrupted
            if not interrupted and _in_finalizer(frame):
                threading.Timer(FINALIZER_DELAY, _thread.interrupt_main, (number,)).start()
            elif not interrupted:
                interrupted = True
                handler(number, frame)

        return handle

    with _replaced(STOPPING, once):
        yield


@contextlib.contextmanager
def raise_when_killed(*, again: bool) -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise a `TerminatedError` in the body where they would kill the process at once.

    Args:
        again: Whether the signal is sent again after the body, so that it then does what it would have done.
    """
    received: list[int] = []

    def terminate(number: int, frame: FrameType | None) -> None:
        received.append(number)
        raise TerminatedError(number)

    try:
        with _replaced(KILLING, lambda _: terminate, only=signal.SIG_DFL):
            yield
    finally:
        if again and received:
            signal.raise_signal(received[0])


@contextlib.contextmanager
def _replaced(
    numbers: tuple[signal.Signals, ...], make: Callable[[Handler], Handler], *, only: Any = None
) -> Iterator[None]:
    """Replace the handlers of signals in the body.

    Args:
        numbers: The signals.
        make: Makes the handler from the present one.
        only: Handlers to replace; None are all that can be called.
    """
    # only the main thread receives signals; a handler that is not Python's can be neither called nor restored
    here = threading.current_thread() is threading.main_thread()
    found = {number: signal.getsignal(number) for number in numbers if here}
    before: dict[signal.Signals, Any] = {
        number: handler for number, handler in found.items() if (callable(handler) if only is None else handler is only)
    }
    for number, handler in before.items():
        signal.signal(number, make(handler))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _in_finalizer(frame: FrameType | None) -> bool:
    """Whether a frame belongs to a finalizer, where Python prints and discards exceptions."""
    while frame is not None and frame.f_code.co_name != "__del__":
        frame = frame.f_back
    return frame is not None

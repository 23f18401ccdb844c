"""Interrupts are held, delivered and left alone."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator

import pytest

from warp_mps.core.interrupts import defer_interrupts, first_interrupt_only


@pytest.fixture(autouse=True)
def handler() -> Iterator[object]:
    """The handler of interrupts, which every test must find again at its end."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    assert signal.signal(signal.SIGINT, before) is signal.default_int_handler


def test_an_interrupt_comes_after_what_is_held() -> None:
    done = []

    @defer_interrupts()
    def work() -> None:
        for number in range(3):
            signal.raise_signal(signal.SIGINT)
            done.append(number)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == [0, 1, 2]


def test_without_an_interrupt_nothing_happens() -> None:
    with defer_interrupts():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_an_error_comes_before_the_interrupt() -> None:
    @defer_interrupts()
    def work() -> None:
        signal.raise_signal(signal.SIGINT)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        work()


def test_interrupts_that_are_ignored_stay_so() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with defer_interrupts():
        signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_threads_that_are_never_interrupted_hold_nothing() -> None:
    found = []

    def look() -> None:
        with defer_interrupts():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert found == [signal.default_int_handler]


def test_the_second_interrupt_does_not_stop_what_the_first_sets_off() -> None:
    done = []

    @first_interrupt_only()
    def work() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            signal.raise_signal(signal.SIGINT)
            done.append("kept")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["kept"]


def test_an_interrupt_in_a_finalizer_takes_effect_after_it() -> None:
    """An exception in there would be printed and forgotten."""
    done = []

    class Fragile:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)
            done.append("finalized")

    @first_interrupt_only()
    def work() -> None:
        fragile = Fragile()
        del fragile
        done.append("went on")
        # an interrupt that another thread sets off does not end a sleep, only what comes between two
        for _ in range(6000):
            time.sleep(0.01)
        done.append("never")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["finalized", "went on"]


def test_a_held_interrupt_is_the_first() -> None:
    done = []

    @first_interrupt_only()
    @defer_interrupts()
    def work() -> None:
        for number in range(2):
            signal.raise_signal(signal.SIGINT)
            done.append(number)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == [0, 1]


def test_ignored_interrupts_stay_ignored() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with first_interrupt_only():
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    signal.signal(signal.SIGINT, signal.default_int_handler)

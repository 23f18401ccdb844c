"""An observer of the user: an exception that it raises ends the run as failed, with all results kept."""

from __future__ import annotations

from collections.abc import Sequence

from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, View


class Guest(Observer):
    """Calls an observer, and turns an exception of it into the failure of the run, chained to it.

    Args:
        observer: The observer.
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self.every, self.interval = observer.every, observer.interval

    def observe(self, view: View) -> None:
        """Call the observer.

        Raises:
            RunError: It raised an exception.
        """
        try:
            self._observer.observe(view)
        except RunError:
            raise
        except Exception as error:
            raise self._failure("", f" at {view.time:.6g} s (step {view.step})", error) from error

    def close(self) -> None:
        """Close the observer.

        Raises:
            RunError: It raised an exception.
        """
        try:
            self._observer.close()
        except RunError:
            raise
        except Exception as error:
            raise self._failure(".close", "", error) from error

    def _failure(self, method: str, when: str, error: Exception) -> RunError:
        name = f"{type(self._observer).__name__}{method}"
        return RunError(f"the observer {name} failed{when}: {type(error).__name__}: {' '.join(str(error).split())}")


def guests(observers: Sequence[Observer]) -> list[Guest]:
    """Wrap the observers that a user gives.

    Raises:
        InputError: They are not a sequence of `Observer`, or `observe` of one cannot be called.
    """
    if not isinstance(observers, Sequence):
        reason = f"is {observers!r}, must be a list or tuple of objects of subclasses of warp_mps.Observer"
        raise InputError("", "observers", reason)
    for number, observer in enumerate(observers):
        if not isinstance(observer, Observer):
            reason = f"is {observer!r}, must be an object of a subclass of warp_mps.Observer"
            raise InputError("", f"observers[{number}]", reason)
        if not callable(observer.observe):
            raise InputError(
                "", f"observers[{number}].observe", f"is {observer.observe!r}, must be a method observe(view)"
            )
    return [Guest(observer) for observer in observers]

"""The two ways a run can end badly, each with one line for the user."""

from __future__ import annotations

# longest text of a place, an attribute or a reason; a longer one is cut in its middle
LONGEST = 400


class InputError(ValueError):
    """The input cannot be run (exit code 2). The text is one line of limited length.

    Args:
        where: Owner of the input: a prim path, or a Python object such as ``body 'beam'``.
        attribute: The attribute or field that is wrong; empty when the whole object is.
        reason: The value, the constraint and the remedy.
    """

    def __init__(self, where: str, attribute: str, reason: str) -> None:
        self.where = where
        self.attribute = attribute
        self.reason = reason
        where, attribute, reason = (_line(part) for part in (where, attribute, reason))
        subject = " ".join(part for part in (where, attribute) if part)
        super().__init__(f"{subject}: {reason}" if subject else reason)

    def __reduce__(self) -> tuple[object, ...]:
        # an exception is copied, and sent from one process to another, by the arguments of its constructor
        return type(self), (self.where, self.attribute, self.reason), self.__dict__


def _line(text: str) -> str:
    """A text as one line of limited length, its beginning and its end."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"


class RunError(RuntimeError):
    """A run has failed after its start (exit code 3); the results so far are kept."""

"""The two ways a run can end badly, each with one line for the user."""

from __future__ import annotations

# of a place, an attribute or a reason: what is longer is a value that nobody wants to read
LONGEST = 400


class InputError(ValueError):
    """What was asked for cannot be run (exit code 2). Its text is one line, in which what is far too long is cut.

    Args:
        where: What the input belongs to: a prim path, or a Python object such as ``body 'beam'``.
        attribute: The attribute or field that is wrong; empty when the whole object is.
        reason: What is wrong with it and what is allowed.
    """

    def __init__(self, where: str, attribute: str, reason: str) -> None:
        self.where = where
        self.attribute = attribute
        self.reason = reason
        where, attribute, reason = (_line(part) for part in (where, attribute, reason))
        subject = " ".join(part for part in (where, attribute) if part)
        super().__init__(f"{subject}: {reason}" if subject else reason)


def _line(text: str) -> str:
    """A text as one line of limited length, its beginning and its end."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"


class RunError(RuntimeError):
    """A run that had begun had to be stopped (exit code 3); what was computed before is kept."""

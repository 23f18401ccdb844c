"""The two ways a run can end badly, each with one line for the user."""

from __future__ import annotations


class InputError(ValueError):
    """What was asked for cannot be run (exit code 2).

    Args:
        where: What the input belongs to: a prim path, or a Python object such as ``body 'beam'``.
        attribute: The attribute or field that is wrong; empty when the whole object is.
        reason: What is wrong with it and what is allowed.
    """

    def __init__(self, where: str, attribute: str, reason: str) -> None:
        self.where = where
        self.attribute = attribute
        self.reason = reason
        super().__init__(" ".join(part for part in (where, attribute) if part) + ": " + reason)


class RunError(RuntimeError):
    """A run that had begun had to be stopped (exit code 3); what was computed before is kept."""

"""What counts as a number in the fields of shapes and scenes."""

from __future__ import annotations


def is_number(value: object) -> bool:
    """Whether something is one number, of whatever type; a text is none."""
    if isinstance(value, str | bytes):
        return False
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True

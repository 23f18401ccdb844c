"""Whether the fields of one record of a scene are allowed on their own: types, ranges, names."""

from __future__ import annotations

import re
from typing import Any

from warp_mps.scene.fields import attributes_of
from warp_mps.scene.validation.limits import check_limits
from warp_mps.scene.validation.rules import require
from warp_mps.scene.validation.types import check_types

# first characters of a cell that spreadsheets take for a formula
_FORMULA = ("=", "+", "-", "@")
LONGEST_NAME = 200


def check_record(record: Any) -> None:
    """Check the fields of a record, but not those of the records in it.

    Raises:
        InputError: A field holds something of another type, a number out of its range, or a name that is not allowed.
    """
    where = place_of(record)
    check_types(record, where)
    check_limits(record, where)
    for name, known in attributes_of(type(record)).items():
        if known.text:
            _check_name(getattr(record, name), known.text, where, name)


def place_of(record: Any) -> str:
    """How an error names a record: its path, its kind and name, or its kind."""
    path = getattr(record, "path", "")
    if isinstance(path, str) and path:
        return path
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(record).__name__).lower()
    return f"{words} {record.name!r}" if hasattr(record, "name") else words


def _check_name(name: str, kind: str, where: str, attribute: str) -> None:
    require(bool(name), where, attribute, "is empty")
    require(len(name) <= LONGEST_NAME, where, attribute, f"has {len(name)} characters, at most {LONGEST_NAME} allowed")
    if kind == "identifier":
        reason = f"is {name!r}, must be letters, digits and _ as in a prim's"
        require(name.isidentifier(), where, attribute, reason)
        return
    require(name.isprintable(), where, attribute, f"is {name!r}, must be printable characters")
    reason = f"is {name!r}, must not begin with {name[0]!r}: spreadsheets would take it for a formula"
    require(not name.startswith(_FORMULA), where, attribute, reason)

"""Numbers in the records of a checkpoint, which may come from anywhere."""

from __future__ import annotations

from warp_mps.results.summary_check import is_number


def numbers_of(record: object, names: list[str]) -> list[float]:
    """The numbers of a record by their names.

    Raises:
        ValueError: The record holds no finite number under one of the names.
    """
    found = record if isinstance(record, dict) else {}
    for name in names:
        if not is_number(found.get(name)):
            raise ValueError(f"{name} is {found.get(name)!r}, must be a finite number")
    return [float(found[name]) for name in names]

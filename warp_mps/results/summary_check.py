"""Types of what run.json holds: a file of results may come from anywhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Check = Callable[[Any], bool]
# JSON that is nested more deeply is no summary
DEEPEST = 20
# largest magnitude of a number: its square can be computed
LARGEST = 1e150


def is_number(value: object) -> bool:
    """Whether a value is a finite number that can be computed with."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def wrong_item(data: Mapping[str, Any]) -> str | None:
    """The first item of a summary that is of a wrong type, as a text for the user; None if there is none."""
    for name, (check, wanted) in CHECKS.items():
        if name in data and not check(data[name]):
            return f"{name} is {_brief(data[name])}, must be {wanted}"
    for number, row in enumerate(data.get("measurements", [])):
        for name, (check, wanted) in ROW_CHECKS.items():
            if name not in row and name in NEEDED:
                return f"measurements[{number}] has no {name}"
            if name in row and not check(row[name]):
                return f"measurements[{number}] {name} is {_brief(row[name])}, must be {wanted}"
    return None


def _brief(value: object) -> str:
    text = ascii(value)
    return text if len(text) <= 40 else f"{text[:40]}..."


def _text(value: object) -> bool:
    """Whether a value is a text that can be written: JSON can hold halves of characters."""
    if not isinstance(value, str):
        return False
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def _optional(check: Check) -> Check:
    return lambda value: value is None or check(value)


def _named(check: Check) -> Check:
    return lambda value: isinstance(value, dict) and all(map(check, value.values())) and all(map(_text, value))


def _count(value: object) -> bool:
    return is_number(value) and isinstance(value, int) and value >= 0


def _time(value: object) -> bool:
    return is_number(value) and value >= 0  # type: ignore[operator]


def _window(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and is_number(value[0]) and _optional(is_number)(value[1])


def _rows(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(row, dict) for row in value)


def _texts(value: object) -> bool:
    return isinstance(value, list) and all(map(_text, value))


def _plain(value: object, depth: int = 0) -> bool:
    """Whether a value is made of texts and of numbers that can be computed with, and nested not too deeply."""
    if isinstance(value, dict | list):
        items = value.values() if isinstance(value, dict) else value
        names = map(_text, value) if isinstance(value, dict) else []
        return depth < DEEPEST and all(names) and all(_plain(item, depth + 1) for item in items)
    return value is None or isinstance(value, bool) or _text(value) or is_number(value)


def _settings(value: object) -> bool:
    return isinstance(value, dict) and _plain(value)


NUMBERS = "numbers by name"
CHECKS: dict[str, tuple[Check, str]] = {
    "case": (_text, "a text"),
    "reason": (_text, "a text"),
    "device": (_text, "a text"),
    "precision": (lambda value: value in ("float64", "float32"), "float64 or float32"),
    "versions": (_named(_text), "texts by name"),
    "dimension": (lambda value: value in (2, 3) and isinstance(value, int), "2 or 3"),
    "particles": (_named(_count), "whole numbers by name"),
    "settings": (_settings, "texts and numbers by name"),
    "steps": (_count, "a whole number"),
    "time": (_time, "a number of 0 or more"),
    "wall_seconds": (_time, "a number of 0 or more"),
    "particle_steps_per_second": (_named(_optional(is_number)), NUMBERS),
    "energy": (_named(_optional(is_number)), NUMBERS),
    "momentum_error": (_optional(is_number), "a number or null"),
    "fluid": (_named(_optional(is_number)), NUMBERS),
    "implicit": (_named(_optional(is_number)), NUMBERS),
    "coupling": (_named(_optional(is_number)), NUMBERS),
    "measurements": (_rows, "a list of measurements"),
    "remarks": (_texts, "a list of texts"),
}
# what a measurement must have, and what stands for the rest
NEEDED = ("name",)
ABSENT: dict[str, Any] = {"value": None, "unit": "", "reference": None, "error": None, "source": ""}
ROW_CHECKS: dict[str, tuple[Check, str]] = {
    **dict.fromkeys(("name", "unit", "source"), (_text, "a text")),
    **dict.fromkeys(("value", "reference", "error", "at"), (_optional(is_number), "a number or null")),
    **dict.fromkeys(("measure", "column", "reason"), (_optional(_text), "a text or null")),
    "window": (_optional(_window), "two times, the second may be null"),
}

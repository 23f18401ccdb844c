"""Whether every field of a record of a scene holds a value of the type of its annotation, checked before it is used."""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.numbers import is_number

# names of the types of fields in messages
_WORDS: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    str: "a text",
    bool: "True or False",
    type(None): "None",
    Callable: "a function",
}


def check_types(record: Any, where: str) -> None:
    """Check the fields of a record of a scene, but not those of the records in it.

    Args:
        record: A scene, or a part of one.
        where: Its name in error messages.

    Raises:
        InputError: A field holds something of another kind.
    """
    for name, hint in _hints(record.__class__).items():
        value = getattr(record, name)
        if not _fits(value, hint):
            word, options = _wrong_word(value, hint)
            allowed = f"one of: {', '.join(options)}" if options else _wording(hint)
            raise InputError(where, name, f"is {_shown(word)}, must be {allowed}")


@functools.cache
def _hints(kind: Any) -> dict[str, Any]:
    return {field.name: typing.get_type_hints(kind)[field.name] for field in dataclasses.fields(kind)}


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of a kind; lists pass for tuples, and anything that NumPy converts to numbers for an array."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return any(_fits(value, option) for option in inner)
    if origin is Literal:
        return any(_fits(value, type(word)) and value == word for word in inner)
    if origin is tuple:
        return isinstance(value, tuple | list) and _fit(value, inner)
    if origin is Sequence or hint is np.ndarray or origin is np.ndarray:
        return _are_numbers(value)
    if hint in (float, int):
        return is_number(value) and (hint is float or isinstance(value, int | np.integer))
    return isinstance(value, hint)


def _fit(values: Sequence[Any], hints: Sequence[Any]) -> bool:
    """Whether the items of a tuple are of the kinds of its annotation."""
    if hints[-1] is Ellipsis:
        return all(_fits(item, hints[0]) for item in values)
    return len(values) == len(hints) and all(map(_fits, values, hints))


def _wrong_word(value: Any, hint: Any) -> tuple[Any, tuple[str, ...]]:
    """The value, or the item of a tuple, that is not one of the words of a closed set, and these words."""
    for option in (hint, *typing.get_args(hint)):
        if typing.get_origin(option) is Literal:
            items = value if option is not hint and isinstance(value, tuple | list) else [value]
            if option is hint or isinstance(value, tuple | list):
                wrong = [item for item in items if not _fits(item, option)]
                return wrong[0], tuple(str(word) for word in typing.get_args(option))
    return value, ()


def _are_numbers(value: Any) -> bool:
    try:
        return np.ndim(np.asarray(value, float)) > 0 and not isinstance(value, str)
    except (TypeError, ValueError, OverflowError):
        return False


def _shown(value: Any) -> str:
    """A value, or its type and the types of its items where it is long."""
    if isinstance(value, int) and not is_number(value):
        return "a whole number too large for a float"
    if len(repr(value)) < 40:
        return repr(value)
    kinds = {type(item).__name__: None for item in value} if isinstance(value, tuple | list) else {}
    return f"a {type(value).__name__}{' of ' if kinds else ''}{' and '.join(kinds)}"


def _wording(hint: Any) -> str:
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_wording(option) for option in inner)
    if origin is tuple:
        kinds = {float: "numbers", int: "whole numbers", str: "texts"}
        if typing.get_origin(inner[0]) is Literal:
            return "a tuple of texts"
        vectors = typing.get_origin(inner[0]) is not None
        return f"a tuple of {'vectors' if vectors else kinds.get(inner[0]) or _plural(inner[0].__name__)}"
    if origin is Sequence or hint is np.ndarray or origin is np.ndarray:
        return "a sequence of numbers"
    return _WORDS.get(hint) or f"{'an' if hint.__name__[0] in 'AEIO' else 'a'} {hint.__name__}"


def _plural(name: str) -> str:
    return f"{name[:-1]}ies" if name.endswith("y") else f"{name}s"

"""The attributes of a stage that describe a case: one table, which reading, saving, overrides and the schema use.

Nearly all of it follows from the fields of the scene's classes (`warp_mps.scene.fields`), the rest stands in
`warp_mps.usd.case.stage_attribute`.
"""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Sequence
from typing import Any

import numpy as np

from warp_mps import scene as sc
from warp_mps.scene.fields import UNITS, Attribute, attributes_of, default_of, meanings
from warp_mps.usd.case.stage_attribute import SHAPE, STAGE_ONLY, StageAttribute

ROLES = ("body", "part", "wall", "fluid", "support", "load", "probe", "measurement")
ROLE = "mps:role"

# the class that each role describes
CLASSES: dict[str, type] = {
    "scene": sc.Scene,
    "body": sc.Body,
    "part": sc.Part,
    "wall": sc.Wall,
    "fluid": sc.Fluid,
    "material": sc.Material,
    "liquid": sc.Liquid,
    "support": sc.Support,
    "load": sc.Load,
    "probe": sc.Probe,
    "measurement": sc.Measurement,
}


def stage_attributes(role: str) -> dict[str, StageAttribute]:
    """The attributes of a role by their names, from the fields of its class."""
    kind = CLASSES[role]
    names = {field.name for field in dataclasses.fields(kind)}
    shape = SHAPE if names & {"shape", "region"} else ()
    rows = [*_rows_of(kind), *shape, *STAGE_ONLY.get(role, ())]
    words = {row.field: row.name for row in rows}
    return {row.name: dataclasses.replace(row, meaning=_in_stage(row, words)) for row in rows}


def _rows_of(kind: type, prefix: str = "", *, optional: bool = False) -> list[StageAttribute]:
    """The attributes of a class: those of its fields, and of the records in it that have no prim of their own.

    Args:
        kind: The class.
        prefix: Prefix of the names of its fields, such as ``flow.``.
        optional: Whether a scene can do without the record.
    """
    hints = typing.get_type_hints(kind)
    rows: dict[str, StageAttribute] = {}
    for name, known in attributes_of(kind).items():
        if known.name:
            rows[name] = _row(kind, name, hints[name], prefix, optional=optional)
            continue
        for option in _options(hints[name]):
            if isinstance(option, type) and dataclasses.is_dataclass(option) and "path" not in attributes_of(option):
                found = _rows_of(option, f"{prefix}{name}.", optional=type(None) in typing.get_args(hints[name]))
                rows |= {row.field: row for row in found if row.field not in rows}
    return list(rows.values())


def _row(kind: type, name: str, hint: Any, prefix: str, *, optional: bool) -> StageAttribute:
    known, default, given = attributes_of(kind)[name], default_of(kind, name), attributes_of(kind)[name].stage_default
    missing = default is dataclasses.MISSING
    in_units = bool(known.unit in UNITS and not missing and default)
    plain = None if missing or in_units or isinstance(default, tuple) else default
    return StageAttribute(
        name=known.name,
        kind=known.kind or _kind(hint, known),
        field=prefix + name,
        meaning=meanings(kind).get(name, ""),
        known=known,
        default=plain if given is None else given,
        si_default=default if in_units else None,
        allowed=tuple(str(word) for word in known.allowed or _words(hint)),
        required=missing and not optional,
        scalar_in_plane=float in _options(hint) and known.nature == "axial",
        single=str in _options(hint),
    )


def _options(hint: Any) -> tuple[Any, ...]:
    """The alternatives of an annotation, without None."""
    union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return tuple(item for item in (typing.get_args(hint) if union else (hint,)) if item is not type(None))


def _words(hint: Any) -> tuple[Any, ...]:
    """The allowed words of an annotation, or of the items of its tuple."""
    literals = (hint, *typing.get_args(hint))
    return next((typing.get_args(item) for item in literals if typing.get_origin(item) is typing.Literal), ())


def _kind(hint: Any, known: Attribute) -> str:
    """Type in a stage of what an annotation says."""
    if known.refers_to:
        return "rel"
    if known.axes:
        return "token"
    if _words(hint):
        return "token[]" if typing.get_origin(hint) is tuple else "token"
    options = _options(hint)
    if any(typing.get_origin(option) is Sequence for option in options):
        return "double3"
    return {float: "double", int: "int", bool: "bool", str: "string", np.ndarray: "double[]"}[options[0]]


def _in_stage(row: StageAttribute, words: dict[str, str]) -> str:
    """The meaning of an attribute, with the names that other fields have in a stage, and what a stage adds to it."""
    prefix = row.field.rpartition(".")[0]
    near = {field.removeprefix(f"{prefix}."): name for field, name in words.items() if prefix}
    text = re.sub(r"`([\w.]+)`", lambda found: f"`{({**words, **near}).get(found[1], found[1])}`", row.meaning)
    if row.known.axes:
        whose = "the shape's own axes" if row.known.axes == "shape" else "axes of the stage"
        text = f"{text} Letters of {whose}, such as `xz`."
    return text


TABLE: dict[str, dict[str, StageAttribute]] = {role: stage_attributes(role) for role in CLASSES}

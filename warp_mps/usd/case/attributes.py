"""The attributes of a stage that describe a case: one table, which reading, saving, overrides and the schema use.

Nearly all of it follows from the fields of the scene's classes (`warp_mps.scene.fields`); `_STAGE_ONLY` holds the rest.
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
from warp_mps.errors import InputError
from warp_mps.scene.fields import UNITS, Attribute, Unit, attributes_of, default_of, meanings

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


@dataclasses.dataclass(frozen=True, kw_only=True)
class StageAttribute:
    """One attribute, or relationship, of a stage.

    Attributes:
        name: Name in the stage.
        kind: Type in the stage, ``rel`` for a relationship.
        field: Field of the scene that it fills, as errors name it: in a record of its own such as ``flow.courant``.
        meaning: What it says.
        known: What is known of the field.
        default: Value when it is not given; None when there is none, or when it depends on the units of the stage.
        si_default: Default in SI units, where it depends on the units of the stage.
        allowed: Allowed words.
        required: Whether it must be given.
        scalar_in_plane: Whether an axial vector is a plain number in a 2-D scene.
        single: Whether a relationship has one target.
        stage_only: Whether it fills no field by itself; reading and saving treat it on their own.
    """

    name: str
    kind: str
    field: str
    meaning: str
    known: Attribute
    default: Any = None
    si_default: float | None = None
    allowed: tuple[str, ...] = ()
    required: bool = False
    scalar_in_plane: bool = False
    single: bool = False
    stage_only: bool = False

    @property
    def unit(self) -> str:
        """Unit in the stage, L the stage's length and M its mass."""
        return self._scale.stage

    @property
    def length(self) -> int:
        """Power of the stage's unit of length in its unit."""
        return self._scale.length

    @property
    def mass(self) -> int:
        """Power of the stage's unit of mass in its unit."""
        return self._scale.mass

    @property
    def _scale(self) -> Unit:
        return UNITS.get(self.known.unit, Unit(self.known.unit))

    @property
    def own(self) -> bool:
        """Whether it is this package's, not one of `UsdPhysics`."""
        return self.name.startswith("mps:")


def _stage_only(name: str, kind: str, field: str, meaning: str, **more: Any) -> StageAttribute:
    known = Attribute(name=name, unit=more.pop("unit", ""), nature=more.pop("nature", "polar"))
    return StageAttribute(name=name, kind=kind, field=field, meaning=meaning, known=known, stage_only=True, **more)


# shapes are prims of UsdGeom; this is what these lack
_SHAPE = (
    _stage_only(
        *("mps:innerRadius", "double", "inner_radius"),
        "Radius of the bore of a Cylinder, less than its radius.",
        unit="m",
        default=0.0,
    ),
    _stage_only(
        *("mps:plus", "rel", "plus"),
        "Geometries (Cube, Sphere, Cylinder, Mesh) that its shape is united with.",
    ),
    _stage_only(
        *("mps:intersect", "rel", "intersect"),
        "Geometries that its shape is then reduced to: what lies in all of them is left.",
    ),
    _stage_only(*("mps:minus", "rel", "minus"), "Geometries that are then cut out of its shape."),
)
# what is a field of the scene in another form, so that no single field gives its name and type
_STAGE_ONLY: dict[str, tuple[StageAttribute, ...]] = {
    "scene": (
        # the axes of a StageFrame, which is known before anything can be read
        _stage_only(
            *("mps:plane", "token", "stage.axes"),
            "Plane of a 2-D scene: `xy` where y is up, `xz` where z is up, if not given.",
            allowed=("xy", "xz", "yz"),
        ),
        # UsdPhysics gives gravity as a direction and a magnitude
        _stage_only(
            *("physics:gravityDirection", "vector3f", "gravity.direction"),
            "Direction of gravity; zero points it down the up axis.",
            default=(0.0, 0.0, 0.0),
        ),
        _stage_only(
            *("physics:gravityMagnitude", "float", "gravity"),
            "Acceleration of gravity; a negative number is 9.81 m/s^2.",
            unit="m/s^2",
            default=float("-inf"),
        ),
        # two corners make one domain
        _stage_only(
            *("mps:domainLow", "double3", "flow.domain.low"),
            "Fluids: lowest corner of the region that is computed; particles that leave it are left out.",
            unit="m",
            nature="point",
        ),
        _stage_only(
            *("mps:domainHigh", "double3", "flow.domain.high"),
            "Fluids: highest corner of this region.",
            unit="m",
            nature="point",
        ),
    ),
    # the shape that is cut at it
    "fluid": (
        _stage_only(
            *("mps:fillLevel", "double", "level"),
            "Height along the up axis at which its shape is cut: the free surface.",
            unit="m",
        ),
    ),
    # a part knows its body, a Body its parts
    "part": (_stage_only("mps:body", "rel", "body", "The body that it is a part of.", required=True),),
    # the body or the support of a Probe
    "probe": (
        _stage_only(
            *("mps:target", "rel", "target"),
            "A body, wall, fluid or support whose quantity is recorded, instead of that of a place.",
        ),
    ),
    # a number in the scene, the name of an axis in the stage
    "measurement": (
        _stage_only(
            *("mps:component", "token", "component"),
            "Component of the probe: an axis of the stage, or of a stress or strain two; its first if not given.",
            allowed=("x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz"),
        ),
    ),
}


def stage_attributes(role: str) -> dict[str, StageAttribute]:
    """The attributes of a role by their names, from the fields of its class."""
    kind = CLASSES[role]
    names = {field.name for field in dataclasses.fields(kind)}
    shape = _SHAPE if names & {"shape", "region"} else ()
    rows = [*_rows_of(kind), *shape, *_STAGE_ONLY.get(role, ())]
    words = {row.field: row.name for row in rows}
    return {row.name: dataclasses.replace(row, meaning=_in_stage(row, words)) for row in rows}


def _rows_of(kind: type, prefix: str = "", *, optional: bool = False) -> list[StageAttribute]:
    """The attributes of a class: those of its fields, and of the records in it that have no prim of their own.

    Args:
        kind: The class.
        prefix: What stands before the names of its fields, such as ``flow.``.
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
        text = f"{text} A word of {whose}, such as `xz`."
    return text


TABLE: dict[str, dict[str, StageAttribute]] = {role: stage_attributes(role) for role in CLASSES}

# fields of shapes and of the scene whose name in the stage is not in the table
_OTHER_NAMES = {
    "size": "size",
    "radius": "radius",
    "height": "height",
    "points": "points",
    "triangles": "faceVertexIndices",
    "positions": "points",
    "velocities": "velocities",
    "placement": "xformOpOrder",
    "shape": "",
    "region": "",
    "point": "",
}


# those of them that are lengths
_LENGTHS = ("size", "radius", "height")


def stage_name(field: str) -> str:
    """Name in the stage of a field of the scene; the field itself if the stage has no such thing."""
    row = _row_of(field)
    return row.name if row else _OTHER_NAMES.get(field, field)


def stage_error(error: InputError, units: sc.StageFrame | None = None) -> InputError:
    """The same error in the words of a stage: its attribute is the one to change there.

    Args:
        error: The error; where its attribute is a field of the scene, its numbers are in SI units.
        units: Units of the stage, which are mentioned if they are others.
    """
    row, reason = _row_of(error.attribute), error.reason
    length = row.length if row else error.attribute in _LENGTHS
    if units and length and units.meters_per_unit != 1.0:
        reason += f" (numbers in metres; the stage's unit is {units.meters_per_unit:g} m)"
    if units and row and row.mass and units.kilograms_per_unit != 1.0:
        reason += f" (numbers in SI units; the stage's unit of mass is {units.kilograms_per_unit:g} kg)"
    return InputError(error.where, stage_name(error.attribute), reason)


def _row_of(field: str) -> StageAttribute | None:
    """The row of the table that fills a field of the scene."""
    return next((row for table in TABLE.values() for row in table.values() if row.field == field), None)

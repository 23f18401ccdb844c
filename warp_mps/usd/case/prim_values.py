"""The attributes of a prim, checked for their type and turned into SI units and the scene's axes."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping
from typing import Any, TypeVar

import numpy as np
from pxr import Sdf, Tf, Usd, Vt

from warp_mps.errors import InputError
from warp_mps.scene.validation.rules import LARGEST
from warp_mps.usd.case.attributes import ROLE, TABLE
from warp_mps.usd.case.authored import check_kind, constant, is_given
from warp_mps.usd.case.diagnostics import reason_of
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.stage_attribute import StageAttribute

Kind = TypeVar("Kind")


class Values:
    """The attributes of a prim.

    Args:
        prim: The prim.
        role: Its role, a key of the table of attributes.
        frame: Units and axes.
        names: Names that the prims of each role have in the scene, by their paths.
    """

    def __init__(
        self, prim: Usd.Prim, role: str, frame: Frame, names: Mapping[str, Mapping[str, str]] | None = None
    ) -> None:
        self.prim, self.frame, self.table, self.names = prim, frame, TABLE[role], names or {}
        self.path = str(prim.GetPath())

    def check_names(self) -> None:
        """Refuse attributes that are not in the table, most likely misspelt, and relationships in place of attributes.

        Raises:
            InputError: There is one.
        """
        for found in self.prim.GetAuthoredPropertyNames():
            if found in self.table:
                relation = self.table[found].kind == "rel"
                check_kind(self.prim, found, Sdf.RelationshipSpec if relation else Sdf.AttributeSpec)
            elif found.startswith("mps:") and found != ROLE:
                others = [role for role, table in TABLE.items() if found in table]
                near = difflib.get_close_matches(found, self.table, n=1)
                hint = f"did you mean {near[0]}?" if near else "known are " + ", ".join(self.table)
                hint = f"it is for: {', '.join(others)}" if others else hint
                raise InputError(self.path, found, f"is not known here; {hint}")

    def given(self, name: str) -> bool:
        """Whether the prim gives a value of its own."""
        return is_given(self.prim, name)

    def fields(self, record: str = "", *, without: Collection[str] = ()) -> dict[str, Any]:
        """The fields of the scene's class that the prim gives, by their names.

        Args:
            record: Field that holds a record whose fields are meant, such as ``flow``; empty for those of the class.
            without: Names of fields that are left out.

        Raises:
            InputError: One is required and missing, or its value is not allowed.
        """
        found = {}
        for row in self.table.values():
            owner, _, field = row.field.rpartition(".")
            if owner == record and not row.stage_only and field not in without:
                found[field] = self.get(row.name)
        return {field: value for field, value in found.items() if value is not None}

    def record(self, kind: type[Kind], name: str, given: Mapping[str, Any]) -> Kind:
        """A record that a field of the scene's class holds.

        Args:
            kind: Class of the record.
            name: The field, such as ``flow``.
            given: Fields of the record.

        Raises:
            InputError: The record refuses a field; the error names the prim.
        """
        try:
            return kind(**given)
        except InputError as error:
            raise InputError(self.path, f"{name}.{error.attribute}", error.reason) from None

    def get(self, name: str) -> Any:
        """Value of an attribute as the scene has it: in SI units, vectors as tuples along the scene's axes.

        A relationship gives the names of the items that it refers to, letters of axes their numbers.

        Returns:
            The value, None if it is not given.

        Raises:
            InputError: It is missing but required, of the wrong type, not finite, or not one of the allowed values.
        """
        row = self.table[name]
        if row.known.refers_to:
            found = self.items(name, row.known.refers_to)
            return self._single(row, found) if row.single else found
        if not self.given(name):
            if row.required:
                raise InputError(self.path, name, f"is missing: {row.meaning}")
            return None
        value = typed(self.prim.GetAttribute(name), row.kind)
        wrong = [word for word in (value if row.kind == "token[]" else [value]) if str(word) not in row.allowed]
        if row.allowed and wrong:
            raise InputError(self.path, name, f"is {wrong[0]!r}, must be one of: {', '.join(row.allowed)}")
        return self._axes(row, value) if row.known.axes else self._in_scene(row, value)

    def items(self, name: str, role: str) -> tuple[str, ...]:
        """Names of the items of a role that a relationship refers to.

        Raises:
            InputError: It refers to something else, or none is given and one is required.
        """
        targets = self.targets(name)
        for target in targets:
            if target not in self.names[role]:
                reason = f'must refer to a {role}, {target} is not one: it has no {ROLE} = "{role}"'
                raise InputError(self.path, name, reason)
        return tuple(self.names[role][target] for target in targets)

    def targets(self, name: str) -> list[str]:
        """Paths that a relationship refers to.

        Raises:
            InputError: There is no prim at one of them, or none is given and one is required.
        """
        prims = related_prims(self.prim, name)
        if not prims and self.table[name].required:
            raise InputError(self.path, name, f"is missing: {self.table[name].meaning}")
        return [str(prim.GetPath()) for prim in prims]

    def _single(self, row: StageAttribute, found: tuple[str, ...]) -> str | None:
        if len(found) > 1:
            raise InputError(self.path, row.name, f"must refer to one {row.known.refers_to}, not {len(found)}")
        return found[0] if found else None

    def _axes(self, row: StageAttribute, word: str) -> tuple[int, ...]:
        """Numbers of the axes that a word such as ``xz`` names."""
        known = "xyz" if row.known.axes == "shape" else self.frame.stage.axes
        if any(axis not in known for axis in word) or len(set(word)) != len(word):
            raise InputError(self.path, row.name, f"is {word!r}, must be axes among {known}, each once")
        return tuple(sorted(known.index(axis) for axis in word))

    def _in_scene(self, row: StageAttribute, value: Any) -> Any:
        """A value of the stage in SI units and along the scene's axes."""
        if row.kind in ("double", "float"):
            return value * self.frame.factor(row)
        if row.kind == "double[]":
            return np.asarray(value, float)
        if row.kind == "double3[]":
            return self.frame.vectors_to_scene(np.asarray(value, float).reshape(-1, 3), row, self.path)
        if row.kind == "double3":
            vector = tuple(self.frame.vectors_to_scene(np.asarray(value), row, self.path).tolist())
            return vector[0] if row.scalar_in_plane and len(vector) == 1 else vector
        return value


def related_prims(prim: Usd.Prim, name: str) -> list[Usd.Prim]:
    """The prims that a relationship refers to; none if it is not given.

    Raises:
        InputError: It is an attribute, there is no prim at a target, or a target lies outside the prim that a reference
            or payload brings in: USD drops such a target.
    """
    path = str(prim.GetPath())
    check_kind(prim, name, Sdf.RelationshipSpec)
    if not prim.HasRelationship(name):
        return []
    relationship = prim.GetRelationship(name)
    try:
        targets = relationship.GetForwardedTargets()
    except Tf.ErrorException as error:
        raise InputError(path, name, reason_of(error)) from None
    written: list[Any] = next((spec.targetPathList.explicitItems for spec in relationship.GetPropertyStack()), [])
    if len(written) > len(relationship.GetTargets()):
        outside = ", ".join(str(target) for target in written)
        reason = f"refers to {outside}, not all of which lie inside the prim that is referenced; refer to it there"
        raise InputError(path, name, reason)
    prims = [prim.GetStage().GetPrimAtPath(target) for target in targets]
    for target, found in zip(targets, prims, strict=True):
        if not found:
            raise InputError(path, name, f"refers to {target}, but there is no prim at that path")
    return prims


def typed(attribute: Usd.Attribute, kind: str) -> Any:
    """Value of an attribute as plain numbers and texts, arrays as floats.

    Raises:
        InputError: It varies in time, is of another type, not finite, or absurdly large.
    """
    path, name = str(attribute.GetPrim().GetPath()), attribute.GetName()
    check_kind(attribute.GetPrim(), name, Sdf.AttributeSpec)
    value = constant(attribute)
    if value is None:
        raise InputError(path, name, "must have a value")
    plain = _plain(value, kind)
    if plain is None:
        # as it is written: of a prim that applies the schema, the attribute itself has the type of the schema
        written = attribute.GetPropertyStack()[0].typeName
        raise InputError(path, name, f"must be {kind}, not {written}")
    if kind not in ("token", "token[]", "string", "bool"):
        if not np.isfinite(plain).all():
            raise InputError(path, name, "must be finite")
        if np.size(plain) and np.abs(plain).max() > LARGEST:
            raise InputError(path, name, f"must be at most {LARGEST:g} in size")
    return plain


def shortest(value: float) -> float:
    """The shortest decimal that identifies a single-precision number: 9.81, not 9.8100004196."""
    return float(str(np.float32(value)))


def _plain(value: Any, kind: str) -> Any:
    """The value as the plain type of its kind, None if it is of another."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind in ("float", "double"):
        return None if not number else shortest(value) if kind == "float" else float(value)
    if kind in ("token", "string", "int", "bool"):
        return value if type(value) is {"int": int, "bool": bool}.get(kind, str) else None
    if kind == "token[]":
        return tuple(value) if isinstance(value, Vt.TokenArray) else None
    return None if isinstance(value, str) or not hasattr(value, "__len__") else _array(value, kind)


def _array(value: Any, kind: str) -> np.ndarray | None:
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        return None
    if not kind.endswith("[]"):
        return array if array.shape == (3,) else None
    if array.size == 0:
        return array
    vectors = kind in ("double3[]", "point3f[]", "vector3f[]")
    return array if array.ndim == (2 if vectors else 1) and (not vectors or array.shape[1] == 3) else None

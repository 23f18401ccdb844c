"""Optional records of a prim: initial velocity field, prescribed motion and rotation, domain of fluids."""

from __future__ import annotations

import dataclasses
from typing import Any

from warp_mps.errors import InputError
from warp_mps.scene import (
    VELOCITY_FIELD_PARTS,
    HarmonicMotion,
    HarmonicRotation,
    TableMotion,
    TableRotation,
    Vector,
    VelocityField,
)
from warp_mps.usd.case.prim_values import Values


def velocity_field(values: Values) -> VelocityField | None:
    """The initial velocity that varies along a body, None if it has none."""
    fields = values.fields("velocity_field")
    if "kind" not in fields:
        if fields:
            raise InputError(
                values.path, f"mps:velocityField:{next(iter(fields))}", "has no effect without mps:velocityField"
            )
        return None
    for part in VELOCITY_FIELD_PARTS[fields["kind"]]:
        if part not in fields:
            raise InputError(values.path, f"mps:velocityField:{part}", "is missing: mps:velocityField needs it")
    return values.record(VelocityField, "velocity_field", fields)


def domain(values: Values) -> tuple[Vector, Vector] | None:
    """Lowest and highest corner of the region of fluids that is computed."""
    low, high = (values.get(f"mps:domain{corner}") for corner in ("Low", "High"))
    for corner, own, other in (("Low", low, high), ("High", high, low)):
        if own is None and other is not None:
            raise InputError(values.path, f"mps:domain{corner}", "is missing: a domain has two corners")
    return None if low is None else (low, high)


def motion(values: Values) -> HarmonicMotion | TableMotion | None:
    """The prescribed displacement of a support or a wall, None if it has none."""
    given = values.fields("motion")
    kind = _kind(values, "motion", given, (HarmonicMotion, TableMotion), "displacements")
    return values.record(kind, "motion", given) if kind else None


def rotation(values: Values) -> HarmonicRotation | TableRotation | None:
    """The prescribed rotation of a wall, None if it has none."""
    given = values.fields("rotation")
    kind = _kind(values, "rotation", given, (HarmonicRotation, TableRotation), "angles")
    if kind is None:
        if given:
            reason = "is missing, and so is a table of angles: a rotation needs one of them"
            raise InputError(values.path, "mps:rotation:amplitude", reason)
        return None
    if values.frame.dimension == 3 and "axis" not in given:
        raise InputError(values.path, "mps:rotation:axis", "is missing: the rotation needs it")
    if values.frame.dimension == 2 and "axis" in given:
        # in the plane angles are about its normal, and the axis only gives their sign
        (along,) = given.pop("axis")
        if along == 0.0:
            raise InputError(values.path, "mps:rotation:axis", "has no length")
        part = "amplitude" if kind is HarmonicRotation else "angles"
        given[part] = given[part] if along > 0.0 else -given[part]
    return values.record(kind, "rotation", given)


def _kind(values: Values, name: str, given: dict[str, Any], kinds: tuple[type, type], rows: str) -> Any:
    """The class, harmonic or table, that the given fields belong to; all its required fields must be given."""
    fields = [{field.name: field.default for field in dataclasses.fields(kind)} for kind in kinds]
    own = [{*fields[0]} - {*fields[1]}, {*fields[1]} - {*fields[0]}]
    harmonic, table = (bool(names & {*given}) for names in own)
    if harmonic and table:
        reason = f"is given beside a table of {rows}: a {name} is one or the other"
        raise InputError(values.path, f"mps:{name}:amplitude", reason)
    if not harmonic and not table:
        return None
    chosen = 0 if harmonic else 1
    for part, default in fields[chosen].items():
        if default is dataclasses.MISSING and part not in given:
            raise InputError(values.path, f"mps:{name}:{part}", f"is missing: the {name} needs it")
    return kinds[chosen]

"""Absurd values for attributes of a stage, drawn at random."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Sdf

Random = np.random.Generator

WILD = (*(float("nan"), float("inf"), float("-inf"), 0.0, -0.0, -1.0, 1.0, 1e-3, 1e3, 1e-12, 1e12, -1e12, 1e-30, 1e30),
        *(1e-300, 1e300, -1e300, 1.7e308, 5e-324, 2.0**31, 2.0**53))  # fmt: skip
WHOLE = (0, -1, 1, 2, 3, 7, 1000, 10**6, 2**31 - 1, -(2**31))
WORDS = (
    *("", "x", "xyz", "xx", "zyx", "body", "wall", "fluid", "probe", "none", "static", "implicit", "springs", "twist"),
    *("a b", "contact_force", "pressure", "section_moment", "standing_wave", "cubic", "stress", "frequency", "X", "Hz"),
    *("\u00e9t\u00e9", "long " * 2000, "two\nlines", "[bold]", "%s{}", "harmonic_phase"),
)
TYPES = (
    *("Cube", "Sphere", "Cylinder", "Mesh", "Points", "Xform", "Scope", "Material", "PhysicsScene", "Camera", "Cone"),
    *("BasisCurves", "PointInstancer", "Capsule", "", "Nonsense", "PhysicsRigidBodyAPI", "Plane", "SkelRoot"),
)
KINDS = (
    *("double", "float", "int", "bool", "token", "string", "asset", "double3", "float3", "vector3f", "double2", "half"),
    *("double[]", "int[]", "double3[]", "token[]", "string[]", "point3f[]", "matrix4d", "quatd", "uint64", "timecode"),
)


def pick(random: Random, items: Any) -> Any:
    """One of some items."""
    items = list(items)
    return items[int(random.integers(len(items)))]


def is_numeric(value: Any) -> bool:
    """Whether a value is a number or a vector of numbers."""
    return isinstance(value, int | float | Gf.Vec3d | Gf.Vec3f) and not isinstance(value, bool)


def wild_value(value: Any, random: Random) -> Any:
    """A wild number or vector of the type of a value."""
    if isinstance(value, int):
        return pick(random, WHOLE)
    if isinstance(value, float):
        return pick(random, (*WILD, *(value * factor for factor in (-1.0, 0.1, 0.5, 2.0, 10.0))))
    parts = list(value)
    parts[int(random.integers(len(parts)))] = pick(random, WILD)
    return type(value)(*parts)


def any_value(kind: str, random: Random) -> Any:
    """Some value of a type."""
    name = Sdf.ValueTypeNames.Find(kind)
    example = name.scalarType.defaultValue if name.isArray else name.defaultValue
    if isinstance(example, str):
        one = pick(random, WORDS)
    elif is_numeric(example):
        one = wild_value(example, random)
    else:
        one = example
    if not name.isArray:
        return int(one) % 2**31 if kind == "uint64" else one
    array = type(name.defaultValue)
    try:
        return array([one] * pick(random, (0, 1, 2, 3, 1000)))
    except (TypeError, OverflowError):
        return array()

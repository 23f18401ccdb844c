"""What a prim says itself: values that are the same at every time, on attributes where attributes are meant.

USD answers a question at the default time with the default or the fallback, even where the file holds time samples or
a spline, and leaves out a property whose kind is another than the schema's. Both would be read wrongly in silence.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Sdf, Usd

from warp_mps.errors import InputError

# a value that does not vary in time is the same at all times but USD's default time, where samples do not count
ANY_TIME = Usd.TimeCode.EarliestTime()


def is_given(prim: Usd.Prim, name: str) -> bool:
    """Whether a prim gives an attribute a value of its own.

    Raises:
        InputError: It gives a relationship of that name.
    """
    if not prim.HasProperty(name):
        return False
    check_kind(prim, name, Sdf.AttributeSpec)
    attribute = prim.GetAttribute(name)
    return bool(attribute) and (attribute.HasAuthoredValue() or attribute.HasAuthoredConnections())


def check_kind(prim: Usd.Prim, name: str, kind: type[Sdf.PropertySpec]) -> None:
    """Refuse a relationship where an attribute is meant, and an attribute where a relationship is.

    Args:
        prim: The prim.
        name: Name of the property.
        kind: `Sdf.AttributeSpec` or `Sdf.RelationshipSpec`.

    Raises:
        InputError: A layer gives the other one.
    """
    written = (spec.properties.get(name) for spec in prim.GetPrimStack())
    if any(spec is not None and not isinstance(spec, kind) for spec in written):
        other = "an attribute, not a relationship (rel)" if kind is Sdf.AttributeSpec else "a relationship (rel)"
        raise InputError(str(prim.GetPath()), name, f"must be {other}")


def constant(attribute: Usd.Attribute) -> Any:
    """Value of an attribute, which must be the same at every time; None if it has none.

    Raises:
        InputError: It varies in time, its default is another value than its one sample, or it is connected to another
            attribute, whose value USD does not pass on.
    """
    path, name = str(attribute.GetPrim().GetPath()), attribute.GetName()
    if attribute.ValueMightBeTimeVarying():
        raise InputError(path, name, "must have a value that does not vary in time: give one, without samples")
    if attribute.HasAuthoredConnections():
        (other, *_) = attribute.GetConnections() or [""]
        raise InputError(path, name, f"is connected to {other}, which is not followed: give its value instead")
    value = attribute.Get(ANY_TIME)
    sampled = attribute.GetResolveInfo().GetSource() == Usd.ResolveInfoSourceTimeSamples
    has_default = attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource() == Usd.ResolveInfoSourceDefault
    if sampled and has_default and not np.array_equal(np.asarray(attribute.Get()), np.asarray(value)):
        raise InputError(path, name, "has a default and a time sample that differ: leave one of them out")
    return value

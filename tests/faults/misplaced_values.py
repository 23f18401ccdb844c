"""Changes of a stage that say something where USD does not look, or in another way than is meant."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdGeom

from tests.faults.mutations import Change, attributes, pick, prims
from tests.faults.wild_values import Random, is_numeric


def spline(layer: Sdf.Layer, random: Random) -> str:
    """A number is a spline, beside its default or without."""
    numbers = attributes(layer, lambda value: isinstance(value, float))
    spec = pick(random, numbers)
    knot, kind = random.normal(), spec.typeName
    path, prim = spec.path, layer.GetPrimAtPath(spec.path.GetPrimPath())
    text = f'#usda 1.0\nover "x"\n{{\n    {kind} a.spline = {{ 1: {knot}, 2: {2 * knot} }}\n}}\n'
    other = Sdf.Layer.CreateAnonymous(".usda")
    other.ImportFromString(text)
    default = spec.default
    del prim.properties[spec.name]
    Sdf.CopySpec(other, Sdf.Path("/x.a"), layer, path)
    if random.random() < 0.5:
        layer.GetAttributeAtPath(path).default = default
    return f"{path} is a spline"


def connection(layer: Sdf.Layer, random: Random) -> str:
    """An attribute is connected to another."""
    one, other = pick(random, attributes(layer)), pick(random, attributes(layer))
    one.connectionPathList.explicitItems = [other.path]
    return f"{one.path} is connected to {other.path}"


def relationship_for_attribute(layer: Sdf.Layer, random: Random) -> str:
    """A relationship has the name of an attribute."""
    spec = pick(random, attributes(layer))
    prim, name = layer.GetPrimAtPath(spec.path.GetPrimPath()), spec.name
    del prim.properties[name]
    Sdf.RelationshipSpec(prim, name).targetPathList.explicitItems = [prim.path]
    return f"{prim.path}.{name} is a relationship"


def one_sample(layer: Sdf.Layer, random: Random) -> str:
    """A number stands at a time, with another default or none."""
    spec = pick(random, attributes(layer, is_numeric))
    layer.SetTimeSample(spec.path, float(random.integers(3)), spec.default)
    if random.random() < 0.5:
        spec.ClearDefaultValue()
    else:
        spec.default = spec.typeName.defaultValue
    return f"{spec.path} at a time"


def role_lost(layer: Sdf.Layer, random: Random) -> str:
    """A prim loses its role, or has it under another name."""
    spec = pick(random, [item for item in attributes(layer) if item.name == "mps:role"])
    prim, path, value = layer.GetPrimAtPath(spec.path.GetPrimPath()), spec.path, spec.default
    del prim.properties[spec.name]
    if random.random() < 0.5:
        Sdf.AttributeSpec(prim, "mps:rol", Sdf.ValueTypeNames.Token).default = value
    return f"{path} is gone"


def above(layer: Sdf.Layer, random: Random) -> str:
    """A prim stands below an instancer, an Xform that has its role, or a scale."""
    spec = pick(random, [prim for prim in prims(layer) if "mps:role" in prim.properties])
    kind = pick(random, ("PointInstancer", "Xform", "Scope", "Mesh"))
    stage = Usd.Stage.Open(layer)
    place = spec.path.GetParentPath().AppendChild("Above")
    parent = stage.DefinePrim(place, kind)
    Sdf.CopySpec(layer, spec.path, layer, place.AppendChild(spec.name))
    if kind == "Xform" and random.random() < 0.5:
        UsdGeom.Xformable(parent).AddScaleOp().Set((0.001, 0.001, 0.001))
    return f"{spec.path} again below a {kind}"


MISPLACED: dict[str, Change] = {
    "spline": spline,
    "connection": connection,
    "relationship for attribute": relationship_for_attribute,
    "one sample": one_sample,
    "role lost": role_lost,
    "prim above": above,
}

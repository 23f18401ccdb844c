"""Changes of a stage that make it absurd, each drawn at random; a change returns what it did.

They work on the layer, so that the result is still a file that USD reads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pxr import Gf, Sdf, Vt

from tests.faults.wild_values import KINDS, TYPES, WILD, WORDS, Random, any_value, is_numeric, pick, wild_value

Change = Callable[[Sdf.Layer, Random], str]

UNITS = ("metersPerUnit", "kilogramsPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond", "startTimeCode",
         "endTimeCode", "defaultPrim", "subLayers")  # fmt: skip


def prims(layer: Sdf.Layer) -> list[Sdf.PrimSpec]:
    """All prims of a layer."""
    found: list[Sdf.PrimSpec] = []
    waiting = list(layer.rootPrims)
    while waiting:
        found.append(prim := waiting.pop())
        waiting.extend(prim.nameChildren)
    return sorted(found, key=lambda prim: str(prim.path))


def attributes(layer: Sdf.Layer, good: Callable[[Any], bool] = lambda _: True) -> list[Sdf.AttributeSpec]:
    """All attributes of a layer whose value is as it should be."""
    found = [item for prim in prims(layer) for item in prim.attributes]
    return [item for item in found if item.default is not None and good(item.default)]


def relationships(layer: Sdf.Layer) -> list[Sdf.RelationshipSpec]:
    """All relationships of a layer."""
    return [item for prim in prims(layer) for item in prim.relationships]


def wrong_type(layer: Sdf.Layer, random: Random) -> str:
    """An attribute has another type."""
    spec, kind = pick(random, attributes(layer)), pick(random, KINDS)
    prim, name = layer.GetPrimAtPath(spec.path.GetPrimPath()), spec.name
    del prim.properties[name]
    new = Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Find(kind))
    new.default = new.typeName.defaultValue if random.random() < 0.3 else any_value(kind, random)
    return f"{spec.path if spec else name} is {kind}"


def wild_number(layer: Sdf.Layer, random: Random) -> str:
    """A number, or a component of a vector, is one that nobody means."""
    spec = pick(random, attributes(layer, is_numeric))
    spec.default = wild_value(spec.default, random)
    return f"{spec.path} = {spec.default}"[:200]


def wild_array(layer: Sdf.Layer, random: Random) -> str:
    """An array is empty, cut, doubled, far too long, or holds a wild number."""
    arrays = attributes(layer, lambda value: hasattr(value, "__len__") and not isinstance(value, str))
    spec = pick(random, arrays)
    value, how = list(spec.default), pick(random, ("empty", "cut", "doubled", "long", "wild", "reversed"))
    if how in ("empty", "cut", "doubled", "reversed"):
        value = {"empty": [], "cut": value[:-1], "doubled": value * 2, "reversed": value[::-1]}[how]
    elif how == "long":
        value = value[:1] * 200_000
    elif value and isinstance(value[0], int | float):
        value[int(random.integers(len(value)))] = pick(random, WILD)
    try:
        spec.default = type(spec.default)(value)
    except (TypeError, OverflowError):
        spec.default = type(spec.default)()
    return f"{spec.path} {how}"


def wild_token(layer: Sdf.Layer, random: Random) -> str:
    """A word is another."""
    spec = pick(random, attributes(layer, lambda value: isinstance(value, str)))
    spec.default = pick(random, WORDS)
    return f"{spec.path} = {spec.default[:40]!r}"


def wild_scene(layer: Sdf.Layer, random: Random) -> str:
    """The scene's own numbers, or a spacing, are absurd, given before or not."""
    names = (
        *("duration", "frameRate", "sampleRate", "timeStep", "courant", "damping", "effectiveRadius", "control"),
        *("theta", "contactStiffness", "friction", "fluidCourant", "pressureTolerance", "fluidEffectiveRadius"),
    )
    if random.random() < 0.3:
        spec = pick(random, [item for item in attributes(layer) if item.name == "mps:spacing"])
        spec.default = float(spec.default) * pick(random, (1e-4, 1e-3, 0.01, 0.1, 3.0, 10.0, 1e4))
        return f"{spec.path} = {spec.default}"
    spec = _give(_scene(layer), f"mps:{pick(random, names)}", "double", pick(random, WILD))
    return f"{spec.path} = {spec.default}"


def time_samples(layer: Sdf.Layer, random: Random) -> str:
    """An attribute varies in time, or is blocked."""
    spec = pick(random, attributes(layer))
    if random.random() < 0.3:
        spec.default = Sdf.ValueBlock()
        return f"{spec.path} blocked"
    for time in (0.0, 1.0, float("inf"))[: int(random.integers(1, 4))]:
        layer.SetTimeSample(spec.path, time, spec.default)
    if random.random() < 0.5:
        spec.ClearDefaultValue()
    return f"{spec.path} varies"


def wrong_target(layer: Sdf.Layer, random: Random) -> str:
    """A relationship leads nowhere, to itself, in a circle, to a property, or to far too many prims."""
    spec = pick(random, relationships(layer))
    own, others = spec.path.GetPrimPath(), [prim.path for prim in prims(layer)]
    one, two = pick(random, others), pick(random, others)
    choices = (
        [],
        [Sdf.Path("/Nowhere")],
        [own],
        [own.AppendProperty("size")],
        [Sdf.Path("/")],
        others,
        [one],
        [one, two],
    )
    targets = pick(random, (*choices, [spec.path]))
    spec.targetPathList.ClearEditsAndMakeExplicit()
    spec.targetPathList.explicitItems = list(dict.fromkeys(targets))
    return f"{spec.path} -> {targets}"[:200]


def extra_relationship(layer: Sdf.Layer, random: Random) -> str:
    """A prim has a relationship of another, or an attribute where a relationship belongs."""
    prim = pick(random, prims(layer))
    name = pick(random, ("mps:bondedTo", "mps:body", "mps:bodies", "mps:probe", "mps:target", "mps:movesWith",
                         "material:binding:physics", "mps:spacing", "mps:role", "mps:duration", "size"))  # fmt: skip
    if name in prim.properties:
        del prim.properties[name]
    if random.random() < 0.3:
        Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Token).default = "x"
    else:
        target = pick(random, prims(layer)).path
        Sdf.RelationshipSpec(prim, name, custom=False).targetPathList.explicitItems = [target]
    return f"{prim.path} {name}"


def extra_attribute(layer: Sdf.Layer, random: Random) -> str:
    """A prim has an attribute of the table that it need not have, with some value."""
    from warp_mps.usd.case.attributes import TABLE

    prim = pick(random, prims(layer))
    row = pick(random, [row for table in TABLE.values() for row in table.values() if row.kind != "rel"])
    value = any_value(row.kind, random)
    if row.allowed and row.kind == "token" and random.random() < 0.8:
        value = pick(random, row.allowed)
    _give(prim, row.name, row.kind, value)
    return f"{prim.path}.{row.name} = {value}"[:200]


def wrong_role(layer: Sdf.Layer, random: Random) -> str:
    """A prim has the part of another."""
    from warp_mps.usd.case.attributes import ROLES

    prim, role = pick(random, prims(layer)), pick(random, ROLES)
    _give(prim, "mps:role", "token", role)
    return f"{prim.path} is a {role}"


def wrong_prim_type(layer: Sdf.Layer, random: Random) -> str:
    """A prim is of another type, or only an over or a class."""
    prim = pick(random, prims(layer))
    if random.random() < 0.2:
        prim.specifier = pick(random, (Sdf.SpecifierOver, Sdf.SpecifierClass))
        return f"{prim.path} {prim.specifier}"
    prim.typeName = pick(random, TYPES)
    return f"{prim.path} of type {prim.typeName!r}"


def deleted(layer: Sdf.Layer, random: Random) -> str:
    """A prim or a property is gone, or inactive."""
    prim = pick(random, prims(layer))
    path = str(prim.path)
    if random.random() < 0.5 and len(prim.properties):
        name = pick(random, prim.properties.keys())
        del prim.properties[name]
        return f"{path}.{name} deleted"
    if random.random() < 0.3:
        prim.active = False
        return f"{path} inactive"
    parent = prim.nameParent if prim.nameParent else layer.pseudoRoot
    del parent.nameChildren[prim.name]
    return f"{path} deleted"


def duplicated(layer: Sdf.Layer, random: Random) -> str:
    """A prim is there twice, in the same place."""
    prim = pick(random, prims(layer))
    parent = pick(random, ("parent", "root", "itself", "other"))
    home = {"parent": prim.path.GetParentPath(), "root": Sdf.Path("/"), "itself": prim.path}.get(parent)
    home = home or pick(random, prims(layer)).path
    name = pick(random, (prim.name, f"{prim.name}_2", "C"))
    if home.HasPrefix(prim.path):
        copy = Sdf.Layer.CreateAnonymous(".usda")
        copy.TransferContent(layer)
        Sdf.CopySpec(copy, prim.path, layer, home.AppendChild(name))
    else:
        Sdf.CopySpec(layer, prim.path, layer, home.AppendChild(name))
    return f"{prim.path} again in {home} as {name}"


def renamed(layer: Sdf.Layer, random: Random) -> str:
    """A prim has another name, such as that of another."""
    prim = pick(random, prims(layer))
    names = ("time", "World", "a", "_", "e" * 5000, "\u03b1", *(other.name for other in prims(layer)))
    path, name = str(prim.path), pick(random, names)
    edit = Sdf.BatchNamespaceEdit()
    edit.Add(Sdf.NamespaceEdit.Rename(prim.path, name))
    layer.Apply(edit)
    return f"{path} renamed {name[:40]}"


def units(layer: Sdf.Layer, random: Random) -> str:
    """Units, axes and frame rates of the stage are absurd or of a wrong type."""
    name = pick(random, UNITS)
    value = pick(random, (*WILD, "Y", "X", "", "World", True, []))
    try:
        layer.pseudoRoot.SetInfo(name, value)
    except Exception:  # USD refuses some in Python
        layer.pseudoRoot.SetInfo("metersPerUnit", pick(random, WILD))
    return f"{name} = {value!r}"


def transform(layer: Sdf.Layer, random: Random) -> str:
    """A transform flattens, shears, mirrors, moves out of sight, or is not one."""
    prim = pick(random, prims(layer))
    ops = {
        "xformOp:scale": ("double3", Gf.Vec3d(*(pick(random, (1.0, 0.0, -1.0, *WILD)) for _ in range(3)))),
        "xformOp:translate": ("double3", Gf.Vec3d(*(pick(random, (0.0, 0.0, *WILD)) for _ in range(3)))),
        "xformOp:rotateXYZ": ("double3", Gf.Vec3d(*(pick(random, (0.0, 30.0, 90.0, *WILD)) for _ in range(3)))),
        "xformOp:transform": ("matrix4d", Gf.Matrix4d(*(pick(random, (0.0, 1.0, 0.3)) for _ in range(16)))),
        "xformOp:orient": ("quatd", Gf.Quatd(0, 0, 0, 0)),
        "xformOp:nonsense": ("token", "x"),
    }
    name = pick(random, ops)
    kind, value = ops[name]
    _give(prim, name, kind, value)
    orders = ([name], [name, name], [f"!invert!{name}"], [name, "xformOp:missing"], ["!resetXformStack!", name])
    order = pick(random, orders)
    _give(prim, "xformOpOrder", "token[]", Vt.TokenArray(order))
    return f"{prim.path}.{name} = {value} {order}"[:200]


def arcs(layer: Sdf.Layer, random: Random) -> str:
    """A prim is composed of itself, its parent, or a missing prim."""
    prim, other = pick(random, prims(layer)), pick(random, prims(layer))
    how = pick(random, ("reference", "payload", "inherit", "specialize", "variant", "instance", "api", "connection"))
    target = pick(random, (prim.path, other.path, prim.path.GetParentPath(), Sdf.Path("/Nowhere")))
    if how in ("reference", "payload"):
        make, arc = (prim.referenceList, Sdf.Reference) if how == "reference" else (prim.payloadList, Sdf.Payload)
        make.prependedItems.append(arc("", target if target != Sdf.Path("/") else Sdf.Path()))
    elif how in ("inherit", "specialize"):
        arcs = prim.inheritPathList if how == "inherit" else prim.specializesList
        arcs.prependedItems.append(target if target != Sdf.Path("/") else other.path)
    elif how == "variant":
        prim.SetInfo("variantSetNames", Sdf.StringListOp.CreateExplicit(["a", "a b"]))
        prim.SetInfo("variantSelection", {"a": "b"})
    elif how == "instance":
        prim.instanceable = True
    elif how == "api":
        names = ["MpsBodyAPI", "MpsSceneAPI", "NoSuchAPI", "CollectionAPI:x", "MaterialBindingAPI"]
        prim.SetInfo("apiSchemas", Sdf.TokenListOp.CreateExplicit([pick(random, names), pick(random, names)]))
    else:
        spec = pick(random, attributes(layer))
        spec.connectionPathList.explicitItems = [pick(random, (spec.path, target.AppendProperty("size")))]
    return f"{prim.path} {how} {target}"


def _scene(layer: Sdf.Layer) -> Sdf.PrimSpec:
    return next(prim for prim in prims(layer) if prim.typeName == "PhysicsScene")


def _give(prim: Sdf.PrimSpec, name: str, kind: str, value: Any) -> Sdf.AttributeSpec:
    if name in prim.properties:
        del prim.properties[name]
    spec = Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Find(kind))
    spec.default = value
    return spec


CHANGES: dict[str, Change] = {
    "attribute of wrong type": wrong_type,
    "wild number": wild_number,
    "wild array": wild_array,
    "unknown token": wild_token,
    "absurd scene": wild_scene,
    "absurd units": units,
    "time samples": time_samples,
    "wrong target": wrong_target,
    "extra relationship": extra_relationship,
    "extra attribute": extra_attribute,
    "wrong role": wrong_role,
    "prim of wrong type": wrong_prim_type,
    "deleted": deleted,
    "duplicated": duplicated,
    "renamed": renamed,
    "wild transform": transform,
    "composition": arcs,
}

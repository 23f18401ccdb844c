"""The settings of a case as plain values under names with units, for run.json and for people.

Names and units are those of the fields of the scene's dataclasses.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from warp_mps.scene import Scene
from warp_mps.scene.body_force import function_identity
from warp_mps.scene.fields import units_of
from warp_mps.shapes import Box, Shape

# given elsewhere, or of no use in results
LEFT_OUT = {"path", "name", "measurements", "remarks", "unscaled_file"}
# units of the fields of shapes
_SHAPE_UNITS = dict.fromkeys(("size", "center", "radius", "height", "inner_radius", "points", "positions"), "m")
_SHAPE_UNITS["velocities"] = "m/s"
# arrays with more numbers are given by their shape
LONGEST = 24


def scene_settings(scene: Scene) -> dict[str, Any]:
    """The settings of a case: plain numbers, texts, lists and dictionaries of them.

    Returns:
        The scene's own fields under names such as ``duration [s]``, and its bodies, materials and so on as
        dictionaries by their names. Settings that are not given, or of a method that is not used, are left out.
    """
    unused = {
        ("elasticity", "contact"): not scene.bodies,
        ("plane",): not scene.bodies or scene.dimension == 3,
        ("flow",): not scene.fluids,
        ("load_steps",): scene.analysis != "static",
        ("integrator", "courant"): scene.analysis == "static",
        ("theta",): scene.analysis == "static" or scene.integrator != "implicit",
    }
    dropped = {name for names, drop in unused.items() if drop for name in names}
    found = _fields(scene, scene.dimension)
    return {name: value for name, value in found.items() if name not in dropped}


def _fields(item: Any, dimension: int) -> dict[str, Any]:
    units = units_of(type(item), dimension) | (_SHAPE_UNITS if isinstance(item, Shape) else {})
    found = {}
    for field in dataclasses.fields(item):
        value = getattr(item, field.name)
        if field.name in LEFT_OUT or value is None or (isinstance(value, Sequence) and len(value) == 0):
            continue
        unit = units.get(field.name)
        found[f"{field.name} [{unit}]" if unit else field.name] = _plain(value, dimension)
    return found


def _plain(value: Any, dimension: int) -> Any:
    if dataclasses.is_dataclass(value):
        kind = {} if type(value).__name__ in _OBVIOUS else {"kind": type(value).__name__}
        found = _fields(value, dimension)
        if dimension == 2 and isinstance(value, Box):
            # its depth does not matter
            found |= {name: found[name][:2] for name in ("size [m]", "center [m]")}
        return {**kind, **found}
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size <= LONGEST else f"array of shape {list(value.shape)}"
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Sequence) and not isinstance(value, str):
        if all(dataclasses.is_dataclass(item) and hasattr(item, "name") for item in value):
            return {item.name: _plain(item, dimension) for item in value}
        return [_plain(item, dimension) for item in value]
    return function_identity(value) if callable(value) else value


# classes that need no mention, since the name of their field implies them
_OBVIOUS = {
    "Body",
    "BodyForce",
    "Contact",
    "Elasticity",
    "Flow",
    "Fluid",
    "Liquid",
    "Load",
    "Material",
    "Part",
    "Probe",
    "StageFrame",
    "Support",
    "VelocityField",
    "Wall",
}

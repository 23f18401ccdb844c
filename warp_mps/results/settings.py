"""The settings of a case as plain values under names with units, for run.json and for people.

Names, and their units, are those of the scene's dataclasses and of what their documentation says in brackets.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from warp_mps.scene import Scene
from warp_mps.scene.body_force import function_identity
from warp_mps.shapes import Box

# said elsewhere, or of no use to a reader of results
LEFT_OUT = {"path", "name", "measurements"}
# arrays with more numbers are given by their shape
LONGEST = 24


def scene_settings(scene: Scene) -> dict[str, Any]:
    """The settings of a case: plain numbers, texts, lists and dictionaries of them.

    Returns:
        The scene's own fields under names such as ``duration [s]``, and its bodies, materials and so on as
        dictionaries by their names; what is not given, and what a method that is not used would take, is left out.
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
    units = _units(type(item), dimension)
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


# classes that the name of their field says already
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


def _units(kind: type, dimension: int) -> dict[str, str]:
    """Units of the fields of a dataclass: the first brackets in what is said of each, in 2-D those said to be of it."""
    text = inspect.getdoc(kind) or ""
    said = dict(
        re.findall(r"^    (\w+): ((?:.*\n?)(?:        .*\n?)*)", text.partition("Attributes:")[2], re.MULTILINE)
    )
    units = {}
    for name, words in said.items():
        plane = re.search(r"2-D: \[([^\]]+)\]", words) if dimension == 2 else None
        found = plane or re.search(r"(?<!shape )\[([^\]]+)\]", words)
        if found and found[1] != "-":
            units[name] = found[1]
    return units

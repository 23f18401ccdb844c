"""The attributes of a stage that describe a case: one table, which reading, saving, overrides and the schema use."""

from __future__ import annotations

from warp_mps.errors import InputError
from warp_mps.usd import rows
from warp_mps.usd.rows import Attribute

ROLES = ("body", "part", "wall", "fluid", "support", "load", "probe", "measurement")
ROLE = "mps:role"

TABLE: dict[str, dict[str, Attribute]] = {
    part[0].role: {row.name: row for row in part}
    for part in (
        *(rows.SCENE, rows.BODY, rows.PART, rows.WALL, rows.FLUID, rows.MATERIAL, rows.LIQUID),
        *(rows.SUPPORT, rows.LOAD, rows.PROBE, rows.MEASUREMENT),
    )
}

# Fields of shapes and of the scene whose name in the stage is not in the table.
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


def stage_name(field: str) -> str:
    """Name in the stage of a field of the scene; the field itself if the stage has no such thing."""
    for table in TABLE.values():
        for row in table.values():
            if row.field == field:
                return row.name
    return _OTHER_NAMES.get(field, field)


def stage_error(error: InputError) -> InputError:
    """The same error in the words of a stage: its attribute is the one to change there."""
    return InputError(error.where, stage_name(error.attribute), error.reason)

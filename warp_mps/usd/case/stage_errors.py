"""Errors of a scene in the words of the stage that it was read from."""

from __future__ import annotations

from warp_mps.errors import InputError
from warp_mps.scene import StageFrame
from warp_mps.usd.case.attributes import TABLE
from warp_mps.usd.case.stage_attribute import StageAttribute

# names in a stage of fields of shapes and of the scene that are not in the table
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


def stage_error(error: InputError, units: StageFrame | None = None) -> InputError:
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

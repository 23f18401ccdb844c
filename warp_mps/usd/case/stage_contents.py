"""Contents of a stage as a whole: its PhysicsScene prim, units and axes, gravity."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from warp_mps.errors import InputError
from warp_mps.scene import StageFrame
from warp_mps.scene.choices import UP_AXES, PlaneName, StageAxesName
from warp_mps.usd.case.attributes import TABLE
from warp_mps.usd.case.authored import constant
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.prim_values import Values, shortest, typed
from warp_mps.usd.case.transforms import world_matrix

EARTH_GRAVITY = 9.81
# of a unit of length [m] or mass [kg]: from below an atom's to beyond a galaxy's
LARGEST_UNIT = 1e30


def physics_scene(prims: list[Usd.Prim], path: str) -> Usd.Prim:
    """The one PhysicsScene prim."""
    found = [prim for prim in prims if prim.IsA(UsdPhysics.Scene)]
    if len(found) != 1:
        names = ", ".join(str(prim.GetPath()) for prim in found)
        reason = f"there is more than one PhysicsScene prim: {names}" if found else "there is no PhysicsScene prim"
        raise InputError(path, "", reason)
    return found[0]


def frame(stage: Usd.Stage, physics: Usd.Prim) -> Frame:
    """Units and axes, and in 2-D the plane: by default the one that the up axis lies in."""
    given = str(UsdGeom.GetStageUpAxis(stage))
    up_axis = next((axis for axis in UP_AXES if axis == given), None)
    if up_axis is None:
        raise InputError("/", "upAxis", f"is {given!r}, must be Y or Z")
    first = Values(physics, "scene", Frame(StageFrame(axes="xyz"), 3))
    dimension = int(first.get("mps:dimension") or TABLE["scene"]["mps:dimension"].default)
    plane: PlaneName = first.get("mps:plane") or ("xy" if up_axis == "Y" else "xz")
    units = {"metersPerUnit": UsdGeom.GetStageMetersPerUnit(stage)}
    units["kilogramsPerUnit"] = UsdPhysics.GetStageKilogramsPerUnit(stage)
    for name, value in units.items():
        if not np.isfinite(value) or value <= 0:
            raise InputError("/", name, f"is {value:g}, must be finite and above 0")
        if not 1.0 / LARGEST_UNIT <= value <= LARGEST_UNIT:
            reason = f"is {value:g}, must be between {1.0 / LARGEST_UNIT:g} and {LARGEST_UNIT:g}"
            raise InputError("/", name, reason)
    axes: StageAxesName = plane if dimension == 2 else "xyz"
    length, mass = units.values()
    return Frame(StageFrame(axes=axes, up_axis=up_axis, meters_per_unit=length, kilograms_per_unit=mass), dimension)


def gravity(physics: Usd.Prim, frame: Frame) -> tuple[float, ...]:
    """Gravity by the rules of UsdPhysics: a zero direction is down, a negative magnitude is that of the Earth."""
    row, path = TABLE["scene"]["physics:gravityMagnitude"], str(physics.GetPath())
    given = UsdPhysics.Scene(physics).GetGravityMagnitudeAttr()
    # the default is minus infinity
    magnitude = typed(given, row.kind) if constant(given) != -np.inf else -np.inf
    magnitude = EARTH_GRAVITY / frame.stage.meters_per_unit if magnitude < 0 else magnitude
    attribute = UsdPhysics.Scene(physics).GetGravityDirectionAttr()
    direction = np.array([shortest(part) for part in typed(attribute, TABLE["scene"][attribute.GetName()].kind)])
    if not direction.any():
        direction = -np.eye(3)["XYZ".index(frame.stage.up_axis)]
    vector = magnitude * direction / np.linalg.norm(direction)
    return tuple(frame.vectors_to_scene(vector, row, path).tolist())


def origin(prim: Usd.Prim, frame: Frame) -> tuple[float, ...]:
    """The world origin of a prim, in the scene."""
    origin = frame.placement(world_matrix(prim))[:3, 3]
    if frame.dimension == 2 and abs(origin[2]) > 1e-6 * frame.stage.meters_per_unit:
        reason = f"the probe lies {abs(origin[2]):g} m out of the plane {frame.stage.axes} of this 2-D scene"
        raise InputError(str(prim.GetPath()), "xformOpOrder", reason)
    return tuple(origin[: frame.dimension].tolist())

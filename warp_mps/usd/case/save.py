"""Saving a scene as a USD stage that reads back as the same scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from warp_mps import scene as sc
from warp_mps.errors import InputError
from warp_mps.scene.components import component_names
from warp_mps.scene.validation.rules import place
from warp_mps.shapes import Points
from warp_mps.usd import register_schema
from warp_mps.usd.case.attributes import ROLE, ROLES, TABLE
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.open_stage import quiet
from warp_mps.usd.case.save_shape import lattice_axes, save_shape
from warp_mps.usd.case.stage_attribute import StageAttribute

ROOT = "/World"
# scopes of the items that relationships refer to, by their roles
_SCOPES = {"body": "Bodies", "wall": "Walls", "probe": "Probes"}
SUFFIXES = (".usd", ".usda", ".usdc")


def save_stage(scene: sc.Scene, path: str | Path) -> None:
    """Save a scene as a stage, in the units and axes of `scene.frame`.

    Points of meshes and ready-made particles, densities and gravity are single precision in USD; all else is double.

    Args:
        scene: The scene.
        path: File to write; its suffix says which format.

    Raises:
        InputError: The suffix is not one of `SUFFIXES`, the file cannot be written, a name is not a valid prim name, or
            there are body forces.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        raise InputError(str(path), "", f"must end in one of: {', '.join(SUFFIXES)}")
    for force in scene.body_forces:
        reason = "is a function, which a stage cannot hold: leave the force out, or keep the scene in Python"
        raise InputError(place(force, "body force"), "acceleration", reason)
    register_schema()
    stage = Usd.Stage.CreateInMemory()
    _Writer(stage, scene).write()
    with quiet(path):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            done = stage.GetRootLayer().Export(str(path))
        except (OSError, Tf.ErrorException):
            done = False
    if not done:
        raise InputError(str(path), "", "cannot be written")


class _Writer:
    """A stage that is being written from a scene."""

    def __init__(self, stage: Usd.Stage, scene: sc.Scene) -> None:
        self.stage, self.scene = stage, scene
        self.frame = Frame(scene.frame, scene.dimension)
        self.paths = {
            kind: {item.name: f"{ROOT}/{kind}/{item.name}" for item in items}
            for kind, items in (
                *(("Bodies", scene.bodies), ("Walls", scene.walls), ("Fluids", scene.fluids)),
                *(("Supports", scene.supports), ("Probes", scene.probes)),
            )
        }
        self.materials = _material_names(scene)

    def write(self) -> None:
        stage, frame = self.stage, self.scene.frame
        UsdGeom.SetStageMetersPerUnit(stage, frame.meters_per_unit)
        UsdPhysics.SetStageKilogramsPerUnit(stage, frame.kilograms_per_unit)
        UsdGeom.SetStageUpAxis(stage, frame.up_axis)
        stage.GetRootLayer().documentation = self.scene.description
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
        self._scene()
        for body in self.scene.bodies:
            self._body(body)
            for part in body.parts:
                self._part(part, body)
        for wall in self.scene.walls:
            self._wall(wall)
        for fluid in self.scene.fluids:
            self._fluid(fluid)
        for support in self.scene.supports:
            self._support(support)
        for number, load in enumerate(self.scene.loads):
            self._load(load, number)
        for probe in self.scene.probes:
            self._probe(probe)
        for number, measurement in enumerate(self.scene.measurements):
            self._measurement(measurement, number)

    def _scene(self) -> None:
        scene, path = self.scene, f"{ROOT}/PhysicsScene"
        physics = UsdPhysics.Scene.Define(self.stage, path)
        gravity_si = scene.gravity_vector
        gravity = self.frame.vectors_to_stage(gravity_si, _GRAVITY)
        magnitude = float(np.linalg.norm(gravity))
        physics.CreateGravityMagnitudeAttr(magnitude)
        physics.CreateGravityDirectionAttr(Gf.Vec3f(*(gravity / magnitude if magnitude else gravity).tolist()))
        flat = {"mps:plane": scene.frame.axes} if scene.dimension == 2 else {"mps:planeModel": None}
        corners = dict(zip(("mps:domainLow", "mps:domainHigh"), scene.flow.domain or (None, None), strict=True))
        self._author(physics.GetPrim(), "scene", scene, {**flat, **corners})

    def _body(self, body: sc.Body) -> None:
        prim = self._region("Bodies", body.name, body, body.shape)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(body.material), materialPurpose="physics")
        self._author(prim, "body", body)
        self._widths(prim, body)

    def _fluid(self, fluid: sc.Fluid) -> None:
        prim = self._region("Fluids", fluid.name, fluid, fluid.shape)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(fluid.liquid), materialPurpose="physics")
        self._author(prim, "fluid", fluid)
        self._widths(prim, fluid)

    def _wall(self, wall: sc.Wall) -> None:
        prim = self._region("Walls", wall.name, wall, wall.shape)
        axis = {"mps:rotation:axis": (1.0,)} if wall.rotation and self.scene.dimension == 2 else {}
        self._author(prim, "wall", wall, axis)
        self._widths(prim, wall)

    def _widths(self, prim: Usd.Prim, item: sc.Body | sc.Wall | sc.Fluid) -> None:
        if isinstance(item.shape, Points):
            count = len(item.shape.positions)
            width = item.spacing / self.frame.stage.meters_per_unit
            UsdGeom.Points(prim).CreateWidthsAttr([width] * count)

    def _part(self, part: sc.Part, body: sc.Body) -> None:
        prim = self._region("Parts", part.name, part, part.region)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(part.material), materialPurpose="physics")
        self._author(prim, "part", part)
        self._relate(prim, "mps:body", "Bodies", (body.name,))

    def _material(self, material: sc.Material | sc.Liquid) -> UsdShade.Material:
        """The prim of a material, one for all that are equal, named after the first item made of it."""
        path = f"{ROOT}/Materials/{self.materials[material]}"
        if self.stage.GetPrimAtPath(path):
            return UsdShade.Material(self.stage.GetPrimAtPath(path))
        self._scope("Materials")
        shade = UsdShade.Material.Define(self.stage, path)
        UsdPhysics.MaterialAPI.Apply(shade.GetPrim())
        self._author(shade.GetPrim(), "liquid" if isinstance(material, sc.Liquid) else "material", material)
        return shade

    def _support(self, support: sc.Support) -> None:
        prim = self._region("Supports", support.name, support, support.region)
        self._author(prim, "support", support)

    def _load(self, load: sc.Load, number: int) -> None:
        name = (
            load.name if [other.name for other in self.scene.loads].count(load.name) == 1 else f"{load.name}_{number}"
        )
        prim = self._region("Loads", name, load, load.region)
        self._author(prim, "load", load)

    def _probe(self, probe: sc.Probe) -> None:
        if probe.region is not None:
            prim = self._region("Probes", probe.name, probe, probe.region)
        else:
            xform = UsdGeom.Xform.Define(self.stage, self._place("Probes", probe.name, probe))
            prim = xform.GetPrim()
            if probe.point is not None:
                xform.AddTranslateOp().Set(Gf.Vec3d(*self.frame.vectors_to_stage(probe.point, _POINT).tolist()))
        self._author(prim, "probe", probe)
        filled = next((kind for kind in ("Walls", "Fluids") if probe.body in self.paths[kind]), "Bodies")
        for kind, name in ((filled, probe.body), ("Supports", probe.support)):
            self._relate(prim, "mps:target", kind, () if name is None else (name,))

    def _measurement(self, measurement: sc.Measurement, number: int) -> None:
        name = Tf.MakeValidIdentifier(measurement.name)
        taken = self.stage.GetPrimAtPath(f"{ROOT}/Measurements/{name}")
        path = self._place("Measurements", f"{name}_{number}" if taken else name, measurement)
        prim = UsdGeom.Scope.Define(self.stage, path).GetPrim()
        prim.SetDisplayName(measurement.name)
        probe = next(probe for probe in self.scene.probes if probe.name == measurement.probe)
        names = component_names(probe.quantity, self.frame.stage.axes)
        component = {"mps:component": names[measurement.component] if names else None}
        self._author(prim, "measurement", measurement, component)

    def _region(self, kind: str, name: str, item: Any, shape: Any) -> Usd.Prim:
        return save_shape(self.stage, self._place(kind, name, item), shape, self.frame)

    def _place(self, kind: str, name: str, item: Any) -> str:
        if not Sdf.Path.IsValidIdentifier(name):
            where = item.path or f"{type(item).__name__.lower()} {name!r}"
            raise InputError(
                where, "name", f"{name!r} is not a valid prim name: use letters, digits and _, no digit first"
            )
        self._scope(kind)
        return f"{ROOT}/{kind}/{name}"

    def _scope(self, kind: str) -> None:
        UsdGeom.Scope.Define(self.stage, f"{ROOT}/{kind}")

    def _author(self, prim: Usd.Prim, role: str, item: Any, changes: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Write the attributes of an item that differ from the default.

        Args:
            prim: Its prim.
            role: Its role.
            item: A part of the scene.
            changes: Values by the attributes' names that replace those of the item's fields; None leaves one out.
        """
        prim.AddAppliedSchema(f"Mps{role.capitalize()}API")
        if role in ROLES:
            prim.CreateAttribute(ROLE, Sdf.ValueTypeNames.Token, custom=False).Set(role)
        for row in TABLE[role].values():
            value = changes.get(row.name, None if row.stage_only else _field(item, row.field))
            if value is None or _is_default(value, row):
                continue
            if row.known.refers_to:
                kind = _SCOPES[row.known.refers_to]
                self._relate(prim, row.name, kind, (value,) if isinstance(value, str) else value)
                continue
            if row.known.axes == "shape":
                value = lattice_axes(item.shape, value, self.frame)
            elif row.known.axes == "stage":
                value = "".join(self.frame.stage.axes[axis] for axis in value)
            attribute = prim.CreateAttribute(row.name, Sdf.ValueTypeNames.Find(row.kind), custom=False)
            attribute.Set(_usd_value(value, row, self.frame))

    def _relate(self, prim: Usd.Prim, name: str, kind: str, names: tuple[str, ...]) -> None:
        if names:
            prim.CreateRelationship(name, custom=False).SetTargets([self.paths[kind][other] for other in names])


def _field(item: Any, path: str) -> Any:
    """Value of a field, or of a field of a record such as ``flow.courant``; None where there is no such record."""
    for name in path.split("."):
        item = getattr(item, name, None)
    return item


def _is_default(value: Any, row: StageAttribute) -> bool:
    if isinstance(value, float | int | str | np.generic):
        return bool(value == row.default)
    return len(value) == 0


def _material_names(scene: sc.Scene) -> dict[sc.Material | sc.Liquid, str]:
    """A name for each different material and liquid."""
    items: list[sc.Body | sc.Part] = [*scene.bodies, *(part for body in scene.bodies for part in body.parts)]
    made = [(item.name, item.material) for item in items] + [(fluid.name, fluid.liquid) for fluid in scene.fluids]
    names: dict[sc.Material | sc.Liquid, str] = {}
    for owner, material in made:
        if material not in names:
            name = owner
            while name in names.values():
                name += "_"
            names[material] = name
    return names


def _usd_value(value: Any, row: StageAttribute, frame: Frame) -> Any:
    """A value of the scene in the units and along the axes of the stage."""
    if row.kind in ("double", "float"):
        return float(value) / frame.factor(row)
    if row.kind == "double[]":
        return Vt.DoubleArray.FromNumpy(np.ascontiguousarray(value, float))
    if row.kind == "double3":
        return Gf.Vec3d(*frame.vectors_to_stage(value, row).tolist())
    if row.kind == "double3[]":
        return Vt.Vec3dArray.FromNumpy(np.ascontiguousarray(frame.vectors_to_stage(value, row)))
    return value


_GRAVITY = TABLE["scene"]["physics:gravityMagnitude"]
# A point has the units and the axes of a velocity field's origin.
_POINT = TABLE["body"]["mps:velocityField:origin"]

"""Saving a scene as a USD stage that reads back as the same scene."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade

from warp_mps import scene as sc
from warp_mps.errors import InputError
from warp_mps.scene.components import component_names
from warp_mps.scene.validation.rules import place
from warp_mps.shapes import Cylinder, Points
from warp_mps.usd import register_schema
from warp_mps.usd.case.attributes import ROLE, ROLES, TABLE
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.opening import quiet
from warp_mps.usd.case.save_shape import lattice_axes, save_shape

ROOT = "/World"
SUFFIXES = (".usd", ".usda", ".usdc")


def save_stage(scene: sc.Scene, path: str | Path) -> None:
    """Save a scene as a stage, in the units and axes of `scene.frame`.

    Points of meshes and ready-made particles, densities and gravity are single precision in USD; all else is double.

    Args:
        scene: The scene.
        path: File to write; its suffix says which format.

    Raises:
        InputError: The suffix is not one of `SUFFIXES`, the file cannot be written, a name is no prim name, or there
            are body forces.
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
    with quiet():
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
        gravity_si = np.asarray(scene.gravity if len(scene.gravity) else (0.0,) * scene.dimension)
        gravity = self.frame.vectors_to_stage(gravity_si, _GRAVITY)
        magnitude = float(np.linalg.norm(gravity))
        physics.CreateGravityMagnitudeAttr(magnitude)
        physics.CreateGravityDirectionAttr(Gf.Vec3f(*(gravity / magnitude if magnitude else gravity).tolist()))
        flat = {"mps:plane": scene.frame.axes, "mps:planeModel": scene.plane} if scene.dimension == 2 else {}
        values = {
            "mps:dimension": scene.dimension,
            **flat,
            "mps:duration": scene.duration,
            "mps:frameRate": scene.frame_rate,
            "mps:sampleRate": scene.sample_rate,
            "mps:timeStep": scene.time_step,
            "mps:analysis": scene.analysis,
            "mps:loadSteps": scene.load_steps,
            "mps:integrator": scene.integrator,
            "mps:theta": scene.theta,
            "mps:courant": scene.courant,
            "mps:damping": scene.damping,
            "mps:outputs": scene.outputs,
            "mps:elasticModel": scene.elasticity.model,
            "mps:effectiveRadius": scene.elasticity.effective_radius,
            "mps:control": scene.elasticity.control,
            "mps:normalization": scene.elasticity.normalization,
            "mps:contact": scene.contact.between,
            "mps:contactStiffness": scene.contact.stiffness,
            "mps:friction": scene.contact.friction,
            **self._flow(),
        }
        self._author(physics.GetPrim(), "scene", values)

    def _flow(self) -> dict[str, Any]:
        flow = self.scene.flow
        corners = dict(zip(("mps:domainLow", "mps:domainHigh"), flow.domain or (None, None), strict=True))
        return {
            "mps:fluidScheme": flow.scheme,
            "mps:fluidEffectiveRadius": flow.effective_radius,
            "mps:negativePressure": flow.negative_pressure,
            "mps:pressureTolerance": flow.tolerance,
            "mps:fluidCourant": flow.courant,
            "mps:periodicAxes": "".join(self.frame.stage.axes[axis] for axis in flow.periodic) or None,
            **corners,
        }

    def _body(self, body: sc.Body) -> None:
        prim = self._region("Bodies", body.name, body, body.shape)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(body.material), materialPurpose="physics")
        self._author(prim, "body", self._start(body))
        self._relate(prim, "mps:bondedTo", "Bodies", body.bonded_to)
        self._widths(prim, body)

    def _fluid(self, fluid: sc.Fluid) -> None:
        prim = self._region("Fluids", fluid.name, fluid, fluid.shape)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(fluid.liquid), materialPurpose="physics")
        self._author(prim, "fluid", self._start(fluid))
        self._widths(prim, fluid)

    def _start(self, item: sc.Body | sc.Fluid) -> dict[str, Any]:
        """Lattice and initial velocity of a body or a fluid."""
        axes = lattice_axes(item.shape, item.node_axes, self.frame)
        values: dict[str, Any] = {"mps:spacing": item.spacing, "mps:nodeAxes": axes or None}
        values |= {"mps:velocity": item.velocity, "mps:angularVelocity": item.angular_velocity}
        if item.velocity_field:
            values["mps:velocityField"] = item.velocity_field.kind
            for part in ("amplitude", "rate", "axis", "origin", "length", "depth", "mode"):
                values[f"mps:velocityField:{part}"] = getattr(item.velocity_field, part)
        return values

    def _wall(self, wall: sc.Wall) -> None:
        prim = self._region("Walls", wall.name, wall, wall.shape)
        axes = lattice_axes(wall.shape, wall.node_axes, self.frame)
        values: dict[str, Any] = {"mps:spacing": wall.spacing, "mps:nodeAxes": axes or None, "mps:slip": wall.slip}
        values["mps:friction"] = wall.friction
        values |= _moving("motion", wall.motion)
        values |= _moving("rotation", wall.rotation)
        if wall.rotation and self.scene.dimension == 2:
            values["mps:rotation:axis"] = (1.0,)
        self._author(prim, "wall", values)
        self._widths(prim, wall)

    def _widths(self, prim: Usd.Prim, item: sc.Body | sc.Wall | sc.Fluid) -> None:
        if isinstance(item.shape, Points):
            count = len(item.shape.positions)
            width = item.spacing / self.frame.stage.meters_per_unit
            UsdGeom.Points(prim).CreateWidthsAttr([width] * count)

    def _part(self, part: sc.Part, body: sc.Body) -> None:
        prim = self._region("Parts", part.name, part, part.region)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(self._material(part.material), materialPurpose="physics")
        self._author(prim, "part", {})
        self._relate(prim, "mps:body", "Bodies", (body.name,))

    def _material(self, material: sc.Material | sc.Liquid) -> UsdShade.Material:
        """The prim of a material, one for all that are equal, named after what is made of it."""
        path = f"{ROOT}/Materials/{self.materials[material]}"
        if self.stage.GetPrimAtPath(path):
            return UsdShade.Material(self.stage.GetPrimAtPath(path))
        self._scope("Materials")
        shade = UsdShade.Material.Define(self.stage, path)
        density = material.density / self.frame.factor(TABLE["material"]["physics:density"])
        UsdPhysics.MaterialAPI.Apply(shade.GetPrim()).CreateDensityAttr(density)
        if isinstance(material, sc.Liquid):
            self._author(shade.GetPrim(), "liquid", {"mps:viscosity": material.viscosity})
            return shade
        values: dict[str, Any] = {"mps:youngsModulus": material.youngs_modulus}
        values |= {"mps:poissonsRatio": material.poissons_ratio, "mps:law": material.law}
        values["mps:retardationTime"] = material.retardation_time
        self._author(shade.GetPrim(), "material", values)
        return shade

    def _support(self, support: sc.Support) -> None:
        prim = self._region("Supports", support.name, support, support.region)
        values: dict[str, Any] = {"mps:holdRotation": support.hold_rotation}
        values["mps:axes"] = "".join(self.frame.stage.axes[axis] for axis in support.axes) or None
        values |= _moving("motion", support.motion)
        self._author(prim, "support", values)
        self._relate(prim, "mps:bodies", "Bodies", support.bodies)

    def _load(self, load: sc.Load, number: int) -> None:
        name = (
            load.name if [other.name for other in self.scene.loads].count(load.name) == 1 else f"{load.name}_{number}"
        )
        prim = self._region("Loads", name, load, load.region)
        values = {f"mps:{part}": getattr(load, part) for part in ("force", "acceleration", "frequency", "phase")}
        self._author(prim, "load", values)
        self._relate(prim, "mps:bodies", "Bodies", load.bodies)

    def _probe(self, probe: sc.Probe) -> None:
        if probe.region is not None:
            prim = self._region("Probes", probe.name, probe, probe.region)
        else:
            xform = UsdGeom.Xform.Define(self.stage, self._place("Probes", probe.name, probe))
            prim = xform.GetPrim()
            if probe.point is not None:
                xform.AddTranslateOp().Set(Gf.Vec3d(*self.frame.vectors_to_stage(probe.point, _POINT).tolist()))
        self._author(prim, "probe", {"mps:quantity": probe.quantity, "mps:about": probe.about})
        filled = next((kind for kind in ("Walls", "Fluids") if probe.body in self.paths[kind]), "Bodies")
        self._relate(prim, "mps:movesWith", "Walls", () if probe.moves_with is None else (probe.moves_with,))
        for kind, name in ((filled, probe.body), ("Supports", probe.support)):
            self._relate(prim, "mps:target", kind, () if name is None else (name,))

    def _measurement(self, measurement: sc.Measurement, number: int) -> None:
        name = Tf.MakeValidIdentifier(measurement.name)
        taken = self.stage.GetPrimAtPath(f"{ROOT}/Measurements/{name}")
        path = self._place("Measurements", f"{name}_{number}" if taken else name, measurement)
        prim = UsdGeom.Scope.Define(self.stage, path).GetPrim()
        prim.SetDisplayName(measurement.name)
        parts = ("measure", "unit", "reference", "source", "start", "end", "frequency", "at")
        values = {f"mps:{part}": getattr(measurement, part) for part in parts}
        probe = next(probe for probe in self.scene.probes if probe.name == measurement.probe)
        names = component_names(probe.quantity, self.frame.stage.axes)
        values["mps:component"] = names[measurement.component] if names else None
        self._author(prim, "measurement", values)
        self._relate(prim, "mps:probe", "Probes", (measurement.probe,))

    def _region(self, kind: str, name: str, item: Any, shape: Any) -> Usd.Prim:
        prim = save_shape(self.stage, self._place(kind, name, item), shape, self.frame)
        if isinstance(shape, Cylinder) and shape.inner_radius > 0:
            row = TABLE["body"]["mps:innerRadius"]
            bore = prim.CreateAttribute(row.name, Sdf.ValueTypeNames.Find(row.kind), custom=False)
            bore.Set(_usd_value(shape.inner_radius, row, self.frame))
        return prim

    def _place(self, kind: str, name: str, item: Any) -> str:
        if not Sdf.Path.IsValidIdentifier(name):
            where = item.path or f"{type(item).__name__.lower()} {name!r}"
            raise InputError(where, "name", f"{name!r} is no prim name: use letters, digits and _, no digit first")
        self._scope(kind)
        return f"{ROOT}/{kind}/{name}"

    def _scope(self, kind: str) -> None:
        UsdGeom.Scope.Define(self.stage, f"{ROOT}/{kind}")

    def _author(self, prim: Usd.Prim, role: str, values: dict[str, Any]) -> None:
        """Write the values that are not None and differ from the default."""
        prim.AddAppliedSchema(f"Mps{role.capitalize()}API")
        if role in ROLES:
            prim.CreateAttribute(ROLE, Sdf.ValueTypeNames.Token, custom=False).Set(role)
        for name, value in values.items():
            row = TABLE[role][name]
            if value is None or (value == row.default if isinstance(value, float | int | str) else not len(value)):
                continue
            attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(row.kind), custom=False)
            attribute.Set(_usd_value(value, row, self.frame))

    def _relate(self, prim: Usd.Prim, name: str, kind: str, names: tuple[str, ...]) -> None:
        if names:
            prim.CreateRelationship(name, custom=False).SetTargets([self.paths[kind][other] for other in names])


def _moving(kind: str, motion: Any) -> dict[str, Any]:
    """Attributes of a motion or a rotation; what it has, by the names of its fields."""
    return {f"mps:{kind}:{item.name}": getattr(motion, item.name) for item in fields(motion)} if motion else {}


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


def _usd_value(value: Any, row: Any, frame: Frame) -> Any:
    if row.kind == "double":
        return float(value) / frame.factor(row)
    if row.kind == "double[]":
        return [float(number) for number in value]
    if row.kind == "double3":
        return Gf.Vec3d(*frame.vectors_to_stage(value, row).tolist())
    if row.kind == "double3[]":
        return [Gf.Vec3d(*vector) for vector in frame.vectors_to_stage(value, row).tolist()]
    return value


_GRAVITY = TABLE["scene"]["physics:gravityMagnitude"]
# A point has the units and the axes of a velocity field's origin.
_POINT = TABLE["body"]["mps:velocityField:origin"]

"""Reading a scene from a USD stage: units and axes are settled here, and every error names a prim and an attribute."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Tf, Usd, UsdShade

from warp_mps.errors import InputError
from warp_mps.scene import (
    Body,
    Contact,
    Elasticity,
    Flow,
    Fluid,
    Liquid,
    Load,
    Material,
    Measurement,
    Part,
    Probe,
    Scene,
    Support,
    Wall,
)
from warp_mps.scene.components import component_names
from warp_mps.scene.filling_level import below_level
from warp_mps.shapes import Points, Shape, check_spacing, particle_count
from warp_mps.usd.case import motions, roles, stage_contents
from warp_mps.usd.case.attributes import ROLE
from warp_mps.usd.case.authored import constant, is_given
from warp_mps.usd.case.composites import read_region
from warp_mps.usd.case.diagnostics import reason_of
from warp_mps.usd.case.geometry import geometry_of, has_shape
from warp_mps.usd.case.open_stage import open_stage, quiet
from warp_mps.usd.case.prim_values import Values
from warp_mps.usd.case.stage_errors import stage_error
from warp_mps.usd.case.stage_remarks import stage_remarks

# roles of the items that are filled with particles
FILLED = ("body", "wall", "fluid")


def read_stage(path: str | Path, *, overrides: Mapping[str, str] | None = None, allow_external: bool = False) -> Scene:
    """Read the scene that a stage describes.

    Args:
        path: File of the stage.
        overrides: Texts of attribute values by ``/Prim.attribute`` that replace the stage's own for this reading, in
            the notation of a .usda file.
        allow_external: Whether the stage may refer to files outside its folder.

    Returns:
        The scene, in SI units and its own axes.

    Raises:
        InputError: Something in the stage is missing or not allowed; it names the prim and the attribute.
    """
    stage = open_stage(path, overrides=overrides, allow_external=allow_external)
    # numbers that are too large for a computer are refused as such wherever they come out
    with quiet(path), np.errstate(all="ignore"):
        units = None
        try:
            reader = _Reader(stage, str(path))
            units = reader.frame.stage
            scene = reader.scene(Path(path).stem)
            for item in scene.filled:
                _check_lattice(item, scene.dimension)
        except InputError as error:
            raise stage_error(error, units) from None
        except (Tf.ErrorException, UnicodeDecodeError) as error:
            raise InputError(str(path), "", f"cannot be read: {reason_of(error)}") from None
    return scene


def _check_lattice(body: Body | Wall | Fluid, dimension: int) -> None:
    """Refuse a body that cannot be filled with particles, while its prim and attributes are known."""
    if isinstance(body.shape, Points):
        check_spacing(body.shape, body.spacing, dimension, body.path)
    particle_count(body.shape, body.spacing, dimension, body.node_axes, where=body.path)


class _Reader:
    """A stage, its parts by role and the names they take in the scene."""

    def __init__(self, stage: Usd.Stage, path: str) -> None:
        self.stage = stage
        prims = list(stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
        self.physics = stage_contents.physics_scene(prims, path)
        self.parts = roles.by_role(prims)
        if not self.parts["body"] and not self.parts["fluid"]:
            raise InputError(path, "", f'needs a body or a fluid: no prim has {ROLE} = "body" or "fluid"')
        self.names = {role: roles.unique_names(prims) for role, prims in self.parts.items()}
        self.names["measurement"] = roles.measurement_names(self.parts["measurement"])
        # bodies, walls and fluids stand side by side in results
        filled = roles.unique_names([prim for role in FILLED for prim in self.parts[role]])
        for role in FILLED:
            self.names[role] = {path: filled[path] for path in self.names[role]}
        self.frame = stage_contents.frame(stage, self.physics)

    def scene(self, name: str) -> Scene:
        values = self._values(self.physics, "scene")
        probes = {probe.name: probe for probe in map(self._probe, self.parts["probe"])}
        bodies = tuple(self._body(prim) for prim in self.parts["body"])
        walls = tuple(self._wall(prim) for prim in self.parts["wall"])
        fluids = tuple(self._fluid(prim) for prim in self.parts["fluid"])
        filled: tuple[Body | Wall | Fluid, ...] = (*bodies, *walls, *fluids)
        shapes = [item.shape for item in filled]
        parts = [prim for found in self.parts.values() for prim in found]
        return Scene(
            name=name,
            description=self.stage.GetRootLayer().documentation,
            gravity=stage_contents.gravity(self.physics, self.frame),
            bodies=bodies,
            walls=walls,
            fluids=fluids,
            supports=tuple(self._support(prim) for prim in self.parts["support"]),
            loads=tuple(self._load(prim) for prim in self.parts["load"]),
            probes=tuple(probes.values()),
            measurements=tuple(self._measurement(prim, probes) for prim in self.parts["measurement"]),
            elasticity=values.record(Elasticity, "elasticity", values.fields("elasticity")),
            contact=values.record(Contact, "contact", values.fields("contact")),
            flow=values.record(Flow, "flow", {"domain": motions.domain(values), **values.fields("flow")}),
            stage=self.frame.stage,
            path=values.path,
            remarks=tuple(stage_remarks(self.stage, parts, shapes, self.frame)),
            **{**values.fields(), "dimension": self.frame.dimension},
        )

    def _body(self, prim: Usd.Prim) -> Body:
        values = self._values(prim, "body")
        return Body(
            name=self._name(prim, "body"),
            shape=self._region(values),
            material=self._material(prim),
            parts=tuple(self._part(part) for part in self.parts["part"] if self._part_of(part) == values.path),
            velocity_field=motions.velocity_field(values),
            path=values.path,
            **values.fields(),
        )

    def _wall(self, prim: Usd.Prim) -> Wall:
        values = self._values(prim, "wall")
        return Wall(
            name=self._name(prim, "wall"),
            shape=self._region(values),
            motion=motions.motion(values),
            rotation=motions.rotation(values),
            path=values.path,
            **values.fields(),
        )

    def _fluid(self, prim: Usd.Prim) -> Fluid:
        values = self._values(prim, "fluid")
        return Fluid(
            name=self._name(prim, "fluid"),
            shape=self._filled_to_level(values),
            liquid=self._liquid(prim),
            velocity_field=motions.velocity_field(values),
            path=values.path,
            **values.fields(),
        )

    def _liquid(self, prim: Usd.Prim) -> Liquid:
        """The liquid that is bound to a fluid, water by default."""
        bound, _ = UsdShade.MaterialBindingAPI(geometry_of(prim)).ComputeBoundMaterial("physics")
        given: dict[str, Any] = {"path": str(prim.GetPath())}
        if bound:
            values = self._values(bound.GetPrim(), "liquid")
            given = {"path": values.path, **values.fields()}
        return Liquid(**{**given, **self._own_density(prim)})

    def _part(self, prim: Usd.Prim) -> Part:
        values = self._values(prim, "part")
        return Part(
            name=self._name(prim, "part"),
            region=self._region(values),
            material=self._material(prim),
            path=values.path,
            **values.fields(),
        )

    def _part_of(self, prim: Usd.Prim) -> str:
        """Path of the body that a part belongs to."""
        values = self._values(prim, "part")
        if len(values.items("mps:body", "body")) != 1:
            raise InputError(values.path, "mps:body", "must refer to one body")
        return values.targets("mps:body")[0]

    def _material(self, prim: Usd.Prim) -> Material:
        bound, _ = UsdShade.MaterialBindingAPI(geometry_of(prim)).ComputeBoundMaterial("physics")
        if not bound:
            raise InputError(str(prim.GetPath()), "material:binding:physics", "is missing: bind a material")
        values = self._values(bound.GetPrim(), "material")
        own = self._own_density(prim)
        return Material(path=values.path, **values.fields(without=own), **own)

    def _own_density(self, prim: Usd.Prim) -> dict[str, Any]:
        """Density that the body, or its geometry, gives itself; in UsdPhysics zero means that it does not."""
        for owner in (prim, geometry_of(prim)):
            values = Values(owner, "material", self.frame)
            if is_given(owner, "physics:mass") and constant(owner.GetAttribute("physics:mass")):
                raise InputError(values.path, "physics:mass", "is not read: give the density, physics:density, instead")
            density = values.get("physics:density") if values.given("physics:density") else 0.0
            if density:
                return {"density": density}
        return {}

    def _support(self, prim: Usd.Prim) -> Support:
        values = self._values(prim, "support")
        return Support(
            name=self._name(prim, "support"),
            region=self._region(values),
            motion=motions.motion(values),
            path=values.path,
            **values.fields(),
        )

    def _load(self, prim: Usd.Prim) -> Load:
        values = self._values(prim, "load")
        return Load(name=self._name(prim, "load"), region=self._region(values), path=values.path, **values.fields())

    def _probe(self, prim: Usd.Prim) -> Probe:
        values = self._values(prim, "probe")
        place: dict[str, Any] = {"point": None}
        targets = values.targets("mps:target")
        if targets:
            place = self._target(values, targets)
        elif has_shape(prim):
            place = {"region": self._region(values)}
        else:
            place = {"point": stage_contents.origin(prim, self.frame)}
        return Probe(name=self._name(prim, "probe"), path=values.path, **place, **values.fields())

    def _target(self, values: Values, targets: list[str]) -> dict[str, str]:
        for role, field in (*((role, "body") for role in FILLED), ("support", "support")):
            if len(targets) == 1 and targets[0] in self.names[role]:
                return {field: self.names[role][targets[0]]}
        raise InputError(values.path, "mps:target", "must refer to one body, wall, fluid or support")

    def _measurement(self, prim: Usd.Prim, known: Mapping[str, Probe]) -> Measurement:
        values = self._values(prim, "measurement")
        fields = values.fields()
        return Measurement(
            name=self._name(prim, "measurement"),
            component=self._component(values, known[fields["probe"]].quantity),
            path=values.path,
            **fields,
        )

    def _component(self, values: Values, quantity: str) -> int:
        """Number of the component that is named, the first by default."""
        name, names = values.get("mps:component"), component_names(quantity, self.frame.stage.axes)
        if name is None:
            return 0
        if name not in names:
            known = f"must be one of: {', '.join(names)}" if names else f"but {quantity} has one component only"
            raise InputError(values.path, "mps:component", f"is {name!r}, {known}")
        return names.index(name)

    def _values(self, prim: Usd.Prim, role: str) -> Values:
        values = Values(prim, role, self.frame, self.names)
        values.check_names()
        return values

    def _region(self, values: Values) -> Shape:
        return read_region(values.prim, self.frame)

    def _filled_to_level(self, values: Values) -> Shape:
        """The shape of a fluid, below its level if it has one."""
        shape, level = self._region(values), values.get("mps:fillLevel")
        if level is None:
            return shape
        up, axes = self.frame.stage.up_axis.lower(), self.frame.stage.axes
        if up not in axes:
            raise InputError(
                values.path, "mps:fillLevel", f"is along the up axis, {up}, which is not in the plane {axes}"
            )
        return below_level(shape, level, axes.index(up), values.path)

    def _name(self, prim: Usd.Prim, role: str) -> str:
        return self.names[role][str(prim.GetPath())]

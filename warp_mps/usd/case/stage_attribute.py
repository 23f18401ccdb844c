"""One attribute of a stage, and the attributes that no single field of the scene gives."""

from __future__ import annotations

import dataclasses
from typing import Any

from warp_mps.scene.choices import PLANES
from warp_mps.scene.fields import UNITS, Attribute, Unit


@dataclasses.dataclass(frozen=True, kw_only=True)
class StageAttribute:
    """One attribute, or relationship, of a stage.

    Attributes:
        name: Name in the stage.
        kind: Type in the stage, ``rel`` for a relationship.
        field: Field of the scene that it fills, as errors name it: in a record of its own such as ``flow.courant``.
        meaning: Its meaning, for documentation.
        known: Metadata of the field.
        default: Default value; None without one, or where it depends on the units of the stage.
        si_default: Default in SI units, where it depends on the units of the stage.
        allowed: Allowed words.
        required: Whether it must be given.
        scalar_in_plane: Whether an axial vector is a plain number in a 2-D scene.
        single: Whether a relationship has one target.
        stage_only: Whether it fills no field by itself; reading and saving treat it on their own.
    """

    name: str
    kind: str
    field: str
    meaning: str
    known: Attribute
    default: Any = None
    si_default: float | None = None
    allowed: tuple[str, ...] = ()
    required: bool = False
    scalar_in_plane: bool = False
    single: bool = False
    stage_only: bool = False

    @property
    def unit(self) -> str:
        """Unit in the stage, L the stage's length and M its mass."""
        return self._scale.stage

    @property
    def length(self) -> int:
        """Power of the stage's unit of length in its unit."""
        return self._scale.length

    @property
    def mass(self) -> int:
        """Power of the stage's unit of mass in its unit."""
        return self._scale.mass

    @property
    def _scale(self) -> Unit:
        return UNITS.get(self.known.unit, Unit(self.known.unit))

    @property
    def own(self) -> bool:
        """Whether it is this package's, not one of `UsdPhysics`."""
        return self.name.startswith("mps:")


def _stage_only(name: str, kind: str, field: str, meaning: str, **more: Any) -> StageAttribute:
    known = Attribute(name=name, unit=more.pop("unit", ""), nature=more.pop("nature", "polar"))
    return StageAttribute(name=name, kind=kind, field=field, meaning=meaning, known=known, stage_only=True, **more)


# attributes of a shape that prims of UsdGeom do not have
SHAPE = (
    _stage_only(
        *("mps:innerRadius", "double", "inner_radius"),
        "Radius of the bore of a Cylinder, less than its radius.",
        unit="m",
        default=0.0,
    ),
    _stage_only(
        *("mps:plus", "rel", "plus"),
        "Geometries (Cube, Sphere, Cylinder, Mesh) that its shape is united with.",
    ),
    _stage_only(
        *("mps:intersect", "rel", "intersect"),
        "Geometries that its shape is then reduced to: what lies in all of them is left.",
    ),
    _stage_only(*("mps:minus", "rel", "minus"), "Geometries that are then cut out of its shape."),
)
# fields of the scene that a stage holds in another form, so that no single field gives name and type
STAGE_ONLY: dict[str, tuple[StageAttribute, ...]] = {
    "scene": (
        # the axes of a StageFrame, which is known before anything can be read
        _stage_only(
            *("mps:plane", "token", "stage.axes"),
            "Plane of a 2-D scene: `xy` where y is up, `xz` where z is up, if not given.",
            allowed=PLANES,
        ),
        # UsdPhysics gives gravity as a direction and a magnitude
        _stage_only(
            *("physics:gravityDirection", "vector3f", "gravity.direction"),
            "Direction of gravity; zero points it down the up axis.",
            default=(0.0, 0.0, 0.0),
        ),
        _stage_only(
            *("physics:gravityMagnitude", "float", "gravity"),
            "Acceleration of gravity; a negative number is 9.81 m/s^2.",
            unit="m/s^2",
            default=float("-inf"),
        ),
        # two corners make one domain
        _stage_only(
            *("mps:domainLow", "double3", "flow.domain.low"),
            "Fluids: lowest corner of the region that is computed; particles that leave it are left out.",
            unit="m",
            nature="point",
        ),
        _stage_only(
            *("mps:domainHigh", "double3", "flow.domain.high"),
            "Fluids: highest corner of this region.",
            unit="m",
            nature="point",
        ),
    ),
    # the shape that is cut at it
    "fluid": (
        _stage_only(
            *("mps:fillLevel", "double", "level"),
            "Height along the up axis at which its shape is cut: the free surface. The lattice, and `node_axes`, "
            "then lie along the axes of the scene.",
            unit="m",
        ),
    ),
    # a part knows its body, a Body its parts
    "part": (_stage_only("mps:body", "rel", "body", "The body that it is a part of.", required=True),),
    # the body or the support of a Probe
    "probe": (
        _stage_only(
            *("mps:target", "rel", "target"),
            "A body, wall, fluid or support whose quantity is recorded, instead of that of a place.",
        ),
    ),
    # a number in the scene, the name of an axis in the stage
    "measurement": (
        _stage_only(
            *("mps:component", "token", "component"),
            "Component of the probe: an axis of the stage, or of a stress or strain two; its first if not given.",
            allowed=("x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz"),
        ),
    ),
}

"""Bodies, walls and fluids: the items of a scene that are filled with particles."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_mps.scene.choices import WallSlipName
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.materials import Liquid, Material
from warp_mps.scene.motions import (
    HarmonicMotion,
    HarmonicRotation,
    TableMotion,
    TableRotation,
    Vector,
    VelocityField,
)
from warp_mps.scene.record import Record
from warp_mps.shapes import Shape


@described
@dataclass(frozen=True, kw_only=True)
class Part(Record):
    """A region of a body that is made of a material of its own: a layer, a core, a stiffener."""

    name: str = field(metadata=attribute(text="label"))
    """Name, unique among the parts of the scene."""
    region: Shape
    """The body's particles whose initial position lies in this shape, faces included, are of the material; where parts
    of a body overlap, the last one counts."""
    material: Material
    """Material of the part."""
    path: str = ""
    """Where it was described, for error messages."""


@described
@dataclass(frozen=True, kw_only=True)
class Body(Record):
    """An elastic body, filled with particles on a regular lattice."""

    name: str = field(metadata=attribute(text="identifier"))
    """Name, unique in the scene and a valid USD prim name."""
    shape: Shape
    """Region that it fills."""
    material: Material
    """Its material."""
    parts: tuple[Part, ...] = ()
    """Regions of it that are made of other materials."""
    spacing: float = field(metadata=attribute("mps:spacing", unit="m", above=0.0))
    """Particle spacing l0."""
    velocity: Vector | None = field(default=None, metadata=attribute("mps:velocity", unit="m/s"))
    """Initial velocity."""
    angular_velocity: float | Vector | None = field(
        default=None, metadata=attribute("mps:angularVelocity", unit="rad/s", nature="axial")
    )
    """Initial angular velocity about the centre of mass; a number in 2-D and 3 numbers in 3-D, in a stage
    always a vector."""
    velocity_field: VelocityField | None = None
    """Initial velocity that varies along the body, added to the velocity."""
    node_axes: tuple[int, ...] = field(default=(), metadata=attribute("mps:nodeAxes", axes="shape"))
    """Axes of the shape along which the outermost particles lie on its faces; along the others they lie half a spacing
    inside."""
    bonded_to: tuple[str, ...] = field(default=(), metadata=attribute("mps:bondedTo", refers_to="body"))
    """Bodies that it is joined to: their particles are neighbours as those of one body."""
    path: str = ""
    """Where it was described, for error messages."""

    @property
    def materials(self) -> tuple[Material, ...]:
        """Its materials: its own, then those of its parts."""
        return (self.material, *(part.material for part in self.parts))


@described
@dataclass(frozen=True, kw_only=True)
class Wall(Record):
    """A rigid body that holds fluids and that elastic bodies touch, at rest or on a prescribed motion.

    A point X of it is at x = pivot + R(angle) (X - pivot) + displacement. It is filled with particles as a body is;
    walls may overlap each other, and do not touch each other.
    """

    name: str = field(metadata=attribute(text="identifier"))
    """Name, unique among bodies and walls and a valid USD prim name."""
    shape: Shape
    """Region that it fills."""
    spacing: float = field(metadata=attribute("mps:spacing", unit="m", above=0.0))
    """Particle spacing l0."""
    motion: HarmonicMotion | TableMotion | None = None
    """Prescribed displacement, None for no motion."""
    rotation: HarmonicRotation | TableRotation | None = None
    """Prescribed rotation, None for no rotation."""
    friction: float | None = field(default=None, metadata=attribute("mps:friction", minimum=0.0))
    """Coefficient of friction of bodies on it; that of the scene's contact if not given."""
    slip: WallSlipName = field(default="free", metadata=attribute("mps:slip"))
    """Boundary condition of fluids: free slip or no slip."""
    node_axes: tuple[int, ...] = field(default=(), metadata=attribute("mps:nodeAxes", axes="shape"))
    """Axes of the shape along which the outermost particles lie on its faces; along the others they lie half a spacing
    inside."""
    path: str = ""
    """Where it was described, for error messages."""

    @property
    def moves(self) -> bool:
        """Whether it has a prescribed motion or rotation."""
        return self.motion is not None or self.rotation is not None


@described
@dataclass(frozen=True, kw_only=True)
class Fluid(Record):
    """A body of liquid, filled with particles on a regular lattice.

    It may be drawn through bodies and walls, and leaves out what they take up: particles inside a solid, and particles
    that crowd the solid's (`warp_mps.particles.displaced_fluid`). A hollow hull is a solid only where its shape is:
    subtract its inside from the fluid, ``shape=sea - inside``, to keep it dry.
    """

    name: str = field(metadata=attribute(text="identifier"))
    """Name, unique in the scene and a valid USD prim name."""
    shape: Shape
    """Region that it fills at the start."""
    spacing: float = field(metadata=attribute("mps:spacing", unit="m", above=0.0))
    """Particle spacing l0; the same for all fluids of a scene."""
    liquid: Liquid = Liquid()
    """Its liquid; the same for all fluids of a scene."""
    velocity: Vector | None = field(default=None, metadata=attribute("mps:velocity", unit="m/s"))
    """Initial velocity."""
    angular_velocity: float | Vector | None = field(
        default=None, metadata=attribute("mps:angularVelocity", unit="rad/s", nature="axial")
    )
    """Initial angular velocity about the centre of mass; a number in 2-D and 3 numbers in 3-D, in a stage
    always a vector."""
    velocity_field: VelocityField | None = None
    """Initial velocity that varies in space, added to the velocity."""
    node_axes: tuple[int, ...] = field(default=(), metadata=attribute("mps:nodeAxes", axes="shape"))
    """Axes of the shape along which the outermost particles lie on its faces; along the others they lie half a spacing
    inside."""
    path: str = ""
    """Where it was described, for error messages."""

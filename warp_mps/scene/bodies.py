"""What is filled with particles: elastic bodies and their parts, walls, fluids."""

from __future__ import annotations

from dataclasses import dataclass

from warp_mps.scene.materials import Liquid, Material
from warp_mps.scene.motions import (
    HarmonicMotion,
    HarmonicRotation,
    TableMotion,
    TableRotation,
    Vector,
    VelocityField,
)
from warp_mps.shapes import Shape


@dataclass(frozen=True, kw_only=True)
class Part:
    """A region of a body that is made of a material of its own: a layer, a core, a stiffener.

    Attributes:
        name: Name, unique among the parts of the scene.
        region: The body's particles whose initial position lies in this shape, faces included, are of the material;
            where parts of a body overlap, the last one counts.
        material: What the part is made of.
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    material: Material
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Body:
    """An elastic body, filled with particles on a regular lattice.

    Attributes:
        name: Name, unique in the scene and a valid USD prim name.
        shape: Region it fills.
        material: What it is made of.
        parts: Regions of it that are made of other materials.
        spacing: Particle spacing l0 [m].
        velocity: Initial velocity [m/s].
        angular_velocity: Initial angular velocity about the centre of mass [rad/s]: a number in 2-D, 3 numbers in 3-D.
        velocity_field: Initial velocity that varies along the body, added to `velocity`.
        node_axes: Axes of the shape along which the outermost particles lie on its faces; along the others they lie
            half a spacing inside.
        bonded_to: Names of bodies that it is joined to: their particles are neighbours as if of one body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    material: Material
    parts: tuple[Part, ...] = ()
    spacing: float
    velocity: Vector | None = None
    angular_velocity: float | Vector | None = None
    velocity_field: VelocityField | None = None
    node_axes: tuple[int, ...] = ()
    bonded_to: tuple[str, ...] = ()
    path: str = ""

    @property
    def materials(self) -> tuple[Material, ...]:
        """Its materials: its own, then those of its parts."""
        return (self.material, *(part.material for part in self.parts))


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A rigid body that holds fluids and that elastic bodies touch, at rest or on a prescribed motion.

    A point X of it is at x = pivot + R(angle) (X - pivot) + displacement. It is filled with particles as a body is;
    walls may overlap each other, and do not touch each other.

    Attributes:
        name: Name, unique among bodies and walls and a valid USD prim name.
        shape: Region it fills.
        spacing: Particle spacing l0 [m].
        motion: Prescribed displacement; None is none.
        rotation: Prescribed turn; None is none.
        friction: Coefficient of friction of bodies on it [-]; None is that of `Contact`.
        slip: Whether fluid slides along it, one of `WALL_SLIPS`: ``free``, or ``no``, where it sticks.
        node_axes: Axes of the shape along which the outermost particles lie on its faces, as of a body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    spacing: float
    motion: HarmonicMotion | TableMotion | None = None
    rotation: HarmonicRotation | TableRotation | None = None
    friction: float | None = None
    slip: str = "free"
    node_axes: tuple[int, ...] = ()
    path: str = ""

    @property
    def moves(self) -> bool:
        """Whether it is ever elsewhere than it was drawn."""
        return self.motion is not None or self.rotation is not None


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """A body of liquid, filled with particles on a regular lattice.

    It may be drawn through bodies and walls, and leaves out what they take up: particles inside a solid, and particles
    nearer to one of the solid's particles than a spacing (`warp_mps.particles.displaced_fluid`). A hollow hull is a
    solid only where its shape is: subtract its inside from the fluid, ``shape=sea - inside``, to keep it dry.

    Attributes:
        name: Name, unique in the scene and a valid USD prim name.
        shape: Region that it fills at the start.
        liquid: What it is; the same for all fluids of a scene.
        spacing: Particle spacing l0 [m]; the same for all fluids of a scene.
        velocity: Initial velocity [m/s].
        angular_velocity: Initial angular velocity about the centre of mass [rad/s]: a number in 2-D, 3 numbers in 3-D.
        velocity_field: Initial velocity that varies, added to `velocity`.
        node_axes: As those of a body.
        path: Where it was described, for error messages.
    """

    name: str
    shape: Shape
    spacing: float
    liquid: Liquid = Liquid()
    velocity: Vector | None = None
    angular_velocity: float | Vector | None = None
    velocity_field: VelocityField | None = None
    node_axes: tuple[int, ...] = ()
    path: str = ""

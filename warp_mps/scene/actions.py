"""What acts on elastic bodies from outside: supports and loads."""

from __future__ import annotations

from dataclasses import dataclass

from warp_mps.scene.motions import HarmonicMotion, TableMotion, Vector
from warp_mps.shapes import Shape


@dataclass(frozen=True, kw_only=True)
class Support:
    """A region whose particles are held, along some axes or along all, at rest or on a prescribed motion.

    Attributes:
        name: Name, unique in the scene.
        region: Particles whose initial position lies in this shape are held.
        axes: Held axes (0 is x), all when empty; a roller holds one.
        bodies: Names of the bodies it acts on, all when empty.
        motion: Prescribed displacement of the held axes; None holds them at rest.
        hold_rotation: Whether the particles' rotation is held too; None holds it when every axis is held (a clamp).
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    axes: tuple[int, ...] = ()
    bodies: tuple[str, ...] = ()
    motion: HarmonicMotion | TableMotion | None = None
    hold_rotation: bool | None = None
    path: str = ""


@dataclass(frozen=True, kw_only=True)
class Load:
    """A force on the particles of a region: its value times sin(2 pi f t + phase), constant when f = 0.

    Attributes:
        name: Name, unique in the scene.
        region: Particles whose initial position lies in this shape are loaded.
        force: Total force, shared in proportion to mass [N] (2-D: [N/m]).
        acceleration: Force per mass, added to `force` [m/s^2].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
        bodies: Names of the bodies it acts on, all when empty.
        path: Where it was described, for error messages.
    """

    name: str
    region: Shape
    force: Vector | None = None
    acceleration: Vector | None = None
    frequency: float = 0.0
    phase: float = 0.0
    bodies: tuple[str, ...] = ()
    path: str = ""

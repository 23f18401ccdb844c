"""Supports and loads of elastic bodies."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_mps.scene.fields import attribute, described
from warp_mps.scene.motions import HarmonicMotion, TableMotion, Vector
from warp_mps.scene.record import Record
from warp_mps.shapes import Shape


@described
@dataclass(frozen=True, kw_only=True)
class Support(Record):
    """A region whose particles are held along some axes or along all, at rest or on a prescribed motion."""

    name: str = field(metadata=attribute(text="label"))
    """Name, unique in the scene."""
    region: Shape
    """Particles whose initial position lies in this shape are held."""
    axes: tuple[int, ...] = field(default=(), metadata=attribute("mps:axes", axes="stage"))
    """Held axes, all if not given; a roller holds one."""
    bodies: tuple[str, ...] = field(default=(), metadata=attribute("mps:bodies", refers_to="body"))
    """Bodies that it acts on, all if not given."""
    motion: HarmonicMotion | TableMotion | None = None
    """Prescribed displacement of the held axes; None holds them at rest."""
    hold_rotation: bool | None = field(default=None, metadata=attribute("mps:holdRotation"))
    """Whether the particles' rotation is held too; if not given, it is where every axis is held (a clamp)."""
    path: str = ""
    """Where it was described, for error messages."""


@described
@dataclass(frozen=True, kw_only=True)
class Load(Record):
    """A force on the particles of a region: its value times sin(2 pi f t + phase), constant where f = 0."""

    name: str = field(metadata=attribute(text="label"))
    """Name, unique in the scene."""
    region: Shape
    """Particles whose initial position lies in this shape are loaded."""
    force: Vector | None = field(default=None, metadata=attribute("mps:force", unit="N", plane_unit="N/m"))
    """Total force on the region, shared in proportion to mass; in 2-D per metre of depth."""
    acceleration: Vector | None = field(default=None, metadata=attribute("mps:acceleration", unit="m/s^2"))
    """Force per mass, added to the force."""
    frequency: float = field(default=0.0, metadata=attribute("mps:frequency", unit="Hz", minimum=0.0))
    """Frequency f of the factor sin(2 pi f t + phase); 0 is a constant load."""
    phase: float = field(default=0.0, metadata=attribute("mps:phase", unit="rad"))
    """Phase of the factor."""
    bodies: tuple[str, ...] = field(default=(), metadata=attribute("mps:bodies", refers_to="body"))
    """Bodies that it acts on, all if not given."""
    path: str = ""
    """Where it was described, for error messages."""

"""Initial velocities that vary in space, and prescribed displacements and rotations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from warp_mps.scene.choices import InterpolationName, VelocityFieldName
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.record import Record

Vector = Sequence[float]


@described
@dataclass(frozen=True, kw_only=True)
class VelocityField(Record):
    """An initial velocity that varies in space, in beams as v(x) = amplitude * shape(mode, s / length).

    s = (x - origin) . axis runs from 0 to `length`. The shapes are ``sine`` (sin(mode pi s / length)) and the
    bending modes of a uniform beam, ``free_free_beam`` and ``clamped_free_beam``, scaled to 1 at s = length
    (Rao, Mechanical Vibrations, section 8.5). ``twist``, in 3-D, is the torsion mode of a rod that is clamped at s = 0
    and free at s = length (section 8.4): v(x) = rate * sin((2 mode - 1) pi s / (2 length)) * axis x (x - origin).
    Particles' own rotation, which the springs model has, starts at rest.

    The others are of liquids, without divergence. With q = (x - origin) . e, e the direction of the amplitude, which is
    at right angles to the axis, and k = 2 pi / length:

    - ``stagnation``: rate * (x - origin) along the axis, -rate/(d - 1) * (x - origin) across it.
    - ``taylor_green``: amplitude * sin(k s) cos(k q) - axis * abs(amplitude) * cos(k s) sin(k q), vortices.
    - ``standing_wave``: linear waves as they pass through the level, on water from q = 0, the bottom, to q = depth
      (Lamb, Hydrodynamics, section 228):
      (amplitude * cos(k s) sinh(k q) - axis * abs(amplitude) * sin(k s) cosh(k q)) / sinh(k depth).
    """

    kind: VelocityFieldName = field(metadata=attribute("mps:velocityField"))
    """Initial velocity that varies in space."""
    amplitude: Vector | None = field(default=None, metadata=attribute("mps:velocityField:amplitude", unit="m/s"))
    """Velocity where the shape is 1, of all kinds but `twist` and `stagnation`; of a standing wave that of its
    crests."""
    rate: float | None = field(default=None, metadata=attribute("mps:velocityField:rate", unit="rad/s"))
    """`twist`: angular velocity where the shape is 1; `stagnation`: rate of strain."""
    axis: Vector = field(metadata=attribute("mps:velocityField:axis"))
    """Direction along which the shape varies, of any length; axis of a twist."""
    origin: Vector = field(metadata=attribute("mps:velocityField:origin", unit="m", nature="point"))
    """Point where the shape begins, s = 0; the axis of a twist goes through it."""
    length: float | None = field(default=None, metadata=attribute("mps:velocityField:length", unit="m", above=0.0))
    """Length over which the shape varies; wave length of `taylor_green` and `standing_wave`."""
    depth: float | None = field(default=None, metadata=attribute("mps:velocityField:depth", unit="m", above=0.0))
    """`standing_wave`: depth of the water."""
    mode: int = field(default=1, metadata=attribute("mps:velocityField:mode", minimum=1))
    """Number of the mode of a body."""


@described
@dataclass(frozen=True, kw_only=True)
class HarmonicMotion(Record):
    """A prescribed displacement amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    With a phase of 0 it starts at its full speed, 2 pi f amplitude, which is an impact on what it touches; with a
    phase of pi/2 or -pi/2 it starts from rest, to the other side of the amplitude or to its own.
    """

    amplitude: Vector = field(metadata=attribute("mps:motion:amplitude", unit="m"))
    """Amplitude of the displacement amplitude (sin(2 pi f t + phase) - sin(phase))."""
    frequency: float = field(metadata=attribute("mps:motion:frequency", unit="Hz", above=0.0))
    """Frequency f of the displacement."""
    phase: float = field(default=0.0, metadata=attribute("mps:motion:phase", unit="rad"))
    """Phase of the displacement."""


@described
@dataclass(frozen=True, kw_only=True)
class TableMotion(Record):
    """A prescribed displacement, interpolated between the rows of a table and constant outside it."""

    times: np.ndarray = field(metadata=attribute("mps:motion:times", unit="s"))
    """Times of the rows of a table of displacements, increasing, shape [n]."""
    displacements: np.ndarray = field(metadata=attribute("mps:motion:displacements", kind="double3[]", unit="m"))
    """Displacements at these times, zero at t = 0, shape [n, dimension]."""
    interpolation: InterpolationName = field(default="linear", metadata=attribute("mps:motion:interpolation"))
    """Interpolation between the rows: linear, or the cubic spline that is at rest at both ends, whose velocity and
    acceleration are continuous."""


@described
@dataclass(frozen=True, kw_only=True)
class HarmonicRotation(Record):
    """A prescribed rotation by an angle amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    With a phase of 0 it starts at its full rate, 2 pi f amplitude, with one of pi/2 or -pi/2 from rest.
    """

    amplitude: float = field(metadata=attribute("mps:rotation:amplitude", unit="rad"))
    """Amplitude of the angle amplitude (sin(2 pi f t + phase) - sin(phase))."""
    frequency: float = field(metadata=attribute("mps:rotation:frequency", unit="Hz", above=0.0))
    """Frequency f of the angle."""
    phase: float = field(default=0.0, metadata=attribute("mps:rotation:phase", unit="rad"))
    """Phase of the angle."""
    pivot: Vector = field(metadata=attribute("mps:rotation:pivot", unit="m", nature="point"))
    """Point of the undisplaced scene that it rotates about; a motion carries it along."""
    axis: Vector = field(default=(), metadata=attribute("mps:rotation:axis", nature="axial"))
    """Axis of rotation by the right-hand rule, of any length, shape [3]; in 2-D it is the normal of the plane, and need
    not be given."""


@described
@dataclass(frozen=True, kw_only=True)
class TableRotation(Record):
    """A prescribed rotation by the angles of a table, constant outside it."""

    times: np.ndarray = field(metadata=attribute("mps:rotation:times", unit="s"))
    """Times of the rows of a table of angles, increasing, shape [n]."""
    angles: np.ndarray = field(metadata=attribute("mps:rotation:angles", unit="rad"))
    """Angles at these times, zero at t = 0, shape [n]."""
    pivot: Vector = field(metadata=attribute("mps:rotation:pivot", unit="m", nature="point"))
    """Point of the undisplaced scene that it rotates about; a motion carries it along."""
    axis: Vector = field(default=(), metadata=attribute("mps:rotation:axis", nature="axial"))
    """Axis of rotation by the right-hand rule, of any length, shape [3]; in 2-D it is the normal of the plane, and need
    not be given."""
    interpolation: InterpolationName = field(default="linear", metadata=attribute("mps:rotation:interpolation"))
    """Interpolation between the rows, as of a motion."""

"""How things move: initial velocities that vary in space, and prescribed displacements and turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Vector = Sequence[float]


@dataclass(frozen=True, kw_only=True)
class VelocityField:
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

    Attributes:
        kind: One of `VELOCITY_FIELDS`; `VELOCITY_FIELD_PARTS` says what each needs.
        amplitude: Velocity where the shape is 1 [m/s]; of a standing wave that of its crests.
        rate: Angular velocity where the shape is 1, of ``twist`` [rad/s]; rate of stretching, of ``stagnation`` [1/s].
        axis: Direction along which the shape varies; its length does not matter.
        origin: Point where s = 0 [m]; the axis of a twist goes through it.
        length: Length of the body along the axis; wave length of what repeats itself [m].
        depth: Depth of the water of a standing wave [m].
        mode: Number of the mode, from 1, of a body.
    """

    kind: str
    amplitude: Vector | None = None
    rate: float | None = None
    axis: Vector
    origin: Vector
    length: float | None = None
    depth: float | None = None
    mode: int = 1


@dataclass(frozen=True, kw_only=True)
class HarmonicMotion:
    """A prescribed displacement amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    With a phase of 0 it sets out at its full speed, 2 pi f amplitude, which is an impact on what it touches; with a
    phase of pi/2 or -pi/2 from rest, to the other side of the amplitude or to its own.

    Attributes:
        amplitude: Amplitude of each component [m].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
    """

    amplitude: Vector
    frequency: float
    phase: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TableMotion:
    """A prescribed displacement, between the rows of a table, and constant outside it.

    Attributes:
        times: Times, increasing [s], shape [n].
        displacements: Displacements [m], shape [n, dimension].
        interpolation: ``linear``, or ``cubic``: the spline that is at rest at both ends, whose velocity and
            acceleration are continuous between them.
    """

    times: np.ndarray
    displacements: np.ndarray
    interpolation: str = "linear"


@dataclass(frozen=True, kw_only=True)
class HarmonicRotation:
    """A prescribed turn by an angle amplitude * (sin(2 pi f t + phase) - sin(phase)), zero at t = 0.

    With a phase of 0 it sets out at its full rate, 2 pi f amplitude, with one of pi/2 or -pi/2 from rest.

    Attributes:
        amplitude: Amplitude [rad].
        frequency: Frequency f [Hz].
        phase: Phase [rad].
        pivot: Point of the undisplaced scene that it turns about [m]; a motion carries it along.
        axis: Direction that it turns about, of any length, shape [3]; in 2-D it is the normal, whatever is given.
    """

    amplitude: float
    frequency: float
    phase: float = 0.0
    pivot: Vector
    axis: Vector = ()


@dataclass(frozen=True, kw_only=True)
class TableRotation:
    """A prescribed turn by the angles of a table, and constant outside it.

    Attributes:
        times: Times, increasing [s], shape [n].
        angles: Angles [rad], shape [n].
        pivot: Point of the undisplaced scene that it turns about [m]; a motion carries it along.
        axis: Direction that it turns about, of any length, shape [3]; in 2-D it is the normal, whatever is given.
        interpolation: ``linear`` or ``cubic``, as of a `TableMotion`.
    """

    times: np.ndarray
    angles: np.ndarray
    pivot: Vector
    axis: Vector = ()
    interpolation: str = "linear"

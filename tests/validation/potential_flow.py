"""The dam break of a perfect fluid: potential flow with a free surface, by boundary elements, not by particles.

The potential phi is harmonic in the water. Following the points of the free surface (Longuet-Higgins & Cokelet 1976),

    dx/dt = grad phi,    dphi/dt = |grad phi|^2/2 - g y

and phi on the surface gives grad phi there: its part along the surface by differences, that across it, q, from

    c phi + int phi dG/dn ds = int q G ds,    G = ln r,

with phi and q linear along straight elements. Floor and side wall are planes of symmetry, so that images of the surface
stand for them, and no point of them is computed. Lengths are in widths a of the column and times in sqrt(a/2g), T and Z
of Martin & Moyce (1952): gravity is 1/2.

At the foot of the column the acceleration is infinite at the start, as the logarithm of the distance from it (Pohle
1950): the front of any method of finite resolution starts late.

References:
    Longuet-Higgins, M. S. and Cokelet, E. D., Proceedings of the Royal Society of London A 350 (1976) 1.
    Martin, J. C. and Moyce, W. J., Philosophical Transactions of the Royal Society of London A 244 (1952) 312.
    Pohle, F. V., The Lagrangian equations of hydrodynamics: solutions which are analytic functions of the time,
    New York University (1950).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

GRAVITY = 0.5
# images in the side wall x = 0 and the floor y = 0; a single reflection turns the direction along the surface round
IMAGES = ((1, 1), (-1, 1), (-1, -1), (1, -1))
TIME_STEP = 0.01
# radius of the column's upper corner, so that the surface has a normal there
CORNER = 0.06
# growth of the elements with the distance from the front, and their length over the water's depth
GROWTH, PER_DEPTH = 0.08, 0.5


@dataclass(frozen=True)
class Collapse:
    """History of a column that collapses.

    Attributes:
        times: T, shape [n].
        fronts: Z, the place of the front on the floor, shape [n].
        heights: Height of the water at the side wall, shape [n].
        volumes: Volume of the water, shape [n].
        energies: Kinetic and potential energy per density, shape [n].
    """

    times: np.ndarray
    fronts: np.ndarray
    heights: np.ndarray
    volumes: np.ndarray
    energies: np.ndarray

    def arrival(self, front: float) -> float:
        """Time at which the front comes to a place."""
        return float(np.interp(front, self.fronts, self.times))


def collapse(*, end: float, height: float = 2.0, longest: float = 0.06, shortest: float = 0.01) -> Collapse:
    """Let a column collapse.

    Args:
        end: Time to stop at.
        height: Of the column.
        longest: Length of an element far from the front.
        shortest: Length of an element at the front.
    """
    x, phi = _spread(*_column(height), longest, shortest)
    rows = []
    for k in range(int(np.ceil(end / TIME_STEP)) + 1):
        _, q = velocities(x, phi)
        rows.append((k * TIME_STEP, x[-1, 0], x[0, 1], *_content(x, phi, q)))
        x, phi = _spread(*_step(x, phi, TIME_STEP), longest, shortest)
    return Collapse(*np.array(rows).T)


def velocities(x: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the points of the surface, and their parts across it.

    Args:
        x: Points from the side wall to the front, shape [n, 2].
        phi: Their potentials, shape [n].
    """
    single, double = _layers(x)
    np.fill_diagonal(double, 0.0)
    # a constant potential is no flow
    np.fill_diagonal(double, -double.sum(axis=1))
    q = np.linalg.solve(single, double @ phi)
    tangents, slopes = _along(x, phi)
    u = q[:, None] * _normals(tangents) + slopes[:, None] * tangents
    u[0, 0] = u[-1, 1] = 0.0
    return u, q


def _layers(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of G and of dG/dn over the elements and their images, as factors of the values at the points."""
    n = len(x)
    single, double = np.zeros((n, n)), np.zeros((n, n))
    for image in IMAGES:
        ends = [(x * image)[:-1], (x * image)[1:]]
        columns = [np.arange(n - 1), np.arange(1, n)]
        if image[0] != image[1]:
            ends.reverse()
            columns.reverse()
        lengths = np.linalg.norm(ends[1] - ends[0], axis=1)
        tangents = (ends[1] - ends[0]) / lengths[:, None]
        arms = x[:, None] - ends[0]
        # the element runs from a to b along a line that passes the point at the distance h
        a, h = -np.sum(arms * tangents, axis=2), np.sum(arms * _normals(tangents), axis=2)
        b = a + lengths
        squares = np.maximum(a * a + h * h, 1e-300), np.maximum(b * b + h * h, 1e-300)
        log_a, log_b = (0.5 * np.log(square) for square in squares)
        flat = np.abs(h) < 1e-14
        safe = np.where(flat, 1.0, h)
        angle = np.where(flat, 0.0, np.arctan(b / safe) - np.arctan(a / safe))
        mean = b * log_b - a * log_a - lengths + h * angle
        first = 0.5 * (squares[1] * log_b - squares[0] * log_a) - 0.25 * (squares[1] - squares[0])
        for matrix, whole, moment in ((single, mean, first), (double, -angle, h * (log_a - log_b))):
            at_b = (moment - a * whole) / lengths
            matrix[:, columns[0]] += whole - at_b
            matrix[:, columns[1]] += at_b
    return single, double


def _normals(tangents: np.ndarray) -> np.ndarray:
    """Outward normals of the surface, which has the water on its right."""
    return np.stack((-tangents[:, 1], tangents[:, 0]), axis=1)


def _along(x: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tangents at the points, and the derivative of the potential along the surface."""
    lengths = np.linalg.norm(np.diff(x, axis=0), axis=1)
    values = np.column_stack((np.diff(x, axis=0), np.diff(phi))) / lengths[:, None]
    mean = np.empty((len(x), 3))
    before, after = lengths[:-1, None], lengths[1:, None]
    mean[1:-1] = (after * values[:-1] + before * values[1:]) / (before + after)
    # by symmetry at the side wall; at the front, which is sharp, of the last element, for extrapolation is unstable
    mean[0] = 1.0, 0.0, 0.0
    mean[-1] = values[-1]
    return mean[:, :2] / np.linalg.norm(mean[:, :2], axis=1)[:, None], mean[:, 2]


def _step(x: np.ndarray, phi: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """A step of the classical Runge-Kutta method."""

    def rates(change: np.ndarray, part: float) -> np.ndarray:
        moved = x + part * dt * change[:, :2]
        u, _ = velocities(moved, phi + part * dt * change[:, 2])
        return np.column_stack((u, 0.5 * np.sum(u**2, axis=1) - GRAVITY * moved[:, 1]))

    k1 = rates(np.zeros((len(x), 3)), 0.0)
    k2 = rates(k1, 0.5)
    k3 = rates(k2, 0.5)
    mean = (k1 + 2.0 * k2 + 2.0 * k3 + rates(k3, 1.0)) / 6.0
    return x + dt * mean[:, :2], phi + dt * mean[:, 2]


def _spread(x: np.ndarray, phi: np.ndarray, longest: float, shortest: float) -> tuple[np.ndarray, np.ndarray]:
    """New points along the surface, close to each other at the front and where the water is shallow."""
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1)))
    # the slopes of the height and the potential are 0 at the side wall
    curves = [CubicSpline(s, f, bc_type=(start, (2, 0.0))) for f, start in ((x[:, 0], (2, 0.0)), (x[:, 1], (1, 0.0)))]
    curves.append(CubicSpline(s, phi, bc_type=((1, 0.0), (2, 0.0))))
    fine = np.linspace(0.0, s[-1], 4000)
    wanted = np.minimum(np.clip(shortest + GROWTH * (s[-1] - fine), shortest, longest), PER_DEPTH * curves[1](fine))
    density = 1.0 / np.maximum(wanted, shortest)
    count = np.append(0.0, np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(fine)))
    places = np.interp(np.linspace(0.0, count[-1], int(np.ceil(count[-1])) + 1), count, fine)
    new = np.column_stack([curve(places) for curve in curves])
    new[0, 0], new[-1] = 0.0, (*x[-1], phi[-1])
    return new[:, :2], new[:, 2]


def _column(height: float) -> tuple[np.ndarray, np.ndarray]:
    """The column at the start."""
    angle = np.linspace(0.5 * np.pi, 0.0, 12)
    top = np.column_stack((np.linspace(0.0, 1.0 - CORNER, 40), np.full(40, height)))
    corner = np.column_stack((1.0 + CORNER * (np.cos(angle) - 1.0), height + CORNER * (np.sin(angle) - 1.0)))
    face = np.column_stack((np.ones(200), np.linspace(height - CORNER, 0.0, 200)))
    x = np.vstack((top[:-1], corner, face[1:]))
    return x, np.zeros(len(x))


def _content(x: np.ndarray, phi: np.ndarray, q: np.ndarray) -> tuple[float, float]:
    """Volume and energy of the water, by integrals over its surface."""
    dx, dy = np.diff(x, axis=0).T
    y0, y1 = x[:-1, 1], x[1:, 1]
    volume = np.sum(0.5 * (y0 + y1) * dx)
    potential = GRAVITY * np.sum((y0 * y0 + y0 * y1 + y1 * y1) * dx) / 6.0
    ends = phi[:-1] * q[:-1] + phi[1:] * q[1:] + 0.5 * (phi[:-1] * q[1:] + phi[1:] * q[:-1])
    kinetic = 0.5 * np.sum(ends * np.hypot(dx, dy)) / 3.0
    return float(volume), float(kinetic + potential)

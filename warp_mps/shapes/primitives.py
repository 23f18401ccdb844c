"""Shapes given by a formula: box, sphere, cylinder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.numbers import as_array, as_vector, is_number, shown
from warp_mps.shapes.shape import Shape

if TYPE_CHECKING:
    from typing_extensions import Self

AxisName = Literal["x", "y", "z"]
AXIS_NAMES: tuple[AxisName, ...] = get_args(AxisName)


class _Implicit(Shape):
    """A shape whose own centre and half extents are known, bounded by smooth faces."""

    center: Sequence[float]

    def _half_extent(self, direction: np.ndarray) -> float:
        raise NotImplementedError

    def _faces(self, local: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Distance outside each face [n] and its normal [n, 3] or [3], both in the shape's own coordinates."""
        raise NotImplementedError

    def moved(self, displacement: Sequence[float]) -> Self:
        """The shape moved by a displacement [m], 2 or 3 numbers."""
        if self.placement is not None:
            return super().moved(displacement)
        shift = as_vector(displacement, self._kind, "displacement", finite=True)
        return replace(self, center=tuple(c + d for c, d in zip(self.center, shift, strict=True)))  # type: ignore[call-arg]

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the placed shape along a unit direction of the scene [m]."""
        middle = float(direction @ (self.linear @ np.asarray(self.center) + self.translation))
        half = self._half_extent(self.linear.T @ direction)
        return middle - half, middle + half

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the shape or within a tolerance [m] of it."""
        inverse = np.linalg.inv(self.linear)
        local = (points - self.translation) @ inverse.T - np.asarray(self.center)
        result = np.ones(len(points), bool)
        for distance, normal in self._faces(local):
            # A normal through the inverse map turns a length of the scene into one of the shape's own coordinates.
            scale = 1.0 if self.placement is None else np.linalg.norm(normal @ inverse, axis=-1)
            result &= distance <= tolerance * scale
        return result


@dataclass(frozen=True, eq=False)
class Box(_Implicit):
    """A box along its own axes.

    Attributes:
        size: Edge lengths [m], 3 numbers, or 2 for a box that is infinitely deep along z.
        center: Centre [m], 2 or 3 numbers.
        placement: How it is turned, stretched and moved, as of every `Shape`.
    """

    size: Sequence[float]
    center: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("size", as_vector(self.size, self._kind, "size", depth=np.inf))
        self._set("center", as_vector(self.center, self._kind, "center"))
        for length in self.size:
            self._positive("size", length)

    @classmethod
    def from_corners(cls, low: Sequence[float], high: Sequence[float]) -> Box:
        """The box between two opposite corners, along the scene's axes.

        Args:
            low: Corner with the least coordinates [m], 2 numbers (infinitely deep along z) or 3.
            high: Corner with the greatest coordinates [m], as many numbers.

        Raises:
            InputError: The corners are not 2 or 3 finite numbers each, or `high` is not above `low` along every axis.
        """
        lower, upper = as_array(low), as_array(high)
        for name, corner, given in (("low", lower, low), ("high", upper, high)):
            if corner.shape not in ((2,), (3,)) or not np.isfinite(corner).all():
                raise InputError(cls.__name__, name, f"must be 2 or 3 finite numbers, not {shown(given)}")
        if lower.shape != upper.shape or not (upper > lower).all():
            reason = (
                f"is {shown(high)}, must have as many numbers as low, {shown(low)}, and lie above it along every axis"
            )
            raise InputError(cls.__name__, "high", reason)
        return cls(tuple((upper - lower).tolist()), tuple((0.5 * (lower + upper)).tolist()))

    def _half_extent(self, direction: np.ndarray) -> float:
        parts = zip(np.abs(direction), self.size, strict=True)
        # A component that is zero but for rounding must not bring in the infinite depth of a 2-D box.
        return float(sum(0.5 * part * length for part, length in parts if part > 1e-12))

    def _faces(self, local: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        return [(np.abs(local[:, k]) - 0.5 * self.size[k], np.eye(3)[k]) for k in range(3)]


@dataclass(frozen=True, eq=False)
class Sphere(_Implicit):
    """A sphere.

    Attributes:
        radius: Radius [m].
        center: Centre [m], 2 or 3 numbers.
        placement: How it is turned, stretched and moved, as of every `Shape`.
    """

    radius: float
    center: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("center", as_vector(self.center, self._kind, "center"))
        self._positive("radius", self.radius)

    def _half_extent(self, direction: np.ndarray) -> float:
        return float(self.radius * np.linalg.norm(direction))

    def _faces(self, local: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        distance = np.linalg.norm(local, axis=1)
        return [(distance - self.radius, _directions(local, distance))]


@dataclass(frozen=True, eq=False)
class Cylinder(_Implicit):
    """A cylinder, or a tube; in a 2-D scene and along z, a disk or a ring.

    Attributes:
        radius: Outer radius [m].
        height: Length along its axis [m].
        axis: Its axis, ``x``, ``y`` or ``z``.
        center: Centre [m], 2 or 3 numbers.
        inner_radius: Radius of the bore [m].
        placement: How it is turned, stretched and moved, as of every `Shape`.
    """

    radius: float
    height: float = np.inf
    axis: AxisName = "z"
    center: Sequence[float] = (0.0, 0.0, 0.0)
    inner_radius: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("center", as_vector(self.center, self._kind, "center"))
        self._positive("radius", self.radius)
        self._positive("height", self.height)
        if self.axis not in AXIS_NAMES:
            raise InputError(self._kind, "axis", f"must be x, y or z, not {self.axis!r}")
        if not (is_number(self.inner_radius) and 0 <= self.inner_radius < self.radius):
            raise InputError(self._kind, "inner_radius", f"must be at least 0 and less than the radius {self.radius}")

    def _half_extent(self, direction: np.ndarray) -> float:
        along = direction[AXIS_NAMES.index(self.axis)]
        across = np.sqrt(max(0.0, direction @ direction - along**2))
        ends = 0.5 * self.height * abs(along) if abs(along) > 1e-12 else 0.0
        return float(self.radius * across + ends)

    def _faces(self, local: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        along = AXIS_NAMES.index(self.axis)
        across = np.where(np.arange(3) == along, 0.0, local)
        distance = np.linalg.norm(across, axis=1)
        outward = _directions(across, distance)
        faces = [(np.abs(local[:, along]) - 0.5 * self.height, np.eye(3)[along]), (distance - self.radius, outward)]
        return [*faces, (self.inner_radius - distance, outward)] if self.inner_radius > 0 else faces


def _directions(vectors: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Unit vectors; of a zero vector, one of the axes that is as good as any other here."""
    safe = np.where(lengths > 0, lengths, 1.0)[:, None]
    return np.where(lengths[:, None] > 0, vectors / safe, np.array([1.0, 0.0, 0.0]))

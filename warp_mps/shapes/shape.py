"""The base of all shapes, and shapes made of two others: union, difference, intersection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.numbers import as_array, as_vector, is_number, shown

if TYPE_CHECKING:
    from typing_extensions import Self

AXES = dict(zip("xyz", np.eye(3), strict=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """A region of space, placed in the scene.

    Shapes are united by ``a | b``, subtracted by ``a - b`` and intersected by ``a & b``.

    Attributes:
        placement: Affine map from the shape's own coordinates to the scene's,
            x_scene = placement[:3, :3] @ x + placement[:3, 3], shape [4, 4]; None is the identity.
    """

    placement: np.ndarray | None = None

    # whether it has an inside: ready-made particles have none, and so cannot be united, subtracted or intersected
    is_region: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.placement is None:
            return
        placement = as_array(self.placement)
        if placement.shape != (4, 4) or not np.isfinite(placement).all() or np.linalg.det(placement[:3, :3]) == 0:
            raise InputError(self._kind, "placement", "must be a finite, invertible 4 x 4 matrix")
        object.__setattr__(self, "placement", placement)

    def __or__(self, other: Shape) -> Union:
        return Union(self, other) if isinstance(other, Shape) else NotImplemented

    def __sub__(self, other: Shape) -> Difference:
        return Difference(self, other) if isinstance(other, Shape) else NotImplemented

    def __and__(self, other: Shape) -> Intersection:
        return Intersection(self, other) if isinstance(other, Shape) else NotImplemented

    @property
    def _kind(self) -> str:
        return type(self).__name__

    @property
    def linear(self) -> np.ndarray:
        """Linear part of the placement, shape [3, 3]."""
        return np.eye(3) if self.placement is None else self.placement[:3, :3]

    @property
    def translation(self) -> np.ndarray:
        """Translation of the placement [m], shape [3]."""
        return np.zeros(3) if self.placement is None else self.placement[:3, 3]

    def to_scene(self, points: np.ndarray) -> np.ndarray:
        """Map points from the shape's own coordinates to the scene's, shape [n, 3]."""
        return points @ self.linear.T + self.translation

    def placed(self, matrix: np.ndarray) -> Self:
        """The shape mapped by an affine map of the scene, shape [4, 4], which follows its present placement."""
        present = np.eye(4) if self.placement is None else self.placement
        return replace(self, placement=as_array(matrix) @ present)

    def moved(self, displacement: Sequence[float]) -> Self:
        """The shape moved by a displacement [m], 2 or 3 numbers."""
        matrix = np.eye(4)
        matrix[:3, 3] = as_vector(displacement, self._kind, "displacement", finite=True)
        return self.placed(matrix)

    def turned(self, angle: float, axis: str | Sequence[float] = "z", about: Sequence[float] = (0.0, 0.0, 0.0)) -> Self:
        """The shape turned by an angle, right-handed about an axis; its lattice of particles turns with it.

        Args:
            angle: Angle [rad], counterclockwise in a 2-D scene.
            axis: ``x``, ``y``, ``z``, or a direction, 3 numbers. A 2-D scene turns about z.
            about: A point on the axis [m], 2 or 3 numbers; the scene's origin by default.

        Raises:
            InputError: The angle is not finite, or the axis has no direction.
        """
        if not (is_number(angle) and np.isfinite(float(angle))):
            raise InputError(self._kind, "angle", f"must be a finite number, not {shown(angle)}")
        direction = AXES.get(axis, np.zeros(3)) if isinstance(axis, str) else as_array(axis)
        length = np.linalg.norm(direction)
        if direction.shape != (3,) or not np.isfinite(length) or length == 0.0:
            raise InputError(self._kind, "axis", f"must be x, y, z or 3 numbers that are not all 0, not {shown(axis)}")
        pivot = np.array(as_vector(about, self._kind, "about", finite=True))
        matrix = np.eye(4)
        matrix[:3, :3] = _rotation(direction / length, float(angle))
        matrix[:3, 3] = pivot - matrix[:3, :3] @ pivot
        return self.placed(matrix)

    def leaves(self) -> tuple[Shape, ...]:
        """The shapes that it is made of, the one that gives its lattice first: itself, unless it is a composite."""
        return (self,)

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the placed shape along a unit direction of the scene [m]."""
        raise NotImplementedError

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the shape, its surface moved out by a tolerance [m]."""
        raise NotImplementedError

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _positive(self, name: str, value: float) -> None:
        if not (is_number(value) and value > 0):
            raise InputError(self._kind, name, f"must be positive, not {shown(value)}")


@dataclass(frozen=True, eq=False)
class Composite(Shape):
    """A shape made of two others, filled on the lattice of the first.

    Its lattice is that of `first`, continued as far as the composite reaches: ``Box - Sphere`` keeps the particles of
    the box that lie outside the sphere. A particle belongs to it if its centre does.

    Attributes:
        first: First operand.
        second: Second operand.
        placement: A map that follows those of both operands; it is passed on to them.

    Raises:
        InputError: An operand is no shape, or is ready-made particles, which have no inside.
    """

    first: Shape
    second: Shape

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("first", "second"):
            operand = getattr(self, name)
            if not isinstance(operand, Shape) or not operand.is_region:
                kind = type(operand).__name__
                raise InputError(
                    self._kind, name, f"is {kind}, must be a shape with an inside, such as a Box or a Mesh"
                )
        if self.placement is not None:
            self._set("first", self.first.placed(self.placement))
            self._set("second", self.second.placed(self.placement))
            self._set("placement", None)

    def placed(self, matrix: np.ndarray) -> Self:
        """Both operands mapped by an affine map of the scene, shape [4, 4]."""
        return self.mapped(lambda shape: shape.placed(matrix))

    def moved(self, displacement: Sequence[float]) -> Self:
        """Both operands moved by a displacement [m], 2 or 3 numbers."""
        return self.mapped(lambda shape: shape.moved(displacement))

    def mapped(self, change: Callable[[Shape], Shape]) -> Self:
        """The composite of its operands after a change of each."""
        return replace(self, first=change(self.first), second=change(self.second))

    def leaves(self) -> tuple[Shape, ...]:
        """The shapes that it is made of, the one that gives its lattice first."""
        return (*self.first.leaves(), *self.second.leaves())


@dataclass(frozen=True, eq=False)
class Union(Composite):
    """The union of two shapes, ``first | second``."""

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate along a unit direction of the scene [m]."""
        (low, high), (other_low, other_high) = self.first.interval(direction), self.second.interval(direction)
        return min(low, other_low), max(high, other_high)

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the shape, its surface moved out by a tolerance [m]."""
        return self.first.inside(points, tolerance) | self.second.inside(points, tolerance)


@dataclass(frozen=True, eq=False)
class Difference(Composite):
    """The part of a shape outside another, ``first - second``; the cut face belongs to it."""

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Least and greatest coordinate of the first operand along a unit direction of the scene [m]."""
        return self.first.interval(direction)

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the shape, its surface moved out by a tolerance [m]."""
        result = self.first.inside(points, tolerance)
        result[result] = ~self.second.inside(points[result], -tolerance)
        return result


@dataclass(frozen=True, eq=False)
class Intersection(Composite):
    """The intersection of two shapes, ``first & second``."""

    def interval(self, direction: np.ndarray) -> tuple[float, float]:
        """Bounds of its coordinates along a unit direction of the scene [m]; low > high where the shapes are apart."""
        (low, high), (other_low, other_high) = self.first.interval(direction), self.second.interval(direction)
        return max(low, other_low), min(high, other_high)

    def inside(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether points of the scene, shape [n, 3], lie in the shape, its surface moved out by a tolerance [m]."""
        result = self.first.inside(points, tolerance)
        result[result] = self.second.inside(points[result], tolerance)
        return result


def _rotation(direction: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula: I + sin(angle) K + (1 - cos(angle)) K K, K the cross product with the direction."""
    x, y, z = direction
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross

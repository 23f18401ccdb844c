"""Shapes made of others: prims whose relationships unite them with, cut them to, or clear them of other prims.

A prim stands for ((its own geometry | plus) & intersect) - minus. The other prims are geometries of any kind but
`Points`, which may have such relationships in turn; where they have no role, they are nothing else in the case.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from pxr import Usd

from warp_mps.errors import InputError
from warp_mps.shapes import Difference, Intersection, Points, Shape, Union
from warp_mps.usd.case.authored import is_given
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.geometry import geometry_of, read_shape
from warp_mps.usd.case.prim_values import related_prims, typed

# relationships, in the order in which they are applied, and the operation of each
PLUS, INTERSECT, MINUS = "mps:plus", "mps:intersect", "mps:minus"
JOINS: dict[str, Callable[[Shape, Shape], Shape]] = {PLUS: Union, INTERSECT: Intersection, MINUS: Difference}
BORE, LEVEL = "mps:innerRadius", "mps:fillLevel"
# shapes that one prim may be made of: more are a chain of references that was not meant
MOST_SHAPES = 200


def read_region(prim: Usd.Prim, frame: Frame) -> Shape:
    """Shape of a prim, joined with those of the prims that its relationships refer to.

    Args:
        prim: A geometry.
        frame: Units and axes.

    Returns:
        The shape, in metres and in the scene's coordinates.

    Raises:
        InputError: A prim is no geometry with an inside, refers to itself, or is made of more than `MOST_SHAPES`.
    """
    return _Reader(frame, str(prim.GetPath())).read(prim, ())


@dataclass
class _Reader:
    """The shapes of a prim and of those that it refers to, counted."""

    frame: Frame
    path: str
    count: int = field(default=0)

    def read(self, prim: Usd.Prim, chain: tuple[str, ...]) -> Shape:
        path = str(prim.GetPath())
        self.count += 1
        if self.count > MOST_SHAPES:
            raise InputError(self.path, PLUS, f"makes a shape of more than {MOST_SHAPES} others")
        shape = self._own(prim, (*chain, path))
        for name, join in JOINS.items():
            for target in self._targets(prim, name):
                other = str(target.GetPath())
                if other == path or other in chain:
                    raise InputError(path, name, f"refers to {other}, which is made of {path} itself")
                second = self.read(target, (*chain, path))
                if isinstance(shape, Points) or isinstance(second, Points):
                    which = path if isinstance(shape, Points) else other
                    raise InputError(path, name, f"needs shapes with an inside: {which} is of ready-made particles")
                shape = join(shape, second)
        return shape

    def _own(self, prim: Usd.Prim, chain: tuple[str, ...]) -> Shape:
        """The shape of a prim before it is joined with others: its own, or that of the geometry below it."""
        geometry = geometry_of(prim)
        bored = is_given(prim, BORE)
        if geometry != prim and not bored:
            return self.read(geometry, chain)
        # the bore's radius is a length of the shape's own coordinates, as its radius is
        bore = typed(prim.GetAttribute(BORE), "double") * self.frame.stage.meters_per_unit if bored else None
        return read_shape(prim, self.frame, bore)

    def _targets(self, prim: Usd.Prim, name: str) -> list[Usd.Prim]:
        path = str(prim.GetPath())
        # what is inactive takes no part in a case
        prims = [found for found in related_prims(prim, name) if found.IsActive()]
        for found in prims:
            if found.IsAbstract():
                reason = f"refers to {found.GetPath()}, which is a class; refer to a prim that is defined"
                raise InputError(path, name, reason)
            if is_given(found, LEVEL):
                reason = f"refers to {found.GetPath()}, whose {LEVEL} does not cut it here; refer to a prim without it"
                raise InputError(path, name, reason)
        return prims


def operations(shape: Shape) -> tuple[Shape, dict[str, list[Shape]]]:
    """A shape as a prim holds it: its first operand, and the operands of each relationship.

    Other orders of unions, intersections and differences are brought into this one by the algebra of sets:
    (A & B) | C = (A | C) & (B | C), (A - B) | C = (A | C) - (B - C), (A - B) & C = (A & C) - B.
    """
    if isinstance(shape, Union):
        base, found = operations(shape.first)
        return base, {
            PLUS: [*found[PLUS], shape.second],
            INTERSECT: [other | shape.second for other in found[INTERSECT]],
            MINUS: [other - shape.second for other in found[MINUS]],
        }
    if isinstance(shape, Intersection | Difference):
        base, found = operations(shape.first)
        name = INTERSECT if isinstance(shape, Intersection) else MINUS
        return base, {**found, name: [*found[name], shape.second]}
    return shape, {PLUS: [], INTERSECT: [], MINUS: []}

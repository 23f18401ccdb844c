"""Metadata of the fields of a case, besides type and default: name in a stage, unit, limits and meaning.

Each stands once, at the field:

    frame_rate: float = field(default=100.0, metadata=attribute("mps:frameRate", unit="1/s", above=0.0))
    \"\"\"Saved frames per simulated second.\"\"\"

Reading, saving, ``--set``, checks of ranges, the USD schema, the tables of ``stages/README.md``, the names of settings
in run.json and ``help()`` follow from it. The string below the field is its meaning; in it `frame_rate` in backquotes
is another field of the class, and becomes that field's name in a stage where the text is about stages.
"""

from __future__ import annotations

import ast
import dataclasses
import functools
import itertools
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

Kind = TypeVar("Kind", bound=type)

# columns of a line of a generated docstring
_WIDTH = 108


@dataclasses.dataclass(frozen=True)
class Unit:
    """An SI unit, and how it scales with the units of length and mass of a stage.

    Attributes:
        stage: The unit in a stage, L the stage's unit of length and M that of mass.
        length: Power of the unit of length.
        mass: Power of the unit of mass.
    """

    stage: str
    length: int = 0
    mass: int = 0


# the units that depend on those of a stage
UNITS = {
    "m": Unit("L", 1),
    "m/s": Unit("L/s", 1),
    "m/s^2": Unit("L/s^2", 1),
    "m^2/s": Unit("L^2/s", 2),
    "kg/m^3": Unit("M/L^3", -3, 1),
    "Pa": Unit("M/(L s^2)", -1, 1),
    "N": Unit("M L/s^2", 1, 1),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Attribute:
    """Metadata of a field.

    Attributes:
        name: Name of the attribute, or of the relationship, in a stage; empty where a stage has no such attribute.
        kind: Type in a stage; empty where the annotation of the field says it.
        unit: SI unit, in 2-D that of a 3-D scene; empty for a field without a unit.
        plane_unit: Unit in a 2-D scene where it is another one.
        allowed: Allowed numbers; allowed words stand in the annotation, as a `Literal`.
        above: The value must be above this number.
        minimum: Least allowed value.
        maximum: Greatest allowed value.
        finite: Whether a number must be finite.
        text: What a name must be: an ``identifier`` as those of prims, or a ``label``, printable and not a formula.
        nature: How a vector lies in a 2-D scene: ``polar`` (in the plane), ``axial`` (along its normal) or ``point``
            (its component along the normal does not matter).
        axes: For numbers of axes, which a stage gives as letters: ``shape`` (axes of the shape) or ``stage``.
        refers_to: For names of other items, which a stage gives as a relationship: the role of these.
        stage_default: Default in a stage, where it is not that of the field.
    """

    name: str = ""
    kind: str = ""
    unit: str = ""
    plane_unit: str = ""
    allowed: tuple[int, ...] = ()
    above: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    finite: bool = True
    text: Literal["", "identifier", "label"] = ""
    nature: Literal["polar", "axial", "point"] = "polar"
    axes: Literal["", "shape", "stage"] = ""
    refers_to: str = ""
    stage_default: Any = None

    @property
    def limits(self) -> str:
        """Text of the allowed range, such as ``above 0, at most 1``; empty if all numbers are allowed."""
        if self.minimum is not None and self.maximum is not None:
            return f"{self.minimum:g} to {self.maximum:g}"
        words = {"above": self.above, "at least": self.minimum, "at most": self.maximum}
        return ", ".join(f"{word} {limit:g}" for word, limit in words.items() if limit is not None)


_KEY = "attribute"


def attribute(name: str = "", **known: Any) -> dict[str, Attribute]:
    """Metadata of a dataclass field, besides its type, default and meaning.

    Args:
        name: Name in a stage, empty where a stage has no such attribute.
        known: The other fields of `Attribute`.
    """
    return {_KEY: Attribute(name=name, **known)}


def attributes_of(kind: type) -> dict[str, Attribute]:
    """Metadata of each field of a dataclass, by name."""
    return {field.name: field.metadata.get(_KEY, Attribute()) for field in dataclasses.fields(kind)}


def units_of(kind: type, dimension: int) -> dict[str, str]:
    """Units of the fields of a dataclass that have one, in a scene of 2 or 3 dimensions."""
    known = attributes_of(kind).items()
    units = {name: (dimension == 2 and item.plane_unit) or item.unit for name, item in known}
    return {name: unit for name, unit in units.items() if unit}


def default_of(kind: type, name: str) -> Any:
    """Default of a field of a dataclass; `dataclasses.MISSING` where it must be given."""
    return next(field.default for field in dataclasses.fields(kind) if field.name == name)


@functools.cache
def meanings(kind: type) -> dict[str, str]:
    """Meanings of the fields of a class: the strings below them; empty where the source is not at hand."""
    found = dict[str, str]()
    for owner in reversed(kind.__mro__):
        found |= _strings(_classes(_source(owner)).get(owner.__name__, ()))
    return found


def _strings(statements: Sequence[ast.stmt]) -> dict[str, str]:
    """Strings that stand right below an annotated name, by these names."""
    found = {}
    for field, below in itertools.pairwise(statements):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            text = below.value.value if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) else None
            if isinstance(text, str):
                found[field.target.id] = " ".join(text.split())
    return found


def _source(kind: type) -> str:
    """File of the module of a class, empty for one without."""
    return str(getattr(sys.modules.get(kind.__module__), "__file__", None) or "")


@functools.cache
def _classes(file: str) -> dict[str, list[ast.stmt]]:
    """Bodies of the classes of a source file."""
    try:
        tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    except (OSError, SyntaxError, ValueError):
        return {}
    return {node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)}


def described(kind: Kind) -> Kind:
    """Class decorator: list the fields in the class's docstring, as `help` shows it."""
    known, said = attributes_of(kind), meanings(kind)
    lines = [_line(name, text, known[name]) for name, text in said.items() if name in known]
    head, raises, tail = (kind.__doc__ or "").partition("\n    Raises:")
    section = "".join(f"\n{line}" for line in lines)
    if lines:
        kind.__doc__ = f"{head.rstrip()}\n\n    Attributes:{section}\n{raises}{tail}"
    return kind


def _line(name: str, text: str, known: Attribute) -> str:
    """Entry of a field in a section of attributes."""
    more = "; ".join(part for part in (known.unit, known.limits, known.name) if part)
    entry = f"{name}: {text}{f' [{more}]' if more else ''}"
    return textwrap.fill(entry, _WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 12, break_long_words=False)

"""The metadata of a field stand once, at the field."""

from __future__ import annotations

import dataclasses
import inspect
from dataclasses import dataclass, field
from typing import Literal

import pytest

import warp_mps.scene as sc
from warp_mps.scene.choices import QUANTITIES, VELOCITY_FIELD_PARTS, VELOCITY_FIELDS
from warp_mps.scene.fields import attribute, attributes_of, described, meanings, units_of

CLASSES = [item for item in vars(sc).values() if isinstance(item, type) and dataclasses.is_dataclass(item)]


@described
@dataclass(frozen=True)
class Spring:
    """A spring.

    Raises:
        ValueError: Never.
    """

    stiffness: float = field(metadata=attribute("mps:stiffness", unit="N", plane_unit="N/m", above=0.0, maximum=9.0))
    """Stiffness, that of
    a `kind`."""
    kind: Literal["soft", "hard"] = "soft"
    """How it gives way."""
    path: str = ""


def test_the_docstring_lists_the_fields() -> None:
    lines = (inspect.getdoc(Spring) or "").splitlines()
    assert lines[:4] == ["A spring.", "", "Attributes:", "    stiffness: Stiffness, that of a `kind`. [N; above 0, at most 9; mps:stiffness]"]  # fmt: skip  # noqa: E501
    assert lines[4:] == ["    kind: How it gives way.", "", "Raises:", "    ValueError: Never."]


def test_meanings_units_and_limits() -> None:
    assert meanings(Spring) == {"stiffness": "Stiffness, that of a `kind`.", "kind": "How it gives way."}
    assert (units_of(Spring, 2), units_of(Spring, 3)) == ({"stiffness": "N/m"}, {"stiffness": "N"})
    assert attributes_of(Spring)["stiffness"].limits == "above 0, at most 9"
    assert attributes_of(Spring)["kind"].name == ""


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_every_field_of_a_scene_is_described(kind: type) -> None:
    assert [*meanings(kind)] == [item.name for item in dataclasses.fields(kind)]
    assert all(f"        {name}: " in (kind.__doc__ or "") for name in meanings(kind))


def test_closed_sets_agree() -> None:
    assert tuple(VELOCITY_FIELD_PARTS) == VELOCITY_FIELDS
    assert set(sc.PROBE_UNITS) == set(QUANTITIES)
    places = (*sc.PROBE_QUANTITIES.values(), sc.WALL_QUANTITIES, *sc.FLUID_QUANTITIES.values())
    assert {name for names in places for name in names} == set(QUANTITIES)

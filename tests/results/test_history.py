"""The history of a run: its probes and components are found by name and by number."""

from __future__ import annotations

import re

import numpy as np
import pytest

from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.results.history import TIME_LABEL, History, energy_labels

LABELS = (TIME_LABEL, "tip.x [m]", "tip.y [m]", "left tip [Pa]", *energy_labels(2))
ENERGIES = [0.0] * len(ENERGY_NAMES)
HISTORY = History(LABELS, [(0.1 * row, 1.0 + row, 2.0 + row, 3.0 + row, *ENERGIES) for row in range(3)])


@pytest.mark.parametrize(
    ("name", "component", "first"),
    [("tip", 0, 1.0), ("tip", 1, 2.0), ("tip", "x", 1.0), ("tip", "y", 2.0), ("left tip", 0, 3.0)],
)
def test_components_are_found_by_number_and_by_name(name: str, component: int | str, first: float) -> None:
    np.testing.assert_array_equal(HISTORY.probe(name, component), first + np.arange(3))


@pytest.mark.parametrize(
    ("name", "component", "message"),
    [
        ("Tip", "x", "there is no probe 'Tip', there are: tip, left tip"),
        ("energy", 0, "there is no probe 'energy', there are: tip, left tip"),
        ("tip", 2, "probe 'tip' has no component 2, its components are: x, y"),
        ("tip", -1, "probe 'tip' has no component -1, its components are: x, y"),
        ("tip", "z", "probe 'tip' has no component 'z', its components are: x, y"),
        ("left tip", "x", "probe 'left tip' has no component 'x', its components are: a single one, 0"),
    ],
)
def test_a_missing_probe_or_component_is_named_with_those_there_are(
    name: str, component: int | str, message: str
) -> None:
    with pytest.raises(KeyError, match=re.escape(message)):
        HISTORY.probe(name, component)


def test_the_probes_of_a_history() -> None:
    assert HISTORY.probes == {"tip": ("x", "y"), "left tip": ("",)}
    assert HISTORY.label("tip", "y") == "tip.y [m]"

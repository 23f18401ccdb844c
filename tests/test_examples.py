"""The examples at reduced size, for the numbers that they promise."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def test_compare_models() -> None:
    main = runpy.run_path(str(EXAMPLES / "compare_models.py"))["main"]
    errors = main(layers=(4, 8), duration=0.06)
    assert errors["springs", 4] == pytest.approx(-0.048, abs=0.003)
    assert errors["springs", 8] == pytest.approx(-0.017, abs=0.002)
    assert abs(errors["hamiltonian", 4]) < 0.005
    assert abs(errors["hamiltonian", 8]) < 0.003

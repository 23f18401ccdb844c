"""How a scene is refused that cannot be run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from warp_mps.errors import InputError

# makes the fields of a scene
Fields = Callable[[], dict[str, Any]]


def named(value: object) -> str:
    """Name of a set of parameters: its texts."""
    return value[:40] if isinstance(value, str) else ""


def assert_refused(make: Callable[[], object], where: str, attribute: str, reason: str) -> None:
    """Check that making a scene is refused in one line with the place, the attribute, and a part of the reason."""
    with pytest.raises(InputError) as refusal:
        make()
    error = refusal.value
    assert (error.where, error.attribute) == (where, attribute)
    assert reason in error.reason
    assert str(error) == f"{where} {attribute}: {error.reason}"
    assert "\n" not in str(error)

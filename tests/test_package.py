"""The package as a whole: its public names."""

from __future__ import annotations

import pytest

import warp_mps


@pytest.mark.parametrize("name", warp_mps.__all__)
def test_every_public_name_leads_to_something_documented(name: str) -> None:
    assert getattr(warp_mps, name).__doc__


def test_what_is_not_public_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = warp_mps.nothing

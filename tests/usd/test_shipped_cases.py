"""Cases by name and by path."""

from __future__ import annotations

from pathlib import Path

import pytest

from warp_mps.errors import InputError
from warp_mps.usd.shipped_cases import find_case, shipped_cases


def test_a_name_and_a_path_lead_to_the_same_stage() -> None:
    path = shipped_cases()["ring_collision"]
    assert find_case("ring_collision") == path
    assert find_case(str(path)) == path


@pytest.mark.parametrize("case", ["none", "none.usda", "folder/none"])
def test_what_leads_nowhere(case: str) -> None:
    with pytest.raises(InputError, match=r"no such file|neither a file nor a shipped case"):
        find_case(case)


def test_a_file_comes_before_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ring_collision.usda").write_text("#usda 1.0\n")
    assert find_case("ring_collision.usda") == Path("ring_collision.usda")

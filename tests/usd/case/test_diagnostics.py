"""What is said of a stage that USD cannot read: the line of the file, and nothing of USD's own source."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.usd.case.test_refusals import refusal


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            'def "A"\n{\n    double x.spline = { 1: 5; pre held }\n}\n',
            "line 4: cannot be parsed at 'pre held }' in </A.x>",
        ),
        ('de "A" {}\n', "line 2: cannot be parsed at 'de \"A\" {}' in </>"),
        (
            'def "A"\n{\n    double3 x = (1, 2)\n}\n',
            "line 4: Error parsing tuple value: Failed to parse value at '(1, 2)'",
        ),
        ('def "A" {}\ndef "A" {}\n', "line 3: Duplicate prim 'A'"),
        ('def "1A" {}\n', "line 2: '1A' is not a valid prim name"),
        ('def "A" ( inherits = </A> ) {}\n', "Cycle detected"),
    ],
)
def test_errors_of_usd_name_the_line(tmp_path: Path, text: str, reason: str) -> None:
    folder = tmp_path / "a folder"
    folder.mkdir()
    (folder / "case.usda").write_text("#usda 1.0\n" + text)
    said = refusal(folder / "case.usda").reason
    assert reason in said
    for part in ("pxr", "::", "USD/", "anon:", "sub-part"):
        assert part not in said

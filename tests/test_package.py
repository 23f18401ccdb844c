"""The package as a whole: its public names and the README's first simulation."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import warp_mps

README = Path(__file__).resolve().parent.parent / "README.md"


@pytest.mark.parametrize("name", warp_mps.__all__)
def test_every_public_name_leads_to_something_documented(name: str) -> None:
    assert getattr(warp_mps, name).__doc__


def test_what_is_not_public_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = warp_mps.nothing


@pytest.mark.parametrize(("number", "folder"), [(0, "first"), (1, "dam"), (2, "flap"), (3, "baffle")])
def test_the_first_simulations_of_the_readme_run(
    number: int, folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    code = blocks[number]
    if folder == "baffle":  # with what moves: longer, and run for a moment
        code = code.replace("duration=1.0", "duration=0.05")
    else:
        assert len([line for line in code.splitlines() if line.strip()]) <= 9
    monkeypatch.chdir(tmp_path)
    scope: dict = {}
    if folder == "flap":  # goes on from the one before
        exec(re.sub(r"summary = .*", "", blocks[number - 1]), scope)
    exec(code, scope)
    assert scope["summary"].status == "done"
    assert scope["summary"].case == folder
    assert Path(f"runs/{folder}/run.usdc").exists()

"""One new field of a class of the scene is all that a new attribute of a stage takes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import pytest

from tests.scenes import block
from tests.usd.case.stages import write
from warp_mps.errors import InputError
from warp_mps.results.settings import scene_settings
from warp_mps.scene import Load, Scene
from warp_mps.scene.fields import attribute, described
from warp_mps.shapes import Box
from warp_mps.usd import schema_source
from warp_mps.usd.case import attributes, read
from warp_mps.usd.case.save import save_stage


@described
@dataclass(frozen=True, kw_only=True)
class ReachingLoad(Load):
    """A load with two fields more."""

    reach: float = field(default=0.5, metadata=attribute("mps:reach", unit="m", minimum=0.0, maximum=2.0))
    """How far the load reaches beyond `frequency`."""
    decay: Literal["linear", "none"] = field(default="none", metadata=attribute("mps:decay"))
    """How the load decays."""


LOAD = ("Cube", 'token mps:role = "load"', "double3 mps:force = (1, 0, 0)", "double size = 1")


@pytest.fixture(autouse=True)
def _more_fields(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(attributes.CLASSES, "load", ReachingLoad)
    monkeypatch.setitem(attributes.TABLE, "load", attributes.stage_attributes("load"))
    monkeypatch.setattr(read, "Load", ReachingLoad)


def test_it_is_read_in_the_units_of_the_stage(tmp_path: Path) -> None:
    scene = read.read_stage(write(tmp_path, length=0.01, Push=(*LOAD, "double mps:reach = 30")))
    assert scene.loads[0].reach == pytest.approx(0.3)  # type: ignore[attr-defined]
    scene = read.read_stage(write(tmp_path, Push=LOAD), overrides={"/Push.mps:reach": "1.5"})
    assert scene.loads[0].reach == 1.5  # type: ignore[attr-defined]
    assert scene_settings(scene)["loads"]["Push"]["reach [m]"] == 1.5


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("double mps:reach = 3", "mps:reach: is 3, must be finite and between 0 and 2"),
        ('token mps:decay = "cubic"', "mps:decay: is 'cubic', must be one of: linear, none"),
        ('string mps:reach = "1"', "mps:reach: must be double, not string"),
    ],
)
def test_it_is_checked(tmp_path: Path, line: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        read.read_stage(write(tmp_path, Push=(*LOAD, line)))
    with pytest.raises(InputError, match=r"load 'push' decay: is 'cubic', must be one of: linear, none"):
        made(decay="cubic")


def test_it_is_saved_and_read_back(tmp_path: Path) -> None:
    scene = made(reach=0.25, decay="linear")
    save_stage(scene, tmp_path / "case.usda")
    assert "double mps:reach = 0.25" in (tmp_path / "case.usda").read_text()
    back = read.read_stage(tmp_path / "case.usda").loads[0]
    assert replace(back, path="") == replace(scene.loads[0], region=back.region)


def test_it_is_part_of_the_schema_and_of_the_reference() -> None:
    assert "double mps:reach (" in schema_source.generated_schema()
    row = "| `mps:reach` | double | L | 0.5 m | 0 to 2 | How far the load reaches beyond `mps:frequency`. |"
    assert row in schema_source.reference_table("load")
    assert "reach: How far the load reaches beyond `frequency`. [m; 0 to 2; mps:reach]" in (ReachingLoad.__doc__ or "")


def made(**fields: object) -> Scene:
    load = ReachingLoad(**{"name": "push", "region": Box((1, 1)), "force": (1.0, 0.0), **fields})  # type: ignore[arg-type]
    return Scene(bodies=(block(2),), loads=(load,), duration=1.0)

"""The codeless schema and the reference of the attributes: both say what the table says."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from warp_mps.usd import SCHEMA
from warp_mps.usd.case.attributes import TABLE
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.schema_source import generated_schema, plug_info, reference, reference_table, schema_name

README = Path(__file__).parents[2] / "stages" / "README.md"

QUESTION = """
import json
from warp_mps.usd import register_schema
register_schema()
register_schema()
from pxr import Usd
registry = Usd.SchemaRegistry()
names = {names}
found = {{name: registry.FindAppliedAPIPrimDefinition(name).GetPropertyNames() for name in names}}
print(json.dumps(found))
"""


def test_the_shipped_files_are_those_of_the_table() -> None:
    assert (SCHEMA / "plugInfo.json").read_text(encoding="utf-8") == plug_info()
    assert (SCHEMA / "generatedSchema.usda").read_text(encoding="utf-8") == generated_schema()


def test_usd_finds_the_schemas() -> None:
    names = [schema_name(role) for role in TABLE]
    command = [sys.executable, "-c", QUESTION.format(names=names)]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    for role, rows in TABLE.items():
        expected = {name for name, row in rows.items() if row.own}
        assert set(found[schema_name(role)]) - {"mps:role"} == expected


def test_the_reference_is_that_of_the_table() -> None:
    text = README.read_text(encoding="utf-8")
    assert reference(text) == text, "regenerate it: python -m warp_mps.usd.schema_source"
    assert all(reference_table(role) in text for role in TABLE)


def test_every_attribute_has_a_meaning() -> None:
    assert [row.name for rows in TABLE.values() for row in rows.values() if len(row.meaning) < 10] == []


def test_the_example_of_the_reference_can_be_read(tmp_path: Path) -> None:
    example = README.read_text(encoding="utf-8").split("```")[1].strip()
    (tmp_path / "cantilever.usda").write_text(example, encoding="utf-8")
    scene = read_stage(tmp_path / "cantilever.usda")
    assert [len(part) for part in (scene.bodies, scene.supports, scene.probes, scene.measurements)] == [1, 1, 1, 1]
    assert scene.gravity == pytest.approx((0, -9.81))
    assert scene.bodies[0].material.youngs_modulus == 2.1e11

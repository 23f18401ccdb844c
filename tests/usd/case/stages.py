"""Stages for the tests."""

from __future__ import annotations

from pathlib import Path

HEAD = '#usda 1.0\n(\n    metersPerUnit = {length}\n    kilogramsPerUnit = {mass}\n    upAxis = "{up}"\n)\n'
PARTS = {
    "Scene": ("PhysicsScene", "int mps:dimension = 2", "double mps:duration = 2", "float physics:gravityMagnitude = 0"),
    "Steel": (
        "Material",
        "float physics:density = 7800",
        "double mps:youngsModulus = 2e11",
        "double mps:poissonsRatio = 0.3",
    ),
    "Beam": (
        "Cube",
        'token mps:role = "body"',
        "double mps:spacing = 0.1",
        "rel material:binding:physics = </Steel>",
        "double size = 1",
    ),
}


def write(
    folder: Path, *, length: float = 1.0, mass: float = 1.0, up: str = "Y", text: str = "", **parts: tuple[str, ...]
) -> Path:
    """Write the stage of one body, changed.

    Args:
        folder: Where to write.
        length: metersPerUnit.
        mass: kilogramsPerUnit.
        up: upAxis.
        text: More text of the stage.
        parts: Statements by prim that replace those of the same attribute; ``-name`` leaves one out, and a new prim's
            first statement is its type.
    """
    prims = [_prim(name, _merged(PARTS.get(name, ()), parts.get(name, ()))) for name in {**PARTS, **parts}]
    path = folder / "case.usda"
    path.write_text(HEAD.format(length=length, mass=mass, up=up) + "".join(prims) + text, encoding="utf-8")
    return path


def _merged(given: tuple[str, ...], changes: tuple[str, ...]) -> list[str]:
    if not given:
        return list(changes)
    changed = {_name(line): line for line in changes}
    kept = [line for line in given[1:] if _name(line) not in changed and f"-{_name(line)}" not in changes]
    return [given[0], *kept, *(line for line in changes if not line.startswith("-"))]


def _name(statement: str) -> str:
    return statement.partition(" =")[0].split()[-1]


def _prim(name: str, statements: list[str]) -> str:
    body = "".join(f"    {line}\n" for line in statements[1:])
    return f'def {statements[0]} "{name}"\n{{\n{body}}}\n'

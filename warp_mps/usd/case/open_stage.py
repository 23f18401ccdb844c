"""Opening a stage, with USD's diagnostics reduced to one line, and overriding attributes for one run."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from pxr import Sdf, Tf, Usd, UsdUtils

from warp_mps.core.native_output import native_errors
from warp_mps.errors import InputError
from warp_mps.usd import register_schema
from warp_mps.usd.case.attributes import ROLE, TABLE
from warp_mps.usd.case.diagnostics import composition_error, reason_of
from warp_mps.usd.case.isolated_open import BEYOND, BEYOND_MEANS, damaged
from warp_mps.usd.case.layers import check_layers

# The attributes that belong to any role; their types are those of the table, or this one.
_EXTRA_TYPES = {ROLE: "token"}
# notation of values that are not a single word or number, by the ending of the type's name
_NOTATIONS = {"token[]": '["a", "b"]', "3[]": "[(1, 0, 0)]", "3f[]": "[(1, 0, 0)]", "[]": "[0, 1]"}
_NOTATIONS |= dict.fromkeys(("3", "3f", "3d"), "(1, 0, 0)")


@contextmanager
def quiet(path: str | Path) -> Iterator[None]:
    """Keep USD from writing its diagnostics to the terminal; errors are raised all the same.

    Args:
        path: File of the stage that is read or written meanwhile.

    Raises:
        InputError: The file refers to places beyond its end. The isolated process may have missed it: USD notices
            only where nothing else lies there in memory.
    """
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    with native_errors() as diverted:
        try:
            yield
        finally:
            delegate.TakeUncoalescedDiagnostics()
            del delegate
        diverted.seek(0)
        beyond = BEYOND in diverted.read()
    if beyond:
        raise damaged(path, BEYOND_MEANS)


@contextmanager
def refuse_damage(path: str | Path) -> Iterator[None]:
    """Say in one line that values of a file cannot be read: USD looks at them when they are first asked for.

    Raises:
        InputError: A value cannot be read.
    """
    try:
        yield
    except Tf.ErrorException as error:
        raise damaged(path, reason_of(error)) from None


def open_stage(
    path: str | Path, *, overrides: Mapping[str, str] | None = None, allow_external: bool = False
) -> Usd.Stage:
    """Open a stage and change some of its attributes in memory.

    Args:
        path: File of the stage.
        allow_external: Whether it may refer to files outside its folder.
        overrides: Texts of values by ``/Prim.attribute``, in the notation of a .usda file; tokens and strings need
            no quotes.

    Returns:
        The stage; its file is not changed.

    Raises:
        InputError: The file is missing or not a stage, its path is not UTF-8, something it refers to is missing or
            outside its folder, or an override is wrong.
    """
    register_schema()
    try:
        os.fspath(path).encode()
    except UnicodeEncodeError:
        raise InputError(ascii(os.fspath(path)), "", "cannot be read: its path is not UTF-8, which USD needs") from None
    if not os.path.isfile(path):
        raise InputError(str(path), "", "there is no such file")
    with quiet(path):
        try:
            # kept until the stage is composed of them
            layers = check_layers(path, allow_external=allow_external)
            stage = Usd.Stage.Open(layers[0])
        except (Tf.ErrorException, UnicodeDecodeError) as error:
            raise InputError(str(path), "", f"is not a USD stage that can be read: {reason_of(error)}") from None
        errors = stage.GetCompositionErrors()
        if errors:
            raise InputError(str(path), "", composition_error(errors[0]))
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            for target, text in (overrides or {}).items():
                _override(stage, target, text)
    return stage


def _override(stage: Usd.Stage, target: str, text: str) -> None:
    prim_path, _, name = target.partition(".")
    valid = Sdf.Path.IsValidPathString(prim_path) and Sdf.Path(prim_path).IsAbsoluteRootOrPrimPath()
    prim = stage.GetPrimAtPath(prim_path) if valid else None
    if not prim or prim.IsPseudoRoot():
        raise InputError(prim_path, name, "cannot be set: there is no such prim in the stage")
    if not Sdf.Path.IsValidNamespacedIdentifier(name):
        raise InputError(prim_path, name, f"cannot be set: {target!r} is not /Prim.attribute")
    kind = _kind(prim, name)
    if kind == "rel":
        _retarget(prim, name, text)
        return
    prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind)).Set(_parse(prim_path, name, kind, text))


def _kind(prim: Usd.Prim, name: str) -> str:
    """Type of an attribute: its own if the prim has it, else that of the table."""
    if prim.HasRelationship(name):
        return "rel"
    if prim.HasAttribute(name):
        return str(prim.GetAttribute(name).GetTypeName())
    kinds = [rows[name].kind for rows in TABLE.values() if name in rows]
    kind = kinds[0] if kinds else _EXTRA_TYPES.get(name)
    if kind is None:
        known = [*_EXTRA_TYPES, *(word for rows in TABLE.values() for word in rows)]
        meant = "".join(f"; did you mean {word}?" for word in difflib.get_close_matches(name, known, n=1))
        raise InputError(str(prim.GetPath()), name, f"cannot be set: there is no such attribute{meant}")
    return kind


def _retarget(prim: Usd.Prim, name: str, text: str) -> None:
    paths = [part.strip("<>") for part in text.replace(",", " ").split()]
    if not all(Sdf.Path.IsValidPathString(path) for path in paths):
        raise InputError(str(prim.GetPath()), name, f"{text!r} is not a list of prim paths")
    prim.CreateRelationship(name).SetTargets(paths)


def _parse(prim_path: str, name: str, kind: str, text: str) -> object:
    """The value that a text means, read by USD itself so that the notation is that of a .usda file."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    written = json.dumps(text.strip("\"'"), ensure_ascii=False) if kind in ("token", "string", "asset") else text
    try:
        # USD would cut the fraction off and take further lines for further attributes.
        good = "\n" not in written and (kind != "int" or int(text) is not None)
        good = good and layer.ImportFromString(f'#usda 1.0\nover "x"\n{{\n    {kind} a = {written}\n}}\n')
    except (Tf.ErrorException, ValueError):
        good = False
    attribute = layer.GetAttributeAtPath("/x.a") if good else None
    if attribute is None or attribute.default is None:
        example = next((f", such as {shown}" for ending, shown in _NOTATIONS.items() if kind.endswith(ending)), "")
        raise InputError(prim_path, name, f"{text!r} is not of type {kind}{example}")
    return attribute.default

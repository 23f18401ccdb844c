"""The files that a stage is made of, looked at before USD composes them.

A stage may come from anywhere. What it refers to must lie beside it, for a stage that reads other files of the user is
a surprise. USD's readers recurse, and trust the tables of binary files: nesting is counted first, and a stage that is
binary, or composed of many parts, is opened in a process of its own before this one does
(`warp_mps.usd.case.isolated_open`), which takes some tenths of a second.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from pxr import Ar, Sdf, Tf

from warp_mps.errors import InputError
from warp_mps.usd.case.diagnostics import reason_of
from warp_mps.usd.case.isolated_open import open_isolated

# nested brackets; USD's reader fails beyond some 1e4
DEEPEST = 500
# arcs of composition that cannot multiply to more than some hundred copies
FEW = 16
# tokens of a .usda file that are neither strings, asset paths nor comments
_CODE = re.compile(
    rb'([^"\'@#/]+|/(?![/*]))|"""(?:[^\\]|\\.)*?"""|\'\'\'(?:[^\\]|\\.)*?\'\'\'|"(?:[^\\\n"]|\\.)*"|\'(?:[^\\\n\']|\\.)*\''
    rb"|@@@.*?@@@|@[^@\n]*@|#[^\n]*|//[^\n]*|/\*.*?\*/|.",
    re.DOTALL,
)
# whole numbers of a case, of which USD would cut off a fraction
_WHOLE = re.compile(rb"\bint\s+(mps:[\w:]+)\s*=\s*([-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)")
_NO_BRACKETS = bytes({*range(256)} - {*b"([{}])"})
# a scheme such as http://, but not the letter of a drive
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")


def check_layers(path: str | Path, *, allow_external: bool, tried: bool = False) -> list[Sdf.Layer]:
    """Open every file that a stage is made of.

    Args:
        path: File of the stage.
        allow_external: Whether it may refer to files outside its folder.
        tried: Whether it is known that USD survives it.

    Returns:
        The layers; the first is the stage's own.

    Raises:
        InputError: It refers to a file outside its folder, a file is not one that USD can read, or USD fails on it.
    """
    home = Path(os.path.abspath(path)).parent.resolve()
    waiting, seen, layers, arcs = [str(path)], set[str](), list[Sdf.Layer](), 0
    while waiting:
        file = waiting.pop()
        real = os.path.realpath(file)
        if real in seen:
            continue
        seen.add(real)
        if _is_binary(file) and not tried:
            open_isolated(path, allow_external=allow_external)
            tried = True
        layers.append(_open(file))
        places = _arcs(layers[-1])
        arcs += len(places)
        waiting.extend(_dependencies(layers[-1], dict(places), home, allow_external))
    if arcs > FEW and not tried:
        open_isolated(path, allow_external=allow_external)
    return layers


def _arcs(layer: Sdf.Layer) -> list[tuple[str, tuple[str, str]]]:
    """The parts that a layer is composed of: asset (empty for the layer itself), place and field.

    Raises:
        InputError: It has value clips, which hold values that vary in time in further files.
    """
    found = [(asset, (layer.identifier, "subLayers")) for asset in layer.subLayerPaths]

    def look(path: Sdf.Path) -> None:
        prim, where = layer.GetPrimAtPath(path), str(path.StripAllVariantSelections())
        if not prim:
            return  # an attribute, or a set of variants
        if prim.HasInfo("clips"):
            raise InputError(where, "clips", "cannot be used: no attribute of a case may vary in time")
        for name in ("references", "payload", "inheritPaths", "specializes"):
            if prim.HasInfo(name):
                items = prim.GetInfo(name).GetAddedOrExplicitItems()
                found.extend((getattr(item, "assetPath", ""), (where, name)) for item in items)

    layer.Traverse("/", look)
    return found


def _dependencies(
    layer: Sdf.Layer, places: Mapping[str, tuple[str, str]], home: Path, allow_external: bool
) -> Iterator[str]:
    """Existing files that a layer refers to; USD reports the missing ones."""
    for asset in layer.GetCompositionAssetDependencies():
        if not asset:
            continue
        where, field = places.get(asset, (layer.identifier, ""))
        if asset.startswith("`") or _SCHEME.match(asset):
            raise InputError(where, field, f"refers to @{asset}@, which is not the path of a file")
        identifier = Sdf.ComputeAssetPathRelativeToLayer(layer, asset)
        found = Ar.GetResolver().Resolve(identifier).GetPathString()
        file = Ar.SplitPackageRelativePathOuter(found or identifier)[0]
        if not allow_external and (found or os.path.isabs(file)) and not _within(file, home):
            reason = f"refers to @{asset}@, outside the folder of the stage; allow it by --allow-external"
            raise InputError(where, field, reason)
        if found:
            yield found


def _within(file: str, home: Path) -> bool:
    """Whether a file lies in a folder or below, with symbolic links resolved."""
    return Path(os.path.realpath(file)).is_relative_to(home)


def _open(file: str) -> Sdf.Layer:
    """The layer of a file as it is now, which USD may hold in an earlier state.

    A layer that this process has changed and not saved stays as it is: it is the user's.

    Raises:
        InputError: USD cannot read it.
    """
    try:
        layer = Sdf.Layer.FindOrOpen(file)
        if layer and not layer.dirty:
            layer.Reload()
    except (Tf.ErrorException, UnicodeDecodeError) as error:
        # the message of USD on a damaged file need not be valid text
        raise InputError(file, "", f"is not a USD stage that can be read: {reason_of(error)}") from None
    if not layer:
        raise InputError(file, "", "is not a USD stage that can be read: unknown format")
    return layer


def _is_binary(file: str) -> bool:
    """Whether a file is binary, or in a package that may hold such.

    Raises:
        InputError: It is not a regular file, it is empty, not UTF-8, or nested too deep.
    """
    if Ar.IsPackageRelativePath(file):
        return True
    try:
        # a device or a pipe may never end
        if not stat.S_ISREG(os.stat(file).st_mode):
            raise InputError(file, "", "is not a file")
        with open(file, "rb") as stream:
            data = stream.read(5)
            if data != b"#usda":
                if not data:
                    raise InputError(file, "", "is not a USD stage that can be read: it is empty")
                return True
            data += stream.read()
    except OSError as error:
        raise InputError(file, "", f"cannot be read: {error.strerror}") from None
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(file, "", f"is not a USD stage that can be read: line {line} is not UTF-8") from None
    code = b"".join(_CODE.findall(data))
    for name, number in _WHOLE.findall(code):
        if not float(number).is_integer():
            raise InputError(file, name.decode(), f"is {number.decode()}, must be a whole number")
    if _depth(code) > DEEPEST:
        raise InputError(file, "", f"is not a USD stage that can be read: more than {DEEPEST} nested brackets")
    return False


def _depth(code: bytes) -> int:
    """The greatest depth of nested brackets."""
    brackets = np.frombuffer(code.translate(None, _NO_BRACKETS), np.uint8)
    steps = np.where(np.isin(brackets, np.frombuffer(b"([{", np.uint8)), 1, -1)
    heights = np.cumsum(np.append(0, steps))
    return int((heights - np.minimum.accumulate(heights)).max())

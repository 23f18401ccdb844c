"""Damaged and forged files of results; each function changes one in a folder, and says what it did."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf

from tests.faults.mutations import Random, pick
from warp_mps.observers import checkpoint as cp

Mutation = Callable[[Path, Random], str]
# JSON of every type
VALUES = (
    *(None, True, False, 0, -1, 2, 3, 10**400, 1e308, -1e308, 1e-320, 0.5, "", "text", "2", [], {}, [1], ["a", None]),
    *({"a": 1}, {"a": None}, {"a": {"b": []}}, [[]], [{}], [[[1, 2], [3]]], "\ud800", "a\nb", "<script>", "x" * 5000),
    *(float("nan"), float("inf")),
)
CELLS = ("", "nan", "inf", "-inf", "1e308", "-1e308", "1e400", "text", "1,2", "\0", '"', "0x10", "-1", "\u0661", " ")
WILD = (float("nan"), float("inf"), -1e38, 1e38, 0.0, -1.0, 1e-40)


def summary(folder: Path, random: Random) -> str:
    """An item of run.json is another one, is missing, or is new; or its text is damaged."""
    path = folder / "run.json"
    if random.random() < 0.15:
        return damaged(path, random)
    data = json.loads(path.read_text())
    places = list(_places(data))
    for _ in range(int(pick(random, (1, 1, 1, 3)))):
        holder, key = pick(random, places)
        value = pick(random, VALUES)
        try:
            if random.random() < 0.15:
                del holder[key]
            else:
                holder[key] = value
        except (KeyError, IndexError):
            continue
    path.write_text(json.dumps(data), encoding="utf-8")
    return f"{key!r} = {str(value)[:30]!r}"


def _places(item: Any) -> Any:
    keys = item.keys() if isinstance(item, dict) else range(len(item))
    for key in list(keys):
        yield item, key
        if isinstance(item[key], dict | list):
            yield from _places(item[key])


def history(folder: Path, random: Random) -> str:
    """Cells, rows, columns or names of probes.csv are others, missing or doubled; or its text is damaged."""
    path = folder / "probes.csv"
    how = pick(random, ("cell", "cell", "row", "column", "label", "order", "damage"))
    if how == "damage":
        return damaged(path, random)
    rows = [line.split(",") for line in path.read_text().splitlines()]
    row, column = int(random.integers(len(rows))), int(random.integers(len(rows[0])))
    if how == "cell":
        rows[row][column] = pick(random, CELLS)
    elif how == "label":
        rows[0][column] = pick(random, (*CELLS, *rows[0], "tip.x [m]", "time [s]"))
    elif how == "row":
        rows[row : row + int(random.integers(3))] = [rows[int(random.integers(len(rows)))]]
    elif how == "order":
        rows[1:] = [rows[1 + k] for k in random.permutation(len(rows) - 1)]
    else:
        keep = int(random.integers(1, len(rows[0])))
        rows = [line[:keep] for line in rows]
    path.write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    return f"{how} {row} {column}"


def animation(folder: Path, random: Random) -> str:
    """Arrays of run.usdc are short, long, NaN or of another type, or prims and units are others; or bytes are."""
    path = folder / "run.usdc"
    if random.random() < 0.25:
        return damaged(path, random)
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    if random.random() < 0.2:
        name = pick(random, ("timeCodesPerSecond", "framesPerSecond", "metersPerUnit", "kilogramsPerUnit", "upAxis"))
        value = pick(random, ("Y", "X") if name == "upAxis" else (0.0, -1.0, *WILD, 1e-300, 1e300))
        layer.pseudoRoot.SetInfo(name, value)
        said = f"{name} = {value}"
    else:
        said = _change_attribute(layer, random)
    layer.Export(str(path))
    return said


def _change_attribute(layer: Any, random: Random) -> str:
    bodies = list(layer.GetPrimAtPath("/Result").nameChildren)
    body = pick(random, bodies)
    spec = pick(random, list(body.attributes))
    named, codes = str(spec.path), list(layer.ListTimeSamplesForPath(spec.path))
    how = pick(random, ("short", "long", "wild", "remove", "none", "sample", "body", "type"))
    if how == "body":
        del layer.GetPrimAtPath("/Result").nameChildren[body.name]
    elif how == "remove":
        body.RemoveProperty(spec)
    elif how == "type":
        body.SetInfo("typeName", pick(random, ("Mesh", "Xform", "", "PointInstancer")))
    elif how == "sample":
        layer.SetTimeSample(spec.path, float(pick(random, (-5.0, 1e9, 1e300, 0.5))), _value(layer, spec, codes))
    else:
        value = _changed(_value(layer, spec, codes), how, random)
        for code in codes if random.random() < 0.5 else codes[:1]:
            layer.SetTimeSample(spec.path, code, value)
        if not codes:
            spec.default = value
    return f"{named} {how}"


def _value(layer: Any, spec: Any, codes: list[float]) -> Any:
    return layer.QueryTimeSample(spec.path, codes[0]) if codes else spec.default


def _changed(value: Any, how: str, random: Random) -> Any:
    """A shorter, longer or wild array of the same type."""
    if not hasattr(value, "__len__") or isinstance(value, str) or len(value) == 0:
        return value
    items = list(value)
    if how == "short":
        items = items[: int(random.integers(len(items)))]
    elif how == "long":
        items = items + items[:1] * int(pick(random, (1, len(items))))
    elif how == "none":
        items = []
    else:
        one = items[int(random.integers(len(items)))]
        wild = pick(random, WILD)
        filled = type(one)(*[wild] * 3) if isinstance(one, Gf.Vec3f) else wild if isinstance(one, float) else one
        items[int(random.integers(len(items)))] = filled
    return type(value)(items)


def checkpoint(folder: Path, random: Random) -> str:
    """Arrays of the checkpoint are others, and its digest is right; or its bytes are damaged."""
    path = folder / cp.NAME
    (folder / cp.PREVIOUS).unlink(missing_ok=True)
    if random.random() < 0.2:
        return damaged(path, random)
    with np.load(path) as file:
        entries = {name: file[name] for name in file.files}
    metadata = json.loads(str(entries.pop(cp.METADATA)))
    names = sorted(entries)
    name = pick(random, names)
    how = pick(random, ("short", "long", "complex", "nan", "text", "remove", "scalar", "whole", "wide", "metadata"))
    integers = [name for name in names if entries[name].dtype.kind == "i" and entries[name].size]
    if random.random() < 0.3:
        how, name = "index", pick(random, integers)
        value = int(pick(random, (-1, -(2**31), 2**31 - 1, 10**6)))
        changed = entries[name].copy()
        changed.flat[int(random.integers(changed.size))] = value
        entries[name] = changed
    entries |= {name: _array(entries[name], how)}
    if how == "remove":
        del entries[name]
    if how == "metadata":
        name = pick(random, sorted(set(metadata) - {"sha256", "version", "fingerprint"}))
        metadata[name] = pick(random, VALUES)
    state = {key.removeprefix(cp.PREFIX): np.asarray(array) for key, array in entries.items()}
    metadata.pop("sha256")
    metadata["sha256"] = _digest(metadata, state)
    np.savez(path, **entries, **{cp.METADATA: np.array(json.dumps(metadata))})
    return f"{name} {how}"


def _array(array: np.ndarray, how: str) -> np.ndarray:
    if how == "nan" and array.dtype.kind == "f":
        return np.full_like(array, np.nan)
    changes: dict[str, Callable[[], np.ndarray]] = {
        "short": lambda: array.ravel()[: array.size // 2],
        "long": lambda: np.concatenate([array.ravel(), array.ravel()]),
        "complex": lambda: array.astype(complex),
        "text": lambda: array.astype("U"),
        "scalar": lambda: np.array(array.ravel()[0]) if array.size else np.array(0),
        "whole": lambda: array.astype(np.int8) if array.dtype.kind == "f" else array.astype(float) + 0.5,
        "wide": lambda: array[..., None],
    }
    return changes[how]() if how in changes else array


def _digest(metadata: dict, arrays: dict[str, np.ndarray]) -> str:
    """The digest as the writer of checkpoints makes it: whoever forges a file can do the same."""
    digest = hashlib.sha256(json.dumps(metadata, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {np.shape(arrays[name])}\n".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def damaged(path: Path, random: Random) -> str:
    """The file is cut short, or some bytes are others."""
    data = bytearray(path.read_bytes())
    if random.random() < 0.3:
        data = data[: int(random.integers(len(data)))]
    else:
        for _ in range(int(pick(random, (1, 2, 20)))):
            data[int(random.integers(len(data)))] = int(random.integers(256))
    path.write_bytes(bytes(data))
    return f"{path.name} damaged"


MUTATIONS: dict[str, Mutation] = {
    "run.json": summary,
    "probes.csv": history,
    "run.usdc": animation,
    "checkpoint.npz": checkpoint,
}

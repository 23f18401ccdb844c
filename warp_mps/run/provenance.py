"""Where a result comes from: versions, settings of the run, and a hash of the case that a restart must match."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene
from warp_mps.scene.body_force import function_identity
from warp_mps.scene.choices import PrecisionName
from warp_mps.version import __version__

# fields that decide no number of a run, and longest text of a setting that is given in full
UNIMPORTANT = {"duration", "measurements", "description", "path", "remarks"}
LONGEST = 60


def fingerprint(scene: Scene, precision: PrecisionName) -> str:
    """A hash of everything that decides a run's numbers; how long it runs is not among it."""
    return hashlib.sha256(repr(sorted(identity(scene, precision).items())).encode()).hexdigest()


def identity(scene: Scene, precision: PrecisionName) -> dict[str, str]:
    """Everything that decides a run's numbers, by names such as ``bodies.beam.spacing``; long values as their hash."""
    found: dict[str, str] = {"precision": precision}
    for item in dataclasses.fields(scene):
        if item.name not in UNIMPORTANT:
            found |= _texts(item.name, getattr(scene, item.name))
    return found


def _texts(name: str, value: Any) -> dict[str, str]:
    if dataclasses.is_dataclass(value):
        # of two classes with the same fields, such as two shapes
        found = {f"{name}.kind": type(value).__name__}
        for item in dataclasses.fields(value):
            if item.name not in ("name", "path"):
                found |= _texts(f"{name}.{item.name}", getattr(value, item.name))
        return found
    if isinstance(value, list | tuple) and any(map(dataclasses.is_dataclass, value)):
        found = {name: ", ".join(str(getattr(item, "name", number)) for number, item in enumerate(value))}
        for number, item in enumerate(value):
            found |= _texts(f"{name}.{getattr(item, 'name', number)}", item)
        return found
    return {name: _text(value)}


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        data = np.ascontiguousarray(value)
        return f"array {data.shape} {hashlib.sha256(data.dtype.str.encode() + data.tobytes()).hexdigest()[:16]}"
    text = function_identity(value) if callable(value) else repr(value)
    return text if len(text) <= LONGEST else f"{text[:20]}... {hashlib.sha256(text.encode()).hexdigest()[:16]}"


def differences(records: Mapping[str, Any], versions: Mapping[str, str], device: str) -> list[str]:
    """Lines on what a checkpoint was computed with, where that is not what goes on."""
    found = records.get("versions")
    before = found if isinstance(found, dict) else {}
    others = [name for name, now in versions.items() if before.get(name, now) != now]
    changed = [f"{name} {before[name]} then, {versions[name]} now" for name in others]
    if records.get("device", device) != device:
        changed.append(f"{records['device']} then, {device} now")
    reason = "the checkpoint was computed otherwise, and the run goes on with other bits"
    return [f"{reason}: {', '.join(changed)}"] if changed else []


def versions() -> dict[str, str]:
    """Versions of this program and of what it stands on."""
    found = {"warp_mps": __version__}
    for name in ("warp-lang", "numpy", "usd-core"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def provenance(simulation: Simulation) -> dict[str, str | float | int]:
    """Origin of a result, as run.usdc states it, by name."""
    scene = simulation.scene
    return {
        "case": scene.name,
        "program": f"warp_mps {__version__}",
        "model": scene.flow.scheme if scene.fluids else scene.elasticity.model,
        "analysis": scene.analysis,
        "device": simulation.device,
        "precision": simulation.precision,
        "time step [s]": simulation.dt,
    }

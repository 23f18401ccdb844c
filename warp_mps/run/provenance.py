"""Where a result comes from: versions, settings of the run, and a hash of the case that a restart must match."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene
from warp_mps.scene.choices import PrecisionName
from warp_mps.version import __version__


def fingerprint(scene: Scene, precision: PrecisionName) -> str:
    """A hash of everything that decides a run's numbers; how long it runs is not among it."""
    with np.printoptions(threshold=10**9, precision=17):
        text = repr((replace(scene, duration=1.0, measurements=(), description="", path="scene"), precision))
    return hashlib.sha256(text.encode()).hexdigest()


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
